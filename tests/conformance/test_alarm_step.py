"""Alarms compiled and as plain Python are the same, number for number."""

from opensuction.safety.alarm.alarm_state import Signals
from opensuction.safety.condition import Condition
from tests.conformance.plain import run_plain
from tests.safety.annunciator import Tick, lasting, run, wrong

C = Condition

HISTORY = [
    *lasting(wrong(C.CANISTER_FULL), 2.0),
    Tick(frozenset({C.CANISTER_FULL, C.HEAD_RUNAWAY}), audio_pause=True),
    *lasting(wrong(C.HEAD_RUNAWAY, C.AUTOMATION_STOPPED), 130.0),
    Tick(frozenset({C.AUTOMATION_STOPPED}), acknowledge=True),
    *lasting(wrong(C.CAM_READING_INVALID), 130.0),
    Tick(audio_pause=True),
    *lasting(wrong(C.CATHETER_LIFE_OVER)._replace(planned_work=True), 125.0),
    Tick(reset=True),
]
"""Delay, latching, pause, acknowledgement, escalation, reminder, planned work, reset."""


def results() -> list[list[float]]:
    """Every field of every tick's signals."""
    return [[float(value) for value in row.signals] for row in run(HISTORY)]


def test_compiled_equals_plain_python() -> None:
    compiled = results()
    assert run_plain("tests.conformance.test_alarm_step", "results") == compiled
    seen = {name: {row[i] for row in compiled} for i, name in enumerate(Signals._fields)}
    for name in ("priority", "audible", "latched", "acknowledged", "escalated", "reminder"):
        assert len(seen[name]) > 1, name
