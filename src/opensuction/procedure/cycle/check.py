"""The pre-use test: sensors, insertion motor, valve, pump and line, one item after another.

Nothing of it happens in the patient: the tip stays parked, the head moves within the gap of the
transmission, and the valve strokes with the line vented. An item passes when its condition has
held for a moment, and fails when it does not come in time; the test ends with the first failure.

Items of the pre-use test: their order and their words.
"""

from enum import IntEnum
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Len

from opensuction.kernel.codegen.unrolled import chooser
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings, is_number


class CheckItem(IntEnum):
    """Item of the pre-use test, in the order of the test. Never renumber: recordings hold these.

    Sensors first, for the rest is judged by them; the valve strokes before there is vacuum. What
    the regulator has lowered, the line must hold.
    """

    title: str
    """What the item shows where it passes."""
    failure: str
    """What its failure means, for people."""

    def __new__(cls, number: int, *words: str) -> "CheckItem":
        """Member with the number as its value."""
        member = int.__new__(cls, number)
        member._value_ = number
        member.title, member.failure = words
        return member

    NONE = (0, "Nothing is being tested", "nothing failed")
    READINGS = (1, "Sensors give valid readings", "a sensor gives no valid reading")
    CONTACT_OPEN = (
        2,
        "Contact switch is open at rest",
        "the contact switch is closed although nothing touches the tip",
    )
    HEAD_HOME = (
        3,
        "Encoder reads the park position",
        "the catheter head is not at its park position",
    )
    HEAD_ADVANCES = (
        4,
        "Insertion motor moves the head in, within the slack",
        "the insertion motor does not move the catheter head in",
    )
    HEAD_RETURNS = (
        5,
        "Insertion motor brings it back",
        "the insertion motor does not bring the catheter head back",
    )
    LINE_VENTED = (
        6,
        "Line is vented with the pump off",
        "there is vacuum in the line with the pump off",
    )
    VALVE_OPENS = (7, "Suction valve opens in time", "the suction valve does not open in time")
    VALVE_CLOSES = (
        8,
        "Suction valve closes in time, by its spring alone",
        "the spring does not close the suction valve in time",
    )
    VACUUM_BUILDS = (
        9,
        "Pump reaches its set point",
        "the pump does not reach its set point in time",
    )
    RELIEF_OPENS = (
        11,
        "Relief valve opens, behind the closed valve",
        "the mechanical relief valve does not keep the line at its vacuum",
    )
    REGULATOR_HOLDS = (
        12,
        "Regulator keeps a lower set point",
        "the regulator does not keep a lower set point",
    )
    VACUUM_HOLDS = (
        10,
        "Line holds its vacuum with the pump off",
        "the line loses its vacuum with the pump off: there is a leak",
    )


ORDER = tuple(CheckItem)[1:]
"""The items without `NONE`."""


HOLD_S = 0.05
"""How long a condition must hold; longer than a switch bounces (10 ms)."""
VENTED_MMHG = 5.0
"""Highest vacuum of a vented line, a sensor's error (1 % of 500 mmHg; assumed)."""
NEAR_MMHG = 14.0
"""Distance of the line to relief valve or lower set point that still counts: a stiff relief valve,
or a weak regulator, against the strongest pump and a sensor that reads too much are 11.6 off
[computed]."""
LEVEL_S = 0.15
"""How long the line must stay there; it climbs through in 0.12 s [computed]."""
VACUUM_SETTLE_S = 0.2
"""Line and regulator settle, ten of their time constants (17 ms) [computed]."""
LEAK_S = 1.0
"""How long the vacuum is watched with the pump off; assumed."""
LEAK_AVERAGE_S = 0.05
"""Time constant over which the vacuum from which a leak is reckoned is averaged; assumed."""
LEAK_SHARE = 0.05
"""Loss of vacuum in that time: a leak that takes 2 % of the pump's flow at 120 mmHg [computed]; a
sound line loses 2 %. Assumed to be the least that matters."""


