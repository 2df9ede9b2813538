"""A run of a campaign from a mark: the same as from the start, to the last bit and tick."""

import numpy as np
import pytest

from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import JUDGED
from opensuction.evidence.campaign.sound_machine import Kind, SoundMachine
from opensuction.kernel.vocabulary import Phase
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.simulation.injection.faulty_run import RowBuffer
from opensuction.twin.fault.fault import Fault

SEED = 4
LATE = FaultInstant(Phase.SUCTIONING, 0.3)
NEVER = FaultInstant(Phase.BACKING_OFF, 0.2)
"""By travel no cycle has it."""


@pytest.fixture(scope="module")
def room() -> RowBuffer:
    return played_cycle.make_room(JUDGED)


@pytest.fixture(scope="module")
def machine(room: RowBuffer) -> SoundMachine:
    prepared = sound_machine.prepare(Kind("neonate", "travel"), SEED, "exact-inverse")
    return sound_machine.play(prepared, room)


@pytest.mark.parametrize(
    "one",
    [
        Injection(Fault.GEAR_LOST, LATE, 0.0),  # leaves the catheter inside
        Injection(Fault.READING_LATE, LATE, 0.02),
        Injection(Fault.CONTROLLER_STOPPED, FaultInstant(Phase.OPENING, 0.0), 0.5),
        Injection(Fault.POWER_LOST, FaultInstant(Phase.WITHDRAWING, 0.1), 0.0),
        Injection(Fault.ENCODER_OFFSET, FaultInstant(None, 9.5), 2.0),  # at a mark
        Injection(Fault.PUMP_LOST, FaultInstant(Phase.CHECKING, 0.0), 0.0),
        Injection(Fault.CATHETER_EXPIRED, AT_START, 30.0),
    ],
    ids=lambda one: f"{one.fault.title}{one.at.title}",
)
def test_a_run_from_a_mark_is_the_run_from_the_start(
    one: Injection, machine: SoundMachine, room: RowBuffer
) -> None:
    played = played_cycle.play_faulty(machine, (one,), SEED, room, whole=True).run
    loop, start = machine.prepared.loop, machine.prepared.start
    watched_s = played_cycle.WATCHED_S
    wanted = injection.run(
        loop, start, (one,), watched_s, seed=SEED, room=played_cycle.make_room(JUDGED)
    )
    assert played.faults == wanted.faults
    assert not np.isnan(played.faults[0].at_s)
    for name in JUDGED:
        assert np.array_equal(played.columns[name], wanted.columns[name], equal_nan=True), name
        assert np.array_equal(played.sent[name], wanted.sent[name], equal_nan=True), name


@pytest.mark.parametrize(
    ("one", "before_s"),
    [
        (Injection(Fault.PUMP_LOST, LATE, 0.0), 0.0),
        (Injection(Fault.READING_LATE, LATE, 0.02), played_cycle.LOOKS_BACK_TICKS * DT_S),
        (Injection(Fault.PUMP_LOST, FaultInstant(None, 9.2), 0.0), 0.0),
    ],
    ids=["machine", "link", "from the start"],
)
def test_what_no_fault_has_changed_is_not_played_again(
    one: Injection, before_s: float, machine: SoundMachine, room: RowBuffer
) -> None:
    """It begins at the last mark before the fault, or before what its link remembers."""
    run = played_cycle.play_faulty(machine, (one,), SEED, room).run
    begun_s = run.spans[0].first * DT_S
    latest_s = run.faults[0].at_s - before_s
    assert latest_s - sound_machine.MARK_S - DT_S < begun_s <= latest_s


@pytest.mark.parametrize(
    "one",
    [
        Injection(Fault.PUMP_LOST, NEVER, 0.0),
        Injection(Fault.MONITOR_LATE, LATE, 5.0),  # hands on what is older
        Injection(Fault.PUMP_LOST, AT_START, 0.0),
    ],
    ids=["phase that does not come", "monitor", "at once"],
)
def test_a_run_is_played_from_the_start_where_it_must(
    one: Injection, machine: SoundMachine, room: RowBuffer
) -> None:
    run = played_cycle.play_faulty(machine, (one,), SEED, room).run
    assert run.spans[0].first == 0
    assert np.isnan(run.faults[0].at_s) == (one.at == NEVER)


def test_a_cycle_that_was_planned_with_a_fault_has_it_from_the_start(room: RowBuffer) -> None:
    deep = Injection(Fault.TAUGHT_TOO_DEEP, AT_START, 5.0)
    kind = Kind("adult-icu", "travel")
    prepared = sound_machine.prepare(kind, 1, "exact-inverse", planned=deep)
    played = played_cycle.play_planned(prepared, deep, room)
    sound = sound_machine.prepare(kind, 1, "exact-inverse")
    assert [(one.injection, one.at_s) for one in played.run.faults] == [(deep, 0.0)]
    limits = (one.loop.controller.limits for one in (prepared, sound))
    with_it, without = (one.cap_mm for one in limits)
    assert with_it == pytest.approx(without + 5.0)
