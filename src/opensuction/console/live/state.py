"""The newest row of the control loop as the page takes it: names, sentences, and honest gaps.

What is not known is None, never the value that was there before.
"""

import time
from datetime import UTC, datetime
from typing import Any, NamedTuple

from opensuction.console.live import row as rows
from opensuction.console.live.row import Row, plain
from opensuction.controller.record import Settings
from opensuction.ipc.liveness import Heartbeat, Process
from opensuction.kernel.compiled import as_python
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import Phase, name_of
from opensuction.procedure.cycle import lock_out, transition
from opensuction.procedure.cycle.check import CheckItem
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.schedule import Preoxygenation
from opensuction.procedure.suction import line_flow
from opensuction.runtime import decision
from opensuction.runtime.decision import Alarm
from opensuction.safety.alarm.alarm_state import NOTHING
from opensuction.safety.condition import OUT_FIRST, Condition
from opensuction.safety.condition_mask import decode
from opensuction.safety.handling import Priority
from opensuction.safety.limits import TipInterval, deepest_mm, shallowest_mm

State = dict[str, Any]
CONNECTED_S = 0.5
"""A loop that has written nothing for longer than this is none."""
MOVING_MM_PER_S = 0.5
"""Slower is noise of the head's sensors."""
COMING, NOTHING_COMES = "coming", "nothing-comes"
"""What is said of secretions while the valve is open (`procedure.suction.line_flow`)."""
OPEN_SHARE = 0.05
"""Of the cam's stroke: a valve that is no further open counts as closed."""
NS_PER_S = 1e9
LOST = Alarm(
    name="control-lost",
    priority=name_of(Priority.HIGH),
    sentence="the control process says nothing: nobody knows where the catheter is",
    remedy=OUT_FIRST,
)
"""What the console itself says: the only alarm that does not come from the controller, because
there is none."""
DEEPEST_MM, SHALLOWEST_MM = map(as_python, (deepest_mm, shallowest_mm))
_WATCH, _UPKEEP = "state.core.governor.watch", "state.core.upkeep"


class Seen(NamedTuple):
    """Data that a state is made from."""

    number: int
    values: Array
    """The newest row, by `ROW_COLUMNS`."""
    began_utc_ns: int
    """Of the monotonic clock's zero."""
    settings: Settings
    age_s: float
    """Since the row's tick was due."""


def tell(seen: Seen | None, heartbeat: Heartbeat | None, last_cycle: State | None) -> State:
    """The state. seen: None where no controller has written anything."""
    about = {
        "processes": _processes(heartbeat),
        "last_cycle": last_cycle,
        "age_s": None if seen is None else plain(max(seen.age_s, 0.0), 3),
    }
    if seen is None or seen.age_s > CONNECTED_S:
        return _lost(seen) | about
    row = Row(seen.values)
    return {
        "number": seen.number,
        "tick": row.whole("inputs.tick"),
        "utc": _utc(seen, row),
        "connected": True,
        "last_known": None,
        **_phase(seen.settings, row),
        **_motion(seen.settings, row),
        **_suction(seen.settings, row),
        "monitor": _monitor(row),
        **_alarms(row),
        **_upkeep(seen.settings, row),
        "late_share": plain(row.number("outputs.counters.late_share"), 6),
        "skipped": row.whole("loop.skipped"),
        **about,
    }


def _utc(seen: Seen, row: Row) -> str:
    at_s = row.number("loop.time_s") + seen.began_utc_ns / NS_PER_S
    return datetime.fromtimestamp(at_s, UTC).isoformat(timespec="milliseconds")


def _processes(heartbeat: Heartbeat | None) -> State:
    """Age of each process's last heartbeat; None where it is not known."""
    listed = (Process.CONTROL, Process.RECORDER, Process.SUPERVISOR)
    if heartbeat is None:
        return {name_of(one): {"age_s": None, "expected": False} for one in listed}
    return {
        name_of(one): {
            "age_s": plain(heartbeat.age_s(one), 3),
            "expected": heartbeat.is_expected(one),
        }
        for one in listed
    }


