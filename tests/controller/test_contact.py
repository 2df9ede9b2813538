"""Stopping by contact: the search, the back-off, and what is done when the switch is wrong."""

from functools import cache

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.controller import setup
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.transition import Event
from opensuction.procedure.planning.protocol import PAPER, Protocol
from opensuction.safety.condition import Condition
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.trace import Columns
from tests.controller.bedside import at_bed
from tests.controller.drive import (
    NEVER,
    START,
    Fault,
    When,
    at_rest,
    during,
    identification,
    phases,
    rig,
    simulate,
)
from tests.controller.invariant import assert_held, trips

EXACT = CompensationKind.EXACT_INVERSE
NONE = CompensationKind.NONE
CARINA_MM = 65.0
BACKING = PAPER._replace(backoff_mm=10.0)
HALTED = [Phase.INSERTING, Phase.ABORTING, Phase.HALTED]
CYCLE = [
    Phase.CHECKING,
    Phase.PRELOADING,
    Phase.INSERTING,
    Phase.BACKING_OFF,
    Phase.OPENING,
    Phase.SUCTIONING,
    Phase.WITHDRAWING,
    Phase.CLOSING,
    Phase.PARKED,
]


@cache
def searching(
    kind: CompensationKind, protocol: Protocol, carina_mm: float
) -> tuple[Loop, LoopState]:
    """The nominal bench about to search for a carina."""
    placed = rigs.with_carina(rig(), carina_mm)
    calibration = identification().calibration
    return rigs.assemble(placed, protocol, kind, calibration, run=2, by_contact=True)


def search(
    kind: CompensationKind,
    protocol: Protocol = PAPER,
    carina_mm: float = CARINA_MM,
    when: When = NEVER,
) -> tuple[Loop, Columns]:
    """One cycle, held to every invariant."""
    loop, start = searching(kind, protocol, carina_mm)
    _, columns = simulate(kind, 51.0, {0.0: START}, when, start, loop)
    assert_held(columns, loop)
    return loop, columns


@cache
def backed_off() -> Columns:
    return search(EXACT, BACKING)[1]


def halted_by(columns: Columns) -> Event:
    """Event that led out of the cycle; the tip is out at the end."""
    assert phases(columns)[-3:] == HALTED
    assert columns["truth.tip_mm"][-1] < 4.5
    assert not (columns["truth.tip_vacuum_mmhg"] > 0.0).any()
    return Event(int(columns["cause"][np.argmax(columns["phase"] == Phase.ABORTING)]))


def start_s(columns: Columns, phase: Phase) -> float:
    return float(columns["time_s"][np.argmax(columns["phase"] == phase)])


@pytest.mark.requirement("OS-R21")
@pytest.mark.parametrize("kind", [NONE, EXACT])
def test_contact_before_the_window_ends_the_cycle(kind: CompensationKind) -> None:
    # Uncompensated, the reference is 17 mm ahead of the tip.
    _, columns = search(kind, carina_mm=8.0)
    assert halted_by(columns) == Event.CONTACT_MISPLACED
    assert trips(columns) <= {Condition.CONTACT_STUCK_CLOSED}
    assert columns["truth.contact_n"].max() <= 0.3


@pytest.mark.requirement("OS-R21")
@pytest.mark.parametrize("kind", [NONE, EXACT])
def test_no_contact_until_the_end_of_the_search_ends_the_cycle(kind: CompensationKind) -> None:
    loop, columns = search(kind, carina_mm=130.0)
    seen = trips(columns)
    assert halted_by(columns) == (Event.TRIPPED if seen else Event.CONTACT_MISPLACED)
    assert seen <= {Condition.CARINA_MISSED, Condition.CONTACT_STUCK_OPEN}
    # Either the search ran to its end, or the tip was surely past the last place to search.
    if seen:
        assert columns["truth.tip_mm"].max() > loop.controller.limits.window.by_mm
    else:
        assert columns["demand.reference_mm"].max() == loop.controller.plan.motion.target_mm


