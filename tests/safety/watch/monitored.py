"""A patient's monitor, sample by sample, and what the watch makes of it."""

from collections.abc import Callable

from opensuction.kernel.interface import Monitor
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.safety import limits as safety_limits
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode_trips
from opensuction.safety.limits import PatientLimits
from opensuction.safety.watch import patient_watch
from opensuction.safety.watch.patient_watch import UNSEEN, PatientWatch
from tests.settled import settled

DT_S = 0.01
"""As often as a monitor's pressure comes."""
PEEP = 6.0
ADULT = safety_limits.limits_of(AgeGroup.ADULT, PEEP, monitored=True)
WELL = Monitor(
    connected=True,
    spo2_percent=97.0,
    spo2_valid=True,
    heart_rate_per_min=85.0,
    heart_rate_valid=True,
    airway_pressure_cmh2o=PEEP,
    airway_pressure_valid=True,
)
PERIOD_S = 4.0
Report = Callable[[float], Monitor]


def at_pressure(cmh2o: float) -> Monitor:
    return WELL._replace(airway_pressure_cmh2o=cmh2o)


def breathing(time_s: float) -> Monitor:
    """A quiet patient: PEEP and 12 cmH2O more in each inspiration."""
    return at_pressure(PEEP + 12.0 if time_s % PERIOD_S < 1.3 else PEEP)


step = settled(patient_watch.step)


def watched(
    report: Report,
    seconds: float,
    sucking: bool = False,
    limits: PatientLimits = ADULT,
    watch: PatientWatch = UNSEEN,
) -> list[PatientWatch]:
    """State after each sample."""
    states = []
    for i in range(round(seconds / DT_S)):
        watch = step(limits, watch, report(i * DT_S), sucking, DT_S)
        states.append(watch)
    return states


def first_s(states: list[PatientWatch], code: Condition) -> float:
    """When a condition first held; infinite where it never did."""
    for i, state in enumerate(states):
        if state.conditions >> code & 1:
            return (i + 1) * DT_S
    return float("inf")


def seen(states: list[PatientWatch]) -> set[Condition]:
    return {code for state in states for code in decode_trips(state.conditions)}


def on_time(states: list[PatientWatch], code: Condition, after_s: float) -> bool:
    """Whether a condition begins with the first sample after its time, rounding apart."""
    return after_s < first_s(states, code) + 1e-9 <= after_s + 2.0 * DT_S
