"""Heart rate under stimulation and hypoxia: closed forms and bounds."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.vocabulary import AgeGroup
from opensuction.safety.limits import AGE_LIMITS
from opensuction.twin import parameter
from opensuction.twin.patient import patient_monitor
from opensuction.twin.patient.patient_monitor import Heart, HeartState
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES, PRESETS
from opensuction.twin.patient.patient_preset import AGE_GROUPS

DT_S = 0.01
HEART = Heart(rest_per_min=80.0, vagal_ratio=0.5, vagal_s=2.0, recovery_s=8.0, hypoxic_ratio=0.6)
WELL = 0.97


def after(
    state: HeartState, stimulus: float, seconds: float, saturation: float = WELL
) -> HeartState:
    for _ in range(round(seconds / DT_S)):
        state = patient_monitor.step_heart(HEART, state, stimulus, saturation, DT_S)
    return state


def test_the_tone_rises_and_fades_as_first_order() -> None:
    rest = patient_monitor.at_rest_heart(HEART)
    risen = after(rest, 1.0, 2.0)
    # Backward Euler of 10 ms is within half a step of the exponential.
    assert risen.tone == pytest.approx(1.0 - math.exp(-1.0), abs=0.002)
    assert risen.rate_per_min == pytest.approx(80.0 * (1.0 - 0.5 * risen.tone))
    faded = after(risen, 0.0, 8.0)
    assert faded.tone == pytest.approx(risen.tone * math.exp(-1.0), abs=0.002)
    assert after(rest, 1.0, 60.0).rate_per_min == pytest.approx(40.0, abs=0.01)
    assert after(rest, 0.0, 60.0) == rest


def test_stimuli_are_ranked() -> None:
    assert patient_monitor.stimulus(False, True, True) == 0.0
    catheter = patient_monitor.stimulus(True, False, False)
    suction = patient_monitor.stimulus(True, True, False)
    carina = patient_monitor.stimulus(True, False, True)
    assert 0.0 < catheter < suction <= carina == patient_monitor.stimulus(True, True, True) == 1.0


@pytest.mark.parametrize(
    ("saturation", "share"), [(1.0, 1.0), (0.6, 1.0), (0.4, 0.65), (0.2, 0.3), (0.0, 0.3)]
)
def test_deep_hypoxia_alone_slows_the_heart(saturation: float, share: float) -> None:
    slowed = after(patient_monitor.at_rest_heart(HEART), 0.0, 0.1, saturation)
    assert slowed.rate_per_min == pytest.approx(80.0 * share)


@given(
    stimuli=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=100),
    saturation=st.floats(0.0, 1.0),
    dt_s=st.floats(1e-4, 1.0),
)
def test_the_rate_stays_between_rest_and_its_floor(
    stimuli: list[float], saturation: float, dt_s: float
) -> None:
    state = patient_monitor.at_rest_heart(HEART)
    floor = 80.0 * 0.5 * (1.0 - patient_monitor.HYPOXIC_FALL)
    for stimulus in stimuli:
        state = patient_monitor.step_heart(HEART, state, stimulus, saturation, dt_s)
        assert 0.0 <= state.tone <= 1.0
        assert floor - 1e-9 <= state.rate_per_min <= 80.0


@pytest.mark.parametrize("name", PRESETS)
def test_no_drawn_heart_can_fall_below_its_limit(name: str) -> None:
    """Bradycardia is a fault or a patient of one's own, never a draw: worst of the spread."""
    table = PATIENT_TABLES[name]
    rate, vagal = table["heart_rate_per_min"], table["vagal_ratio"]
    slowest = rate.value - parameter.SPREAD_LIMIT * rate.spread
    strongest = vagal.value + parameter.SPREAD_LIMIT * vagal.spread
    limit = AGE_LIMITS[AgeGroup(AGE_GROUPS[name])].heart_rate_per_min
    assert slowest * (1.0 - strongest) > limit