class CheckPlan(NamedTuple):
    """Numbers of a pre-use test; `planning.check_plan` says where each comes from."""

    jog_mm: float
    """Head travel that shows that the motor answers, within the gap of the transmission."""
    ready_mmhg: float
    """Vacuum that the pump must reach."""
    set_mmhg: float
    """Set point of the cycle."""
    lowered_mmhg: float
    """Lower set point that the regulator must keep."""
    relief_mmhg: float
    """Vacuum at which the relief valve opens."""
    relieved_mmhg: float
    """Least vacuum that it, and not the regulator, must be keeping."""
    beyond_mmhg: float
    """Set point that only the relief valve keeps the line from."""
    limits_s: Annotated[tuple[float, ...], Len(len(CheckItem), len(CheckItem))]
    """Longest time for each item, by its number."""


item_limit_s = chooser(len(CheckItem))


class CheckState(NamedTuple):
    """State of the test."""

    item: int
    """Item being tested; NONE outside the phase, and when all have passed."""
    ticks: int
    """Since the item began."""
    held_ticks: int
    """For how long its condition has held."""
    vacuum_mmhg: float
    """Vacuum from which the leak is reckoned."""
    failed: int
    """Item that failed; it stays until the next test begins."""


class CheckSeen(NamedTuple):
    """Head and valve as the test sees them."""

    home: bool
    settled: bool
    off_park_mm: float
    """Head reading less its park position."""
    settle_mm: float
    opened: bool
    closed: bool


FOLLOWING = np.zeros(len(CheckItem), dtype=np.int64)
FOLLOWING[[CheckItem.NONE, *ORDER]] = [*ORDER, CheckItem.NONE]
"""The item after each; the first after NONE, NONE after the last."""


UNTESTED = CheckState(item=0, ticks=0, held_ticks=0, vacuum_mmhg=0.0, failed=0)
"""No test has run yet."""


@compiled
def begin() -> CheckState:
    """The first item of a new test."""
    return UNTESTED._replace(item=FOLLOWING[0])


@compiled
def end(state: CheckState, broken_off: bool) -> CheckState:
    """The test is over; broken off by a fault, the item that was tested has failed."""
    failed = state.item if broken_off and state.failed == 0 else state.failed
    return UNTESTED._replace(failed=failed)


@compiled
def _valid(readings: Readings) -> bool:
    return (
        readings.head_valid
        and readings.carriage_valid
        and readings.cam_valid
        and readings.vacuum_valid
        and readings.contact_valid
        and is_number(readings.head_mm)
        and is_number(readings.carriage_mm)
        and is_number(readings.cam_rad)
        and is_number(readings.line_vacuum_mmhg)
    )


@compiled
def _line_condition(plan: CheckPlan, state: CheckState, vacuum_mmhg: float) -> bool:
    """True where the condition of an item that tests the suction line holds; true for any other."""
    item = state.item
    if item == CheckItem.LINE_VENTED:
        # A reading far below the room's pressure is a sensor's whose offset is no longer small.
        return abs(vacuum_mmhg) <= VENTED_MMHG
    if item == CheckItem.VACUUM_BUILDS:
        return vacuum_mmhg >= plan.ready_mmhg
    if item == CheckItem.RELIEF_OPENS:
        return plan.relieved_mmhg <= vacuum_mmhg <= plan.relief_mmhg + NEAR_MMHG
    if item == CheckItem.REGULATOR_HOLDS:
        return abs(vacuum_mmhg - plan.lowered_mmhg) <= NEAR_MMHG
    if item == CheckItem.VACUUM_HOLDS:
        return vacuum_mmhg >= (1.0 - LEAK_SHARE) * state.vacuum_mmhg
    return True


