"""Teaching: a person pushes the catheter in until it touches the carina, and confirms.

The travel length is the tip that the controller's model gives for the measured head, pushed in
through the gap; one that no such patient has is not taken. Then the person draws the catheter
back, or asks the drive to bring it home slowly.
Source: paper.txt, section II: a first insertion by hand measures the travel length.
"""

from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel.age_group import AgeGroup
from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError
from opensuction.procedure.guideline import GUIDELINES
from opensuction.procedure.protocol import Protocol

AWAY_MM = 5.0
"""Head travel from home after which its return ends the teaching; assumed."""
RETURNED_S = 0.5
"""How long the head must be home again: the hand has let go; assumed."""
HOME_MM_PER_S = 10.0
"""Speed at which the drive brings the head home on request: that of a hand [paper II-A]."""


class Taught(IntEnum):
    """What became of a confirmation. The numbers are stored in recordings: never renumber."""

    NOTHING = 0
    TAKEN = 1
    TOO_SHORT = 2
    TOO_DEEP = 3
    HEAD_UNREAD = 4
    """The head encoder gave no valid reading."""


SENTENCES: dict[Taught, str] = {
    Taught.NOTHING: "nothing was confirmed",
    Taught.TAKEN: "the travel length was taken",
    Taught.TOO_SHORT: "the length is shorter than any such patient's",
    Taught.TOO_DEEP: "the length is longer than any such patient's",
    Taught.HEAD_UNREAD: "the head encoder gave no valid reading",
}
"""For people."""


class Span(NamedTuple):
    """Depths from the tube's lower end to the carina."""

    least_mm: float
    most_mm: float


PLAUSIBLE: dict[AgeGroup, Span] = {
    # [K] typically 40 to 90; the neck moves the tube's tip by some 20 mm, half of it each way
    AgeGroup.ADULT: Span(least_mm=30.0, most_mm=100.0),
    # [F: ATS, secondary] 10 to 20; half and half again: [assumed]
    AgeGroup.CHILD: Span(least_mm=5.0, most_mm=30.0),
    # [assumed] 9.6 to 14.4 in the twin's presets; with the child's margins
    AgeGroup.NEONATE: Span(least_mm=5.0, most_mm=25.0),
}
"""Taught lengths outside are refused."""

SEARCH_MARGIN_MM = 10.0
"""Beyond the plausible depth at which the governor takes the catheter out of the hand; assumed."""
IDLE_DWELL_S = 2.0
"""Dwell of the plan that teaching runs under; no cycle is started with it."""


class TeachingPlan(NamedTuple):
    """Numbers of the phase."""

    plausible: Span
    away_mm: float
    returned_s: float
    home_mm_per_s: float


class TeachingState(NamedTuple):
    """Where teaching stands; the length stays until the next one is taught."""

    taught: int
    """What became of the last confirmation, see `Taught`."""
    taught_mm: float
    """Tube's lower end to carina; 0 where nothing was taken."""
    away: bool
    """The head has left home."""
    home_ticks: int
    bringing: bool
    """The drive brings the head home."""


def plan(age: AgeGroup) -> TeachingPlan:
    """The phase for a patient's age."""
    return TeachingPlan(
        plausible=PLAUSIBLE[age],
        away_mm=AWAY_MM,
        returned_s=RETURNED_S,
        home_mm_per_s=HOME_MM_PER_S,
    )


def protocol(age: AgeGroup, vacuum_mmhg: float) -> Protocol:
    """Limits under which a person teaches: the plausible range is the cap, no cycle is planned.

    vacuum_mmhg: any the machine can hold; the pump stays off.
    """
    guideline = GUIDELINES[age]
    most_mm = PLAUSIBLE[age].most_mm
    return Protocol(
        travel_mm=most_mm,
        cap_mm=most_mm + SEARCH_MARGIN_MM,
        insertion_mm_per_s=guideline.speed_mm_per_s,
        withdrawal_mm_per_s=guideline.speed_mm_per_s,
        contact_from_mm=0.0,
        backoff_mm=0.0,
        dwell_s=IDLE_DWELL_S,
        vacuum_mmhg=vacuum_mmhg,
        negative_pressure_budget_s=60.0,  # the valve stays closed
        in_airway_budget_s=60.0,  # of the plan; the governor's limit is the guideline's
        bench_only=False,
    )


def check_plausible(age: AgeGroup, taught_mm: float, what: str) -> None:
    """Refuse a length that no such patient has. Raises InputError with the arithmetic.

    what: names the length in the message.
    """
    least, most = PLAUSIBLE[age]
    if least <= taught_mm <= most:
        return
    beyond = least - taught_mm if taught_mm < least else taught_mm - most
    where = "short of the least" if taught_mm < least else "beyond the most"
    limit = least if taught_mm < least else most
    raise InputError(
        f"{what} {taught_mm:g} mm is {beyond:.3g} mm {where} plausible for {age.name.lower()}, "
        f"{limit:g} mm: measure again from the tube's lower end to the carina, {least:g} to "
        f"{most:g} mm"
    )


def untaught() -> TeachingState:
    """Nothing was taught yet."""
    return TeachingState(taught=0, taught_mm=0.0, away=False, home_ticks=0, bringing=False)


@compiled
def begun() -> TeachingState:
    """A new teaching; what was taught before is forgotten."""
    return TeachingState(taught=0, taught_mm=0.0, away=False, home_ticks=0, bringing=False)


@compiled
def _judged(span: Span, tip_mm: float, readable: bool) -> int:
    if not readable:
        return Taught.HEAD_UNREAD
    if tip_mm < span.least_mm:
        return Taught.TOO_SHORT
    if tip_mm > span.most_mm:
        return Taught.TOO_DEEP
    return Taught.TAKEN


@compiled
def step(
    plan: TeachingPlan,
    state: TeachingState,
    confirm: bool,
    home: bool,
    readable: bool,
    off_park_mm: float,
    is_home: bool,
    tip_mm: float,
) -> TeachingState:
    """One tick of the phase.

    confirm, home: requests. readable: the head reading is valid. off_park_mm: head less its park
    position. tip_mm: estimated tip, where a person confirms.
    """
    taught, taught_mm = state.taught, state.taught_mm
    if confirm:
        taught = _judged(plan.plausible, tip_mm, readable)
        taught_mm = tip_mm if taught == Taught.TAKEN else 0.0
    return TeachingState(
        taught=taught,
        taught_mm=taught_mm,
        away=state.away or (readable and abs(off_park_mm) > plan.away_mm),
        home_ticks=state.home_ticks + 1 if is_home else 0,
        bringing=state.bringing or home,
    )


@compiled
def is_over(plan: TeachingPlan, state: TeachingState, dt_s: float) -> bool:
    """Whether the head has been away, or was sent home, and is home again."""
    returned = state.home_ticks * dt_s >= plan.returned_s
    return returned and (state.away or state.bringing)