def _phase(settings: Settings, row: Row) -> State:
    cause, item = row.whole("outputs.cause"), CheckItem(row.whole("outputs.check_item"))
    failed = CheckItem(row.whole("outputs.check_failed"))
    left_s = rows.left_s(settings, row)
    return {
        "phase": name_of(Phase(row.whole("outputs.phase"))),
        "phase_left_s": None if left_s is None else plain(left_s, 2),
        "cause": None if cause == transition.STAY else name_of(transition.Event(cause)),
        "check_item": None if item == CheckItem.NONE else name_of(item),
        "check_title": None if item == CheckItem.NONE else item.title,
        "check_failed": None if failed == CheckItem.NONE else name_of(failed),
        "check_failure": None if failed == CheckItem.NONE else failed.failure,
    }


def _motion(settings: Settings, row: Row) -> State:
    limits = settings.limits
    tip = TipInterval(*(row.number(f"{_WATCH}.tip.{name}") for name in TipInterval._fields))
    high, low = DEEPEST_MM(limits.tip, tip), SHALLOWEST_MM(limits.tip, tip)
    speed = row.number(f"{_WATCH}.speed_mm_per_s")
    moving = "in" if speed > MOVING_MM_PER_S else "out" if speed < -MOVING_MM_PER_S else "still"
    closed = row.valid("inputs.readings.contact_closed", "inputs.readings.contact_valid")
    return {
        "tip_mm": plain(0.5 * (low + high), 2),
        "tip_low_mm": plain(low, 2),
        "tip_high_mm": plain(high, 2),
        "head_mm": row.valid("inputs.readings.head_mm", "inputs.readings.head_valid"),
        "carriage_mm": row.valid("inputs.readings.carriage_mm", "inputs.readings.carriage_valid"),
        "target_mm": plain(settings.plan.motion.target_mm, 2),
        "reference_mm": row.reading("outputs.demand.reference_mm"),
        "moving": moving,
        # Where the deepest place that it can be at is none, it may be anywhere: inside.
        "is_inside": not high <= limits.outside_mm,
        "contact": None if closed is None else closed == 1.0,
    }


def _suction(settings: Settings, row: Row) -> State:
    cam_rad = row.valid("inputs.readings.cam_rad", "inputs.readings.cam_valid")
    open_rad = settings.limits.valve.open_rad
    return {
        "vacuum_mmhg": row.valid(
            "inputs.readings.line_vacuum_mmhg", "inputs.readings.vacuum_valid"
        ),
        "vacuum_setpoint_mmhg": row.reading("outputs.commands.vacuum_mmhg"),
        "valve_open": None if cam_rad is None else cam_rad > OPEN_SHARE * open_rad,
        "cam_rad": cam_rad,
        "pump_on": row.flag("outputs.commands.pump_on"),
        "mouth_clear": row.flag("inputs.readings.mouth_clear"),
        "secretions": _secretions(settings, row),
    }


def _secretions(settings: Settings, row: Row) -> str | None:
    """Presence of secretions in the line; None where it is not known, or not now."""
    seen, flow = settings.plan.flow, "state.core.procedure.flow"
    age_ticks = row.number(f"{flow}.age_ticks")
    is_told = 0.0 <= age_ticks * row.number("inputs.dt_s") <= line_flow.STALE_S
    if seen.window_s == 0.0 or not is_told:
        return None
    return NOTHING_COMES if row.flag(f"{flow}.is_free") else COMING


_MONITOR = {
    "spo2_percent": "spo2_valid",
    "heart_rate_per_min": "heart_rate_valid",
    "airway_pressure_cmh2o": "airway_pressure_valid",
}
"""Values of a patient monitor, each with its flag."""


def _monitor(row: Row) -> State:
    head = "inputs.readings.monitor"
    found: State = {"connected": row.flag(f"{head}.connected")}
    for name, flag in _MONITOR.items():
        found[name] = row.valid(f"{head}.{name}", f"{head}.{flag}")
    return found


