from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from opensuction.control import backlash_inverse, motion_profile
from opensuction.control.backlash_inverse import HeadState
from opensuction.control.motion_profile import HeadLimits, Profile
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import PUBLISHED, ModifiedDahl
from opensuction.hysteresis.play_sum import NONE_MM
from tests.settled import settled

DT_S = 0.001
LIMITS = HeadLimits(speed_mm_per_s=17.0, acceleration_mm_per_s2=200.0)
MONOTONE = ModifiedDahl(slope=0.95, velocity_gain=0.1, decay_per_mm=0.05, offset_mm=-2.0)
LINE = ModifiedDahl(slope=0.95, velocity_gain=0.0, decay_per_mm=0.1, offset_mm=0.5)

PRELOADED_S, ARRIVED_S, TURNED_S, LEFT_S, END_S = 1.5, 12.0, 18.0, 20.0, 31.0
"""Insertion begins, is over; the direction turns; withdrawal begins; all is over."""


class Cycle(NamedTuple):
    """A cycle of 90 mm at 9 mm/s on the model alone, one entry a tick."""

    time_s: NDArray[np.float64]
    reference_mm: NDArray[np.float64]
    head_mm: NDArray[np.float64]
    velocity_mm_per_s: NDArray[np.float64]
    tip_mm: NDArray[np.float64]


def wanted(time_s: float) -> tuple[float, float, float]:
    """Reference, its velocity, and the direction of the next motion."""
    if time_s < ARRIVED_S:
        way_in = Profile(0.0, 90.0, 9.0, 200.0)
        return *motion_profile.at(way_in, time_s - PRELOADED_S), 1.0
    way_out = Profile(90.0, 0.0, 9.0, 200.0)
    direction = 1.0 if time_s < TURNED_S else -1.0
    return *motion_profile.at(way_out, time_s - LEFT_S), direction


step = settled(backlash_inverse.step)
output_mm = settled(modified_dahl.output_mm)


def cycle(model: ModifiedDahl) -> Cycle:
    lag = modified_dahl.saturation_mm(model)
    state = HeadState((0.0 - lag - model.offset_mm) / model.slope, 0.0, lag, NONE_MM)
    rows = []
    for tick in range(round(END_S / DT_S)):
        reference, speed, direction = wanted(tick * DT_S)
        state = step(model, LIMITS, state, reference, speed, direction, DT_S)
        tip = output_mm(model, state.head_mm, state.lag_mm)
        rows.append((tick * DT_S, reference, state.head_mm, state.head_mm_per_s, tip))
    return Cycle(*np.array(rows).T)


MODELS = {"published": PUBLISHED, "monotone": MONOTONE, "line": LINE}
every_model = pytest.mark.parametrize("run", MODELS, indirect=True)


@pytest.fixture(scope="module")
def run(request: pytest.FixtureRequest) -> Cycle:
    return cycle(MODELS[request.param])


@every_model
def test_the_head_keeps_its_limits(run: Cycle) -> None:
    assert np.abs(run.velocity_mm_per_s).max() <= 17.0
    change = np.abs(np.diff(run.velocity_mm_per_s)).max() / DT_S
    assert change <= 200.0 * (1.0 + 1e-9)  # products of rounded numbers


@every_model
def test_the_head_never_moves_against_the_direction(run: Cycle) -> None:
    inwards = run.time_s < TURNED_S
    assert run.velocity_mm_per_s[inwards].min() >= 0.0
    assert run.velocity_mm_per_s[~inwards].max() <= 0.0


@every_model
def test_the_modelled_tip_rests_on_the_reference_when_the_gap_is_crossed(run: Cycle) -> None:
    error = run.tip_mm - run.reference_mm
    before = (run.time_s > PRELOADED_S - 0.1) & (run.time_s < PRELOADED_S)
    back = (run.time_s > LEFT_S - 0.1) & (run.time_s < LEFT_S)
    # Newton's last digits, and a path that ends within 0.2 um.
    assert np.abs(error[before]).max() < 2e-5
    assert np.abs(error[back]).max() < 2e-5


@every_model
def test_the_modelled_tip_follows_the_reference(run: Cycle) -> None:
    error = np.abs(run.tip_mm - run.reference_mm)
    inside = (run.time_s >= PRELOADED_S) & (run.time_s < ARRIVED_S) | (run.time_s >= LEFT_S)
    # Right after the gap the model wants more head speed than there is, for an instant.
    assert error[inside].max() < 0.25
    assert float(np.sqrt(np.mean(np.square(error[inside])))) < 0.05


@every_model
def test_it_stops_at_the_target_without_overshoot(run: Cycle) -> None:
    dwell = (run.time_s > ARRIVED_S) & (run.time_s < TURNED_S)
    # It sees the reference brake one tick late: 9 mm/s for a tick and what that costs to undo.
    assert run.tip_mm[: dwell.argmax() + 1].max() <= 90.0 + 0.02
    assert run.tip_mm[dwell] == pytest.approx(90.0, abs=0.02)


@pytest.mark.parametrize("run", ["published"], indirect=True)
def test_the_published_gap_is_crossed_in_the_dwell_within_a_second_and_a_tenth(run: Cycle) -> None:
    turn = round(TURNED_S / DT_S)
    gap = abs(modified_dahl.gap_move(PUBLISHED, -modified_dahl.saturation_mm(PUBLISHED), -1.0))
    travelled = run.head_mm[turn] - run.head_mm
    assert gap == pytest.approx(16.476, abs=1e-3)
    # From rest to rest: 16.476/17 + 17/200 = 1.054 s.
    after = turn + round(1.06 / DT_S)
    assert travelled[after] == pytest.approx(gap, abs=0.05)
    # [calc-inverse]: on the way the model's tip dips 2.47 mm the wrong way.
    dip = run.tip_mm[turn:after].max() - run.tip_mm[turn]
    assert dip == pytest.approx(2.47, abs=0.02)


def test_turning_while_moving_stops_at_once_and_then_crosses_the_gap() -> None:
    lag = modified_dahl.saturation_mm(PUBLISHED)
    moving = HeadState(60.0, 9.0, -lag, NONE_MM)
    tip = modified_dahl.output_mm(PUBLISHED, 60.0, -lag)
    stopped = backlash_inverse.step(PUBLISHED, LIMITS, moving, tip, 0.0, -1.0, DT_S)
    assert (stopped.head_mm, stopped.head_mm_per_s) == (60.0, 0.0)
    leaving = backlash_inverse.step(PUBLISHED, LIMITS, stopped, tip, 0.0, -1.0, DT_S)
    assert leaving.head_mm_per_s == pytest.approx(-0.2)


def test_a_reference_that_is_behind_is_waited_for() -> None:
    state = HeadState(60.0, 0.0, 0.0, NONE_MM)
    tip = modified_dahl.output_mm(LINE, 60.0, 0.0)
    waiting = backlash_inverse.step(LINE, LIMITS, state, tip - 5.0, 0.0, 1.0, DT_S)
    assert waiting[:3] == state[:3]
