"""Annunciator's notices of faults that no controller can report, played through."""

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning.protocol import PAPER
from opensuction.safety.condition import Condition
from opensuction.simulation import outcome
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import Loop, LoopState
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.twin.fault.fault import Fault

AT = FaultInstant(Phase.INSERTING, 2.0)
WATCHDOG, LATE, RESERVE = (
    Condition.WATCHDOG_FIRED,
    Condition.MESSAGE_LATE,
    Condition.RESERVE_ENERGY_USED,
)


@pytest.fixture(scope="module")
def ready() -> tuple[Loop, LoopState]:
    rig = rigs.rig("bench", 1)
    known = rigs.uncalibrated(rig.profile)
    return rigs.assemble(rig, PAPER, CompensationKind.EXACT_INVERSE, known, 2)


def ran(
    ready: tuple[Loop, LoopState], fault: Fault, strength: float = 0.0, resets: int = 0
) -> InjectedRun:
    return injection.run(*ready, [Injection(fault, AT, strength)], after_s=1.0, resets=resets)


def told(run: InjectedRun) -> dict[Condition, tuple[float, str]]:
    """Seconds after the fault, and by whom, of what was first told after it."""
    at_s = run.faults[0].at_s
    found: dict[Condition, tuple[float, str]] = {}
    for item in outcome.told(run.columns):
        if item.at_s >= at_s:
            found.setdefault(item.condition, (round(item.at_s - at_s, 6), item.by))
    return found


def test_on_a_sound_link_it_says_what_the_controller_wants(ready: tuple[Loop, LoopState]) -> None:
    run = ran(ready, Fault.CATHETER_JAMMED, 8.0)
    columns = run.columns
    wanted = columns["signals.present"].astype(int) | columns["signals.latched"].astype(int)
    assert np.array_equal(columns["annunciator.said"], wanted)
    for line in outcome.LINES:
        assert not columns[line].any()
    assert told(run)[Condition.CATHETER_JAMMED][1] == "controller"


@pytest.mark.parametrize("fault", [Fault.POWER_LOST, Fault.POWER_LOST_WITHOUT_RESERVE])
def test_the_supply_tells_that_the_mains_are_gone(
    ready: tuple[Loop, LoopState], fault: Fault
) -> None:
    found = told(ran(ready, fault))
    assert found == {RESERVE: (0.0, "power"), WATCHDOG: (0.0, "drives")}


def test_a_controller_that_stops_is_told_of_without_it(ready: tuple[Loop, LoopState]) -> None:
    run = ran(ready, Fault.CONTROLLER_STOPPED, 600.0)
    assert told(run) == {LATE: (0.005, "drives"), WATCHDOG: (0.02, "drives")}
    said = run.columns["annunciator.said"]
    stopped = run.stopped_tick
    assert np.all(said[stopped:] == said[stopped - 1])


def test_the_watchdogs_sign_waits_for_a_person(ready: tuple[Loop, LoopState]) -> None:
    run = ran(ready, Fault.CONTROLLER_STOPPED, 1.0, resets=1)
    fired = run.columns["annunciator.watchdog_fired"]
    back = run.stopped_tick + 1000
    assert fired[back : back + 500].all(), "a controller that starts does not clear it"
    assert not fired[-1], "a person's reset does"


@pytest.mark.parametrize(("delay_s", "late"), [(0.005, False), (0.006, True), (0.02, True)])
def test_commands_that_come_late_are_told(
    ready: tuple[Loop, LoopState], delay_s: float, late: bool
) -> None:
    found = told(ran(ready, Fault.MESSAGE_LATE, delay_s))
    assert found.get(LATE) == ((0.005, "drives") if late else None)
    assert WATCHDOG not in found


def test_commands_later_than_the_watchdog_waits_make_the_drives_act(
    ready: tuple[Loop, LoopState],
) -> None:
    run = ran(ready, Fault.MESSAGE_LATE, 0.06)
    assert told(run)[WATCHDOG] == (0.02, "drives")
    assert run.columns["truth.tip_mm"][-1] < 1.0


@pytest.mark.parametrize("fault", [Fault.MESSAGE_LOST, Fault.MESSAGE_REPEATED])
def test_a_repeated_number_counts_as_none(ready: tuple[Loop, LoopState], fault: Fault) -> None:
    strength = 1.0 if fault == Fault.MESSAGE_LOST else 0.0
    found = told(ran(ready, fault, strength))
    assert found[LATE] == (0.005, "drives")
    assert found[WATCHDOG] == (0.02, "drives")


def test_what_a_cut_off_controller_wants_does_not_reach_the_bedside(
    ready: tuple[Loop, LoopState],
) -> None:
    """Its alarms go the way its commands go."""
    run = ran(ready, Fault.MESSAGE_LOST, 1.0)
    first = round(run.faults[0].at_s / 0.001)
    wanted = run.columns["signals.present"].astype(int)
    assert wanted[first:].any()
    assert {item.by for item in outcome.told(run.columns)} == {"drives"}
