import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.hysteresis import prandtl_ishlinskii as pi
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification.estimator import gap_measurement
from opensuction.identification.estimator.gap_measurement import TRUSTED, ContactEpisode

MODEL = PrandtlIshlinskii(
    thresholds_mm=np.array([8.0, 9.0, 9.5, 10.0, 11.0]),
    weights=np.array([0.1, 0.25, 0.25, 0.25, 0.1]),
    slope=0.0,
    offset_mm=-6.0,
    curvature_per_mm=0.0,
)


def travel_mm(model: PrandtlIshlinskii, pressed_mm: float) -> float:
    """Head travel back to where the switch opens, after a long way in: by moving the model."""
    head = 100.0
    plays = head - model.thresholds_mm
    tip = float(pi.output_mm(model, plays, head))
    drawn = float(pi.total_slope(model)) * pressed_mm + TRUSTED.release_mm
    return -float(pi.inverse_step(model, plays, head, tip - drawn))


@given(scale=st.floats(0.5, 1.5), pressed=st.floats(0.01, 1.0))
def test_the_scale_of_the_widths_is_found(scale: float, pressed: float) -> None:
    seen = ContactEpisode(travel_mm(pi.scale_widths(MODEL, scale), pressed), pressed)
    assert gap_measurement.estimate_scale(MODEL, seen, TRUSTED) == pytest.approx(scale, rel=1e-6)


def test_the_plain_travel_would_be_biased() -> None:
    """The narrow plays open the switch first [calc-gap-scale]."""
    travel = travel_mm(MODEL, 0.2)
    assert travel < pi.gap_mm(MODEL) / pi.total_slope(MODEL) - 0.5
    assert gap_measurement.estimate_scale(
        MODEL, ContactEpisode(travel, 0.2), TRUSTED
    ) == pytest.approx(1.0)


def test_a_tip_that_follows_at_once_has_no_gap() -> None:
    assert gap_measurement.estimate_scale(MODEL, ContactEpisode(0.01, 1.0), TRUSTED) == 0.0


def test_a_contact_is_read_with_its_latency_and_through_its_bounce() -> None:
    # 10 mm/s in for 1 s, 40 mm/s back; the line is 4 ticks late, and bounces once.
    head = np.concatenate([np.arange(1000) * 0.01, 10.0 - np.arange(500) * 0.04])
    closed = np.zeros(head.size)
    closed[980 + 4 : 1200 + 4] = 1.0
    closed[986] = 0.0
    seen = gap_measurement.find_contact(closed, head, 0.001, 0.004)
    assert seen is not None
    assert seen.pressed_mm == pytest.approx(10.0 - head[980])
    assert seen.travel_mm == pytest.approx(10.0 - head[1200])
    assert seen.steady  # a bounce is none of the patient's moves
    closed[1050:1100] = 0.0
    moved = gap_measurement.find_contact(closed, head, 0.001, 0.004)
    assert moved is not None
    assert not moved.steady


@pytest.mark.parametrize("part", [slice(0, 900), slice(0, 1100), slice(1000, 1500)])
def test_half_a_contact_teaches_nothing(part: slice) -> None:
    head = np.concatenate([np.arange(1000) * 0.01, 10.0 - np.arange(500) * 0.04])
    closed = np.zeros(head.size)
    closed[980:1200] = 1.0
    assert gap_measurement.find_contact(closed[part], head[part], 0.001, 0.004) is None
