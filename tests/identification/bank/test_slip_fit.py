"""Maxwell-slip models of recordings made by one, and of rubbing that is none."""

import numpy as np
import pytest

from opensuction.hysteresis.bank import maxwell_slip
from opensuction.hysteresis.bank.maxwell_slip import MaxwellSlip
from opensuction.identification import record, workbench
from opensuction.identification.estimator import superposition
from opensuction.identification.estimator.superposition import SlipFit
from opensuction.kernel.record import Array

PERIOD_S = 0.01
TIME_S: Array = PERIOD_S * np.arange(4000, dtype=np.float64)


def _sweep(seed: int) -> Array:
    """Strokes of up to 60 mm at .1 to 2 Hz."""
    rng = np.random.default_rng(seed)
    rates = 0.1 * 20.0 ** rng.uniform(0.0, 1.0, TIME_S.size // 200)
    phase = np.cumsum(2.0 * np.pi * PERIOD_S * np.repeat(rates, 200))
    return np.asarray(30.0 - 30.0 * np.cos(phase) * (0.7 + 0.3 * np.cos(0.37 * TIME_S)))


HEAD = _sweep(1)
FRICTION = MaxwellSlip(
    slope=0.2,
    reaches_mm=np.array([1.5, 7.0]),
    gains=np.array([[3.0, 1.0, 0.5], [0.1, 1.0, 2.0]]),
    speeds_mm_s=np.array([40.0]),
    drags_mm=np.array([6.0]),
    lag_s=0.04,
    period_s=PERIOD_S,
    offset_mm=5.0,
)


def _force(model: MaxwellSlip, head: Array) -> Array:
    return maxwell_slip.simulate(
        model, head, maxwell_slip.start_elements_mm(model, float(head[0]), 0.0)
    )


def _noise(seed: int, height: float) -> Array:
    return height * np.random.default_rng(seed).standard_normal(TIME_S.size)


def _percent(rest: Array, output: Array) -> float:
    return 100.0 * float(np.std(rest)) / float(np.ptp(output))


def _fit(output: Array, period_s: float | None) -> SlipFit:
    half = TIME_S.size // 2
    return superposition.fit_slip_fit(
        HEAD[:half], output[:half], record.cut(HEAD[:half], TIME_S[:half]), period_s
    )


def _miss(found: SlipFit, head: Array, output: Array) -> float:
    """Error of the second half in percent of the output's range."""
    start = maxwell_slip.start_elements_mm(found.record, float(head[0]), found.past)
    rest = output - maxwell_slip.simulate(found.record, head, start)
    return _percent(rest[head.size // 2 :], output)


def test_reaches_and_speeds_off_its_grid_are_followed_to_a_percent() -> None:
    force = _force(FRICTION, HEAD)
    found = _fit(force + _noise(2, 0.1), PERIOD_S)
    assert found.record.drags_mm.size > 0
    assert found.record.period_s == PERIOD_S
    assert _miss(found, HEAD, force) < 1.0
    # As fast a drag as was seen, not one that grows beyond it.
    assert found.record.speeds_mm_s.max() <= np.abs(np.diff(HEAD)).max() / PERIOD_S


def test_without_a_clock_there_is_no_drag_and_that_is_seen() -> None:
    force = _force(FRICTION, HEAD)
    blind = _fit(force + _noise(3, 0.1), None)
    assert blind.record.drags_mm.size == 0
    assert _miss(blind, HEAD, force) > 3.0 * _miss(_fit(force, PERIOD_S), HEAD, force)


def test_a_recording_that_knows_no_speed_gets_no_drag() -> None:
    still = FRICTION._replace(speeds_mm_s=np.empty(0), drags_mm=np.empty(0))
    force = _force(still, HEAD)
    found = _fit(force + _noise(4, 0.1), PERIOD_S)
    assert found.record.drags_mm.size == 0
    assert _miss(found, HEAD, force) < 1.0


def test_units_do_not_matter() -> None:
    force = _force(FRICTION, HEAD) + _noise(5, 0.1)
    half = TIME_S.size // 2
    found = _fit(force, PERIOD_S)
    folds = record.cut(1e3 * HEAD[:half], 1e3 * TIME_S[:half])
    other = superposition.fit_slip_fit(
        1e3 * HEAD[:half], 50.0 - 7.0 * force[:half], folds, 1e3 * PERIOD_S
    )
    start = maxwell_slip.start_elements_mm(other.record, 1e3 * float(HEAD[0]), other.past)
    said = maxwell_slip.simulate(other.record, 1e3 * HEAD, start)
    own = maxwell_slip.simulate(
        found.record,
        HEAD,
        maxwell_slip.start_elements_mm(found.record, float(HEAD[0]), found.past),
    )
    assert said == pytest.approx(50.0 - 7.0 * own, abs=1e-6)


def test_it_is_recommended_where_friction_depends_on_speed_and_nowhere_else() -> None:
    force = _force(FRICTION, HEAD) + _noise(6, 0.1)
    best, *others = workbench.compare(HEAD, force, TIME_S, 0.5)
    assert best.model == "maxwell-slip"
    assert best.holdout_rmse_percent_of_range < 0.5 * min(
        each.holdout_rmse_percent_of_range for each in others
    )
    uneven = TIME_S + 0.004 * np.sin(np.arange(TIME_S.size))
    told = workbench.identify(HEAD, force, uneven, "maxwell-slip")
    assert any("maxwell-slip goes without drag" in each for each in told.warnings)
    assert not any(name.startswith("drag") for name in told.parameters)


def test_a_play_behind_noise_is_left_to_plays(monkeypatch: pytest.MonkeyPatch) -> None:
    few = ("prandtl-ishlinskii", "maxwell-slip")
    monkeypatch.setattr(workbench, "MODELS", {name: workbench.MODELS[name] for name in few})
    play = np.empty(HEAD.size)
    at = HEAD[0]
    for k, head in enumerate(HEAD):
        at = min(max(at, head - 5.0), head + 5.0)
        play[k] = at
    best, *_ = workbench.compare(HEAD, play + _noise(7, 0.05), TIME_S, 0.5)
    assert best.model == "prandtl-ishlinskii"
