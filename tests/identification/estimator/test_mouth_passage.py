"""A tip seen at one depth, once on its way in and once on its way out: gap and offset follow."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis import prandtl_ishlinskii as pi
from opensuction.hysteresis.bank import play_lines
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification.estimator import gap_measurement
from opensuction.identification.estimator.gap_measurement import (
    Array,
    Missed,
    Passage,
    Shift,
    dahl_tip_mm,
    lines_tip_mm,
    play_tip_mm,
    scale_dahl,
)
from opensuction.kernel.errors import InputError

MODEL = PrandtlIshlinskii(
    thresholds_mm=np.array([8.0, 9.0, 9.5, 10.0, 11.0]),
    weights=np.array([0.1, 0.25, 0.25, 0.25, 0.1]),
    slope=0.02,
    offset_mm=-6.0,
    curvature_per_mm=1e-4,
)
PERIOD_S = 0.001
SPEED_MM_PER_S = 30.0
PARKED_MM, DEEPEST_MM = -110.0, 60.0
MOUTH_MM = -87.0
STEPS_MM = 2.0 * SPEED_MM_PER_S * PERIOD_S
"""A passage is known to one step of the head either way; the offset errs by no more."""


def cycle_head_mm() -> Array:
    """A pre-use jog, the way in, a dwell, the way out."""
    step_mm = SPEED_MM_PER_S * PERIOD_S
    jog = np.concatenate([np.linspace(0.0, 2.0, 200), np.linspace(2.0, 0.0, 200)]) + PARKED_MM
    way_in = np.arange(PARKED_MM, DEEPEST_MM, step_mm)
    return np.concatenate([jog, way_in, np.full(500, way_in[-1]), way_in[::-1]])


def tips_mm(model: PrandtlIshlinskii, head: Array) -> Array:
    return np.asarray(pi.simulate(model, head, pi.retracted_positions_mm(model, head[0])))


def changed(shift: Shift) -> PrandtlIshlinskii:
    scaled = pi.scale_widths(MODEL, shift.scale)
    return scaled._replace(offset_mm=MODEL.offset_mm + shift.offset_mm)


def barrier(tip: Array) -> Array:
    return (tip <= MOUTH_MM).astype(np.float64)


def read(clear: Array, head: Array, latency_s: float = 0.0) -> Shift | Missed:
    return gap_measurement.read(play_tip_mm(MODEL), clear, head, MOUTH_MM, PERIOD_S, latency_s)


@settings(max_examples=40, deadline=None)
@given(scale=st.floats(0.6, 1.3), offset_mm=st.floats(-5.0, 5.0))
def test_scale_and_offset_are_found_from_one_cycle(scale: float, offset_mm: float) -> None:
    head = cycle_head_mm()
    found = read(barrier(tips_mm(changed(Shift(scale, offset_mm)), head)), head)
    assert isinstance(found, Shift)
    assert found.scale == pytest.approx(scale, abs=STEPS_MM / pi.gap_mm(MODEL))
    assert found.offset_mm == pytest.approx(offset_mm, abs=STEPS_MM)


def test_a_modified_dahl_model_serves_as_well() -> None:
    """The tip never comes to a full saturation: the model says where it is on its way there."""
    truth = scale_dahl(PUBLISHED, 1.15)._replace(offset_mm=PUBLISHED.offset_mm - 1.5)
    head = cycle_head_mm()
    tip = np.asarray(modified_dahl.simulate(truth, head, modified_dahl.saturation_mm(truth)))
    found = gap_measurement.read(dahl_tip_mm(PUBLISHED), barrier(tip), head, MOUTH_MM, PERIOD_S)
    assert isinstance(found, Shift)
    assert found.scale == pytest.approx(1.15, abs=0.01)
    assert found.offset_mm == pytest.approx(-1.5, abs=STEPS_MM)


def test_a_barrier_known_to_be_late_tells_the_same() -> None:
    head = cycle_head_mm()
    clear = barrier(tips_mm(changed(Shift(1.1, 1.0)), head))
    late = np.concatenate([np.ones(20), clear[:-20]])
    assert read(late, head, latency_s=0.020) == read(clear, head)


def test_a_barrier_secretly_late_widens_the_gap_by_its_way_and_no_more() -> None:
    """50 ms at 30 mm/s each way: 3 mm of head between the passages, and the middle stays."""
    head = cycle_head_mm()
    clear = barrier(tips_mm(MODEL, head))
    found = read(np.concatenate([np.ones(50), clear[:-50]]), head)
    assert isinstance(found, Shift)
    widened_mm = (found.scale - 1.0) * pi.gap_mm(MODEL) / pi.total_slope(MODEL)
    assert widened_mm == pytest.approx(2.0 * 0.050 * SPEED_MM_PER_S, abs=STEPS_MM)
    assert found.offset_mm == pytest.approx(0.0, abs=STEPS_MM)


def flickering(clear: Array) -> Array:
    """Something hangs in the beam and moves."""
    broken = clear.copy()
    last = int(np.flatnonzero(clear < 0.5)[-1])
    broken[last + 5 : last + 9] = 0.0
    return broken


def standing(clear: Array) -> Array:
    """The catheter was not seen until the head stood still."""
    head = cycle_head_mm()
    turn = int(np.argmax(head))
    return np.where(np.arange(clear.size) < turn + 250, 1.0, clear)


@pytest.mark.parametrize(
    ("spoilt", "missed"),
    [
        (lambda clear: np.zeros(clear.size), Missed.NO_PASSAGE),
        (lambda clear: np.ones(clear.size), Missed.NO_PASSAGE),
        (lambda clear: np.minimum(clear, np.arange(clear.size) < 3000), Missed.NO_PASSAGE),
        (flickering, Missed.UNCLEAN),
        (standing, Missed.NOT_ON_THE_WAY),
    ],
    ids=["dark", "blind", "dark-once-inside", "flickering", "at-a-standstill"],
)
def test_what_is_not_one_clean_edge_each_way_teaches_nothing(
    spoilt: Callable[[Array], Array], missed: Missed
) -> None:
    head = cycle_head_mm()
    found = read(spoilt(barrier(tips_mm(MODEL, head))), head)
    assert found == missed
    assert gap_measurement.SENTENCES[missed]


def test_without_a_barrier_nothing_is_learned() -> None:
    head = cycle_head_mm()
    found = gap_measurement.read(play_tip_mm(MODEL), np.ones(head.size), head, np.inf, PERIOD_S)
    assert found == Missed.NO_BARRIER


@pytest.mark.parametrize("ways", [(-90.0, -80.0), (20.0, -105.0)], ids=["no gap", "far apart"])
def test_passages_that_no_gap_explains_teach_nothing(ways: tuple[float, float]) -> None:
    """The catheter left the beam deeper than it came, or so far out that it never moved."""
    came, left = ways
    seen = Passage(np.array([-110.0, came]), np.array([-110.0, 60.0, left]))
    assert gap_measurement.estimate(play_tip_mm(MODEL), seen, MOUTH_MM) == Missed.UNEXPLAINED


def test_records_that_do_not_belong_together_are_refused() -> None:
    with pytest.raises(InputError, match="mouth_clear has 3 samples, head_mm 4"):
        gap_measurement.find_passage(np.ones(3), np.ones(4), PERIOD_S)


def test_plays_with_lines_over_them_tell_the_same_as_the_plays_that_they_are() -> None:
    straight = MODEL._replace(curvature_per_mm=0.0)
    lines = lines_tip_mm(play_lines.of_prandtl_ishlinskii(straight))
    plays = play_tip_mm(straight)
    way = np.array([PARKED_MM, DEEPEST_MM, 3.0, 40.0, MOUTH_MM])
    for scale in (0.0, 0.7, 1.0, 1.3):
        assert lines(scale, way) == pytest.approx(plays(scale, way), abs=1e-9)