@compiled
def _condition(plan: CheckPlan, state: CheckState, readings: Readings, seen: CheckSeen) -> bool:
    """True where the item's own condition holds; sensors and contact are judged before."""
    item = state.item
    if item == CheckItem.HEAD_HOME:
        return seen.home and seen.settled
    if item == CheckItem.HEAD_ADVANCES:
        return abs(seen.off_park_mm - plan.jog_mm) <= seen.settle_mm
    if item == CheckItem.HEAD_RETURNS:
        return abs(seen.off_park_mm) <= seen.settle_mm
    if item == CheckItem.VALVE_OPENS:
        return seen.opened and readings.line_vacuum_mmhg <= VENTED_MMHG
    if item == CheckItem.VALVE_CLOSES:
        return seen.closed
    return _line_condition(plan, state, readings.line_vacuum_mmhg)


@compiled
def _needed_s(item: int) -> float:
    """Time for which the condition of an item must hold."""
    if item == CheckItem.VACUUM_BUILDS:
        return VACUUM_SETTLE_S
    if item == CheckItem.VACUUM_HOLDS:
        return VACUUM_SETTLE_S + LEAK_S
    if item in (CheckItem.RELIEF_OPENS, CheckItem.REGULATOR_HOLDS):
        return LEVEL_S
    return HOLD_S


@compiled
def step(
    plan: CheckPlan, state: CheckState, readings: Readings, seen: CheckSeen, dt_s: float
) -> CheckState:
    """Advance the test by one tick; with ``item`` and ``failed`` both NONE all have passed."""
    item = state.item
    vacuum = state.vacuum_mmhg
    if item == CheckItem.VACUUM_HOLDS and state.ticks == 0:
        vacuum = readings.line_vacuum_mmhg
    elif item == CheckItem.VACUUM_HOLDS and state.ticks * dt_s < VACUUM_SETTLE_S:
        vacuum += (readings.line_vacuum_mmhg - vacuum) * (dt_s / (LEAK_AVERAGE_S + dt_s))
    valid = _valid(readings)
    open_contact = not readings.contact_closed or item == CheckItem.READINGS
    holds = valid and open_contact and _condition(plan, state, readings, seen)
    held = state.held_ticks + 1 if holds else 0
    if held * dt_s >= _needed_s(item):
        return UNTESTED._replace(item=FOLLOWING[item], vacuum_mmhg=vacuum)
    failed = 0
    if state.ticks * dt_s >= item_limit_s(plan.limits_s, item):
        failed = item
        if not valid:
            failed = CheckItem.READINGS
        elif not open_contact:
            failed = CheckItem.CONTACT_OPEN
    return CheckState(
        item=item,
        ticks=state.ticks + 1,
        held_ticks=held,
        vacuum_mmhg=vacuum,
        failed=failed,
    )


@compiled
def is_stroking(item: int) -> bool:
    """True for an item that asks for an open valve."""
    return item == CheckItem.VALVE_OPENS


@compiled
def is_by_spring(item: int) -> bool:
    """True where the valve motor's torque stays off: the spring alone must close what it opened.

    It is the spring that ends suction when motor, encoder or power fail, and a closed valve is left
    to it.
    """
    return item == CheckItem.VALVE_CLOSES


@compiled
def is_pumping(item: int) -> bool:
    """True for an item that asks for the pump."""
    return item in (CheckItem.VACUUM_BUILDS, CheckItem.RELIEF_OPENS, CheckItem.REGULATOR_HOLDS)


@compiled
def set_point_mmhg(plan: CheckPlan, item: int) -> float:
    """Set point of the regulator: 0 vents the line.

    With the pump off it stays at the cycle's: the regulator lets nothing in below it.
    """
    if item == CheckItem.RELIEF_OPENS:
        return plan.beyond_mmhg
    if item == CheckItem.REGULATOR_HOLDS:
        return plan.lowered_mmhg
    if item in (CheckItem.VACUUM_BUILDS, CheckItem.VACUUM_HOLDS):
        return plan.set_mmhg
    return 0.0


@compiled
def is_jogging(item: int) -> bool:
    """True for an item that asks for the head away from its park position."""
    return item == CheckItem.HEAD_ADVANCES
