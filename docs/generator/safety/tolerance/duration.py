"""Times of the controller that must outlive what patients and switches do."""

from collections.abc import Iterable
from typing import NamedTuple

from docs.generator.safety.tolerance.sensor_error import most
from docs.generator.safety.tolerance.threshold import Constant
from opensuction.procedure.cycle import check, progress
from opensuction.safety.limits import AGE_LIMITS, SHAKEN_S
from opensuction.safety.watch import patient_watch, tip_force
from opensuction.safety.watch.watch import RELEASE_TICKS
from opensuction.twin.behaviour import behaviour, spontaneous_event
from opensuction.twin.fault.fault import Fault
from opensuction.twin.parameter import CLINICAL, SPREAD_LIMIT
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES
from opensuction.twin.patient.patient_preset import AGE_GROUPS

DT_S = 0.001


class Duration(NamedTuple):
    """A time, and what lasts for less."""

    constants: tuple[Constant, ...]
    outlives: str
    waits_s: float
    worst_s: float
    """The longest that is drawn."""
    largest_s: float
    """The longest that a file may set."""
    faults: tuple[Fault, ...]
    takes_s: float
    remark: str
    label: str = ""
    """Name of what is no constant of its own."""


def cough_s(presets: Iterable[str] = PATIENT_TABLES) -> tuple[float, float]:
    """Longest push of a cough that is drawn, and that a file may set."""
    rows = [PATIENT_TABLES[preset]["cough_s"] for preset in presets]
    worst = max(row.value + SPREAD_LIMIT * row.spread for row in rows)
    return worst, max(row.high for row in rows)


def _contact() -> list[Duration]:
    window, push = "safety.watch.tip_force", cough_s()
    bounce = most("switch_bounce_s"), CLINICAL["switch_bounce_s"].high
    return [
        Duration(
            ((window, "IMPOSSIBLE_S"),),
            "a cough that lays the wall of the trachea on the tip",
            tip_force.IMPOSSIBLE_S,
            *push,
            (Fault.SWITCH_STUCK_CLOSED, Fault.SWITCH_BRIDGED),
            tip_force.IMPOSSIBLE_S,
            "the head is held meanwhile",
        ),
        Duration(
            (("procedure.cycle.progress", "HELD_S"),),
            "the same, where the carina is not expected",
            progress.HELD_S,
            *push,
            (Fault.TUBE_DISPLACED,),
            progress.HELD_S,
            "the head is held meanwhile",
        ),
        Duration(
            (("safety.watch.watch", "RELEASE_TICKS"),),
            "chatter of the switch: an opening of it is no release",
            RELEASE_TICKS * DT_S,
            *bounce,
            (Fault.SWITCH_BOUNCING,),
            RELEASE_TICKS * DT_S,
            "a share of the chatter is open, so one opening is shorter than all of it",
        ),
        Duration(
            (("procedure.cycle.check", "HOLD_S"),),
            "the same, in the pre-use test",
            check.HOLD_S,
            *bounce,
            (Fault.SWITCH_STUCK_CLOSED,),
            check.HOLD_S,
            "",
        ),
    ]


def _patient() -> list[Duration]:
    watch, longest_s = "safety.watch.patient_watch", behaviour.LONGEST_S
    return [
        Duration(
            ((watch, "ARTEFACT_S"), (watch, "JUMP_PERCENT")),
            "an oximeter that reads too low",
            patient_watch.ARTEFACT_S + patient_watch.SPO2_S,
            longest_s,
            longest_s,
            (Fault.DESATURATION,),
            patient_watch.ARTEFACT_S + patient_watch.SPO2_S,
            "one by less than `JUMP_PERCENT` is believed at once",
        ),
        Duration(
            ((watch, "ARTEFACT_S"),),
            "an oximeter that says nothing",
            patient_watch.ARTEFACT_S,
            longest_s,
            longest_s,
            (Fault.MONITOR_LOST,),
            patient_watch.ARTEFACT_S,
            "no margin; a trip on the way in only, a second one at once would make it",
        ),
    ]


def _coughs() -> list[Duration]:
    """Pushes of the patient that raise the airway pressure."""
    rows = []
    for age, limits in AGE_LIMITS.items():
        presets = [name for name, group in AGE_GROUPS.items() if group == age]
        rows.append(
            Duration(
                (("safety.watch.patient_watch", "HIGH_FADE"),),
                f"a cough's airway pressure, {age.name.lower()}",
                limits.cough_s,
                *cough_s(presets),
                (Fault.VENTILATOR_PRESSURE,),
                limits.cough_s,
                "a cough is above the limit for a part of its time; coughs add up, less a share of "
                "the time between them",
                f"`cough_s` {limits.cough_s:g} (`safety.limits`)",
            )
        )
    return rows


def _breaths() -> list[Duration]:
    """Pulls of the patient that lower the airway pressure."""
    limit = "safety.limits"
    cough_s = spontaneous_event.INSPIRATION_S
    rows = [
        Duration(
            ((limit, "SHAKEN_S"),),
            "the breath before a cough, of a patient without breaths of their own",
            SHAKEN_S,
            cough_s,
            cough_s,
            (Fault.LUNG_VOLUME_LOST, Fault.CIRCUIT_DISCONNECTED),
            SHAKEN_S,
            "no margin; only the middle of it is below the limit",
        )
    ]
    for age, limits in AGE_LIMITS.items():
        less = limits.effort_s < spontaneous_event.LONGEST_S
        rows.append(
            Duration(
                (),
                f"a breath of their own, {age.name.lower()}",
                limits.effort_s,
                spontaneous_event.LONGEST_S,
                spontaneous_event.LONGEST_S,
                (Fault.LUNG_VOLUME_LOST, Fault.CIRCUIT_DISCONNECTED),
                limits.effort_s,
                "shorter than the longest breath: it must be weak, or above the limit for a part"
                if less
                else "-",
                f"`effort_s` {limits.effort_s:g} (`{limit}`)",
            )
        )
    return rows


def durations() -> list[Duration]:
    """All of them."""
    return _contact() + _coughs() + _patient() + _breaths()
