"""Bounds of the pre-use test for a vacuum set point on a machine."""

from opensuction.procedure.cycle.check import HOLD_S, LEAK_S, NEAR_MMHG, VACUUM_SETTLE_S, CheckPlan
from opensuction.procedure.cycle.check_item import CheckItem

SENSOR_LIMIT_S = 0.5
"""Time in which sensors and contact must read soundly; assumed."""
HOMING_LIMIT_S = 2.0
"""Time in which the head of a cycle that has just ended must be home; assumed."""
JOG_LIMIT_S = 1.0
"""Time for each way of the jog; 2 mm at 200 mm/s2 take 0.2 s."""
STROKE_SHARE = 1.5
"""A stroke of the valve may last this many times its planned duration (and `STROKE_SETTLE_S`)."""
STROKE_SETTLE_S = 0.5
"""Time for the valve's servo to settle; assumed."""
VACUUM_READY_SHARE = 0.9
"""Share of the set point that the pump must reach; assumed."""
VACUUM_LIMIT_S = 4.0
"""Time for that; 18 L/min evacuate 0.8 L to 120 mmHg in 0.5 s [computed]."""
RELIEF_LIMIT_S = 1.5
"""Time to reach the relief valve; 0.3 s from a neonate's 80 mmHg [computed]."""
REGULATOR_LIMIT_S = 1.0
"""Time to come down from there; 0.1 s [computed]."""
BEYOND_MMHG = 25.0
"""Set point over the relief valve's; 219 mL/s through it take 4 [computed]."""
LOWERED_SHARE = 0.75
"""Lower set point, as share of the cycle's; assumed."""

LIMITS_S = {
    CheckItem.READINGS: SENSOR_LIMIT_S,
    CheckItem.CONTACT_OPEN: SENSOR_LIMIT_S,
    CheckItem.HEAD_HOME: HOMING_LIMIT_S,
    CheckItem.HEAD_ADVANCES: JOG_LIMIT_S,
    CheckItem.HEAD_RETURNS: JOG_LIMIT_S,
    CheckItem.LINE_VENTED: SENSOR_LIMIT_S,
    CheckItem.VACUUM_BUILDS: VACUUM_LIMIT_S,
    CheckItem.VACUUM_HOLDS: VACUUM_SETTLE_S + LEAK_S + HOLD_S,
    CheckItem.RELIEF_OPENS: RELIEF_LIMIT_S,
    CheckItem.REGULATOR_HOLDS: REGULATOR_LIMIT_S,
}
"""Longest time for each item, but for the strokes of the valve."""


def plan_check(vacuum_mmhg: float, relief_mmhg: float, jog_mm: float, stroke_s: float) -> CheckPlan:
    """The plan of the test.

    vacuum_mmhg: set point of the cycle. relief_mmhg: the mechanical relief valve's. jog_mm: head
    travel that does not move the parked tip. stroke_s: planned duration of a stroke of the valve.
    """
    stroke_limit_s = STROKE_SHARE * stroke_s + STROKE_SETTLE_S
    strokes_s = {CheckItem.VALVE_OPENS: stroke_limit_s, CheckItem.VALVE_CLOSES: stroke_limit_s}
    limits_s = {CheckItem.NONE: 0.0, **LIMITS_S, **strokes_s}
    return CheckPlan(
        jog_mm=jog_mm,
        ready_mmhg=VACUUM_READY_SHARE * vacuum_mmhg,
        set_mmhg=vacuum_mmhg,
        lowered_mmhg=LOWERED_SHARE * vacuum_mmhg,
        relief_mmhg=relief_mmhg,
        relieved_mmhg=relief_mmhg - min(NEAR_MMHG, 0.5 * (relief_mmhg - vacuum_mmhg)),
        beyond_mmhg=relief_mmhg + BEYOND_MMHG,
        limits_s=tuple(limits_s[item] for item in sorted(CheckItem)),
    )