def test_by_travel_contact_is_held_by_the_governor_and_nothing_to_the_cycle() -> None:
    _, columns = simulate(NONE, 36.0, {0.0: START}, during(Fault.CONTACT_CLOSED, 8.7))
    assert phases(columns)[-3:] == HALTED
    assert trips(columns) == {Condition.CONTACT_TIME}
    held = columns["commands.head_mm"][8700:]
    assert held.max() == held[0] == columns["readings.head_mm"][8700]
    # The cycle goes on wanting to advance; 2 s later the governor takes it out.
    assert start_s(columns, Phase.ABORTING) == pytest.approx(10.7, abs=0.01)


def test_only_a_search_that_stays_on_the_carina_may_touch_longer_than_two_seconds() -> None:
    def longest_s(protocol: Protocol, by_contact: bool) -> float:
        calibration = identification().calibration
        settings = setup.settings(
            rig().profile, protocol, EXACT, calibration, by_contact, rig().site
        )
        return settings.limits.contact_s

    assert longest_s(PAPER, by_contact=False) == 2.0
    assert longest_s(BACKING, by_contact=True) == 2.0
    assert longest_s(PAPER, by_contact=True) == PAPER.negative_pressure_budget_s


@pytest.mark.parametrize("patient", ["adult-icu", "child-10kg", "neonate"])
def test_by_travel_a_driven_tip_may_touch_a_patient_no_longer_than_a_cough_does(
    patient: str,
) -> None:
    limits = at_bed(patient)[0].controller.limits
    assert (limits.driven_contact_s, limits.contact_s) == (0.6, 2.0)


def test_the_tip_backs_off_before_suction() -> None:
    columns = backed_off()
    assert phases(columns) == CYCLE
    assert trips(columns) == set()
    sucking = columns["phase"] == Phase.SUCTIONING
    # 10 mm by the model, which is up to 1.2 mm off this plant on the way back.
    assert columns["truth.tip_mm"][sucking].max() == pytest.approx(CARINA_MM - 10.0, abs=1.5)
    touching = columns["truth.contact_n"] > 0.0
    assert not (touching & (columns["truth.valve_open_ratio"] > 0.0)).any()
    assert columns["truth.contact_n"].max() <= 0.3


def test_the_tip_leaves_the_carina_as_soon_as_the_gap_is_crossed() -> None:
    columns = backed_off()
    touching = np.flatnonzero(columns["truth.contact_n"] > 0.0)
    assert touching.size * DT_S < 2.0
    loop, _ = at_rest(EXACT)
    crossing_s = loop.controller.plan.gap_lead_s
    # The model's gap is rounder than the plant's, whose widest play opens last: 0.2 s.
    since_s = (touching[-1] + 1) * DT_S - start_s(columns, Phase.BACKING_OFF)
    assert since_s <= crossing_s + 0.1 + 0.2
    # At full outward speed 100 ms after contact, and the servo's time constant; while it touches,
    # the governor lets the command fall to a head that is ahead of it, up to the head's limit.
    after = round((start_s(columns, Phase.BACKING_OFF) + 0.12) / DT_S)
    head = columns["truth.head_mm"]
    assert -20.5 <= (head[after + 10] - head[after]) / 0.01 <= -16.5


@pytest.mark.parametrize(
    ("kind", "name"), [(NONE, "none"), (CompensationKind.DIRECT_INVERSE, "direct-inverse")]
)
def test_a_back_off_that_would_not_cross_the_gap_is_refused(
    kind: CompensationKind, name: str
) -> None:
    with pytest.raises(InputError, match=rf"'{name}' cannot back off 10 mm.*preview"):
        searching(kind, BACKING, CARINA_MM)