def _alarms(row: Row) -> State:
    present, latched, acknowledged, escalated = (
        row.whole(f"outputs.signals.{name}")
        for name in ("present", "latched", "acknowledged", "escalated")
    )
    first = row.whole("outputs.signals.first")
    told = zip(
        map(Condition, decode(present | latched)),
        decision.alarms_of(present | latched, escalated),
        strict=True,
    )
    shown = [
        {
            **alarm._asdict(),
            "acknowledged": bool(acknowledged >> number & 1),
            "present": bool(present >> number & 1),
            "latched": bool(latched >> number & 1),
            "escalated": bool(escalated >> number & 1),
            "_order": (number != first or first == NOTHING, -_urgency(alarm), number),
        }
        for number, alarm in told
    ]
    shown.sort(key=lambda one: one["_order"])
    for one in shown:
        del one["_order"]
    return {
        "alarms": shown,
        "priority": name_of(Priority(row.whole("outputs.signals.priority"))),
        "audible": name_of(Priority(row.whole("outputs.signals.audible"))),
        "pause_left_s": plain(row.number("outputs.signals.pause_left_s"), 1),
        "silent_s": plain(row.number("state.alarms.silent_s"), 2),
    }


def _urgency(alarm: Alarm) -> int:
    return int(Priority[alarm.priority.upper()])


def _upkeep(settings: Settings, row: Row) -> State:
    rest_left_s = row.number("outputs.counters.rest_left_s")
    age_s = row.number(f"{_UPKEEP}.catheter_age_s")
    return {
        "passes": row.whole("outputs.counters.passes"),
        "passes_most": settings.service.passes.most_passes,
        "rest_left_s": plain(rest_left_s, 1),
        "assessment_due": row.flag("outputs.assessment_due"),
        "locked_out": row.flag("outputs.counters.locked_out"),
        "preoxygenation": name_of(Preoxygenation(row.whole("outputs.counters.preoxygenation"))),
        "oxygen_left_s": plain(row.number(f"{_UPKEEP}.oxygen.left_s"), 1),
        "refusal": refused(row),
        "catheter_left_s": plain(max(settings.service.life_s - age_s, 0.0), 0),
    }


def refused(row: Row) -> dict[str, str] | None:
    """Reason for which the last start or reset was refused, with its remedy; None: it was not."""
    found = Refusal(row.whole("outputs.counters.refusal"))
    if found == Refusal.NONE:
        return None
    said = lock_out.say(found, row.number("outputs.counters.rest_left_s"))
    sentence, _, remedy = said.partition(": ")
    return {"name": name_of(found), "sentence": sentence, "remedy": remedy}


def _lost(seen: Seen | None) -> State:
    """Nothing is known: of the last row only that it was the last, and when."""
    last_known = None
    if seen is not None:
        row = Row(seen.values)
        motion = _motion(seen.settings, row)
        last_known = {
            "utc": _utc(seen, row),
            "phase": name_of(Phase(row.whole("outputs.phase"))),
            "tip_high_mm": motion["tip_high_mm"],
            "is_inside": motion["is_inside"],
        }
    lost = {**LOST._asdict(), "acknowledged": False, "present": True, "latched": False}
    return {
        "number": 0 if seen is None else seen.number,
        "tick": 0 if seen is None else Row(seen.values).whole("inputs.tick"),
        "utc": datetime.fromtimestamp(time.time(), UTC).isoformat(timespec="milliseconds"),
        "connected": False,
        "last_known": last_known,
        "phase": "unknown",
        "monitor": {"connected": False, **dict.fromkeys(_MONITOR)},
        "alarms": [{**lost, "escalated": False}],
        "priority": LOST.priority,
        "audible": LOST.priority,
        "is_inside": None,
        "moving": None,
        **dict.fromkeys(_UNKNOWN),
    }


_UNKNOWN = (
    *("phase_left_s", "cause", "check_item", "check_title", "check_failed", "check_failure"),
    *("tip_mm", "tip_low_mm", "tip_high_mm", "head_mm", "carriage_mm", "target_mm"),
    *("reference_mm", "contact", "vacuum_mmhg", "vacuum_setpoint_mmhg", "valve_open", "cam_rad"),
    *("pump_on", "mouth_clear", "secretions", "pause_left_s", "silent_s", "rest_left_s"),
    *("passes", "passes_most"),
    *("assessment_due", "locked_out", "preoxygenation", "oxygen_left_s", "refusal"),
    *("catheter_left_s", "late_share", "skipped"),
)
"""What nobody can say of a machine without a controller."""
