"""Teaching: a person pushes the catheter in until it touches the carina, and confirms.

The travel length is the tip that the controller's model gives for the measured head, pushed in
through the gap; one that no such patient has is not taken. Then the person draws the catheter
back, or asks the drive to bring it home slowly.
Source: [paper] II-A: a first insertion by hand measures the travel length.
"""

from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.vocabulary import AgeGroup

AWAY_MM = 5.0
"""Head travel from home after which its return ends the teaching; assumed."""
RETURNED_S = 0.5
"""How long the head must be home again: the hand has let go; assumed."""
HOME_MM_PER_S = 10.0
"""Speed at which the drive brings the head home on request: that of a hand, [paper] II-A."""


class Taught(IntEnum):
    """Result of a confirmation. The numbers are stored in recordings: never renumber."""

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


class TravelRange(NamedTuple):
    """Depths from the tube's lower end to the carina."""

    least_mm: float
    most_mm: float


PLAUSIBLE: dict[AgeGroup, TravelRange] = {
    # [K] typically 40 to 90; the neck moves the tube's tip by some 20 mm, half of it each way
    AgeGroup.ADULT: TravelRange(least_mm=30.0, most_mm=100.0),
    # [ATS-2000] 10 to 20; half and half again: [assumed]
    AgeGroup.CHILD: TravelRange(least_mm=5.0, most_mm=30.0),
    # [assumed] 9.6 to 14.4 in the twin's presets; with the child's margins
    AgeGroup.NEONATE: TravelRange(least_mm=5.0, most_mm=25.0),
}
"""Taught lengths outside are refused."""


class TeachingState(NamedTuple):
    """State of teaching; the length stays until the next one is taught."""

    taught: int
    """What became of the last confirmation, see `Taught`."""
    taught_mm: float
    """Tube's lower end to carina; 0 where nothing was taken."""
    away: bool
    """The head has left home."""
    home_ticks: int
    bringing: bool
    """The drive brings the head home."""


UNTAUGHT = TeachingState(taught=0, taught_mm=0.0, away=False, home_ticks=0, bringing=False)
"""Nothing was taught yet; a new teaching begins here too and forgets what was taught before."""


@compiled
def _judge(span: TravelRange, tip_mm: float, readable: bool) -> int:
    if not readable:
        return Taught.HEAD_UNREAD
    if tip_mm < span.least_mm:
        return Taught.TOO_SHORT
    if tip_mm > span.most_mm:
        return Taught.TOO_DEEP
    return Taught.TAKEN


@compiled
def step(
    plausible: TravelRange,
    state: TeachingState,
    confirm: bool,
    home: bool,
    readable: bool,
    off_park_mm: float,
    is_home: bool,
    tip_mm: float,
) -> TeachingState:
    """One tick of the phase.

    plausible: for the patient's age. confirm, home: requests. readable: the head reading is valid.
    off_park_mm: head less its park position. tip_mm: estimated tip, where a person confirms.
    """
    taught, taught_mm = state.taught, state.taught_mm
    if confirm:
        taught = _judge(plausible, tip_mm, readable)
        taught_mm = tip_mm if taught == Taught.TAKEN else 0.0
    return TeachingState(
        taught=taught,
        taught_mm=taught_mm,
        away=state.away or (readable and abs(off_park_mm) > AWAY_MM),
        home_ticks=state.home_ticks + 1 if is_home else 0,
        bringing=state.bringing or home,
    )


@compiled
def is_over(state: TeachingState, dt_s: float) -> bool:
    """True once the head has been away, or was sent home, and is home again."""
    returned = state.home_ticks * dt_s >= RETURNED_S
    return returned and (state.away or state.bringing)