@pytest.mark.parametrize("kind", CompensationKind)
def test_the_window_is_held_against_the_tip_not_the_reference(kind: CompensationKind) -> None:
    # The window begins at 30 mm. Uncompensated, the reference is at 45 mm when the tip is there.
    _, before = search(kind, carina_mm=25.0)
    assert halted_by(before) == Event.CONTACT_MISPLACED
    _, within = search(kind, carina_mm=35.0)
    assert Phase.BACKING_OFF in phases(within)


@pytest.mark.parametrize("carina_mm", [22.0, 26.0])
def test_a_carina_that_has_come_nearer_than_the_window_is_sucked_before(carina_mm: float) -> None:
    _, columns = search(EXACT, BACKING, carina_mm)
    assert phases(columns) == CYCLE
    assert trips(columns) == set()
    sucking = columns["truth.valve_open_ratio"] > 0.0
    assert columns["truth.tip_mm"][sucking].max() == pytest.approx(carina_mm - 10.0, abs=2.0)
    touching = columns["truth.contact_n"] > 0.0
    assert not (touching & sucking).any()
    assert columns["truth.contact_n"].max() <= 0.3
    assert touching.sum() * DT_S < 2.0


def test_one_that_is_as_near_as_the_back_off_is_long_ends_the_search() -> None:
    assert halted_by(search(EXACT, BACKING, 16.0)[1]) == Event.CONTACT_MISPLACED


@pytest.mark.requirement("OS-R20")
@pytest.mark.parametrize("fault", [Fault.CONTACT_CLOSED, Fault.CONTACT_BOUNCING])
@pytest.mark.parametrize("before_s", [0.2, 0.8])
def test_a_switch_that_sticks_before_the_window_is_told_by_drawing_back(
    fault: Fault, before_s: float
) -> None:
    """The tip is at 28.2 and 22.8 mm then, 9 mm/s before the window."""
    sound = search(EXACT, BACKING)[1]
    inserting = sound["phase"] == Phase.INSERTING
    there = np.argmax(inserting & (sound["truth.tip_mm"] >= BACKING.contact_from_mm))
    stuck_s = float(sound["time_s"][there]) - before_s
    _, columns = search(EXACT, BACKING, when=during(fault, stuck_s))
    aborting_s = start_s(columns, Phase.ABORTING)
    assert phases(columns)[-4:] == [Phase.INSERTING, Phase.BACKING_OFF, *HALTED[1:]]
    assert aborting_s - stuck_s < 2.1
    first = int(np.argmax(columns["phase"] == Phase.ABORTING))
    assert Event(int(columns["cause"][first])) in (Event.CONTACT_MISPLACED, Event.TRIPPED)
    assert not (columns["truth.valve_open_ratio"][columns["time_s"] > stuck_s] > 0.0).any()


@pytest.mark.parametrize("protocol", [PAPER, BACKING], ids=["stays", "backs off"])
@pytest.mark.parametrize("seconds", [0.02, 0.2])
def test_a_bouncing_switch_does_not_confuse_the_phases(protocol: Protocol, seconds: float) -> None:
    contact_s = start_s(search(EXACT, protocol)[1], Phase.BACKING_OFF)
    bouncing = during(Fault.CONTACT_BOUNCING, contact_s, contact_s + seconds)
    _, columns = search(EXACT, protocol, when=bouncing)
    assert phases(columns) == CYCLE
    assert columns["truth.contact_n"].max() <= 0.3


@pytest.mark.requirement("OS-R20")
@pytest.mark.parametrize("kind", [NONE, EXACT])
def test_a_switch_stuck_closed_at_rest_lets_nothing_begin(kind: CompensationKind) -> None:
    _, columns = search(kind, when=during(Fault.CONTACT_CLOSED, 0.0))
    assert Phase.PRELOADING not in phases(columns)
    assert phases(columns)[0] == Phase.CHECKING
    assert phases(columns)[-1] == Phase.HALTED
    assert np.ptp(columns["truth.head_mm"]) < 0.2
    assert not (columns["truth.valve_open_ratio"] > 0.0).any()
