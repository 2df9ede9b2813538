"""A cycle of a trial: played from the last mark before its faults, judged by the truth."""

import numpy as np
import pytest

from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import Played
from opensuction.evidence.campaign.sound_machine import SoundMachine
from opensuction.evidence.trial import draw, judged_cycle, trial
from opensuction.evidence.trial.draw import DrawnFault
from opensuction.evidence.trial.judged_cycle import JUDGED, Case
from opensuction.kernel.errors import InputError
from opensuction.oracle import exposure
from opensuction.result.trial_result import Trial
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.faulty_run import FaultyRun, RowBuffer
from opensuction.simulation.injection.run_judgement import NOT_FOLLOWED
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS

TRIAL = Trial(seed=9)
KINDS = (0, 2, 5, 7)
"""Machines, one for each patient, two by each approach."""
SEED = 3


@pytest.fixture(scope="module")
def room() -> RowBuffer:
    return played_cycle.make_room(JUDGED)


@pytest.fixture(scope="module")
def machines(room: RowBuffer) -> dict[int, SoundMachine]:
    return {
        number: trial.find_machine(TRIAL, number, lambda one: sound_machine.play(one, room))[0]
        for number in KINDS
    }


def drawn(*faults: Fault, share: float = 0.5) -> tuple[DrawnFault, ...]:
    return tuple(DrawnFault(fault, ROWS[fault].default_strength, share) for fault in faults)


def play(machine: SoundMachine, room: RowBuffer, *faults: DrawnFault) -> tuple[Played, Case]:
    injections = judged_cycle.place(faults, machine.healthy)
    played = played_cycle.play_faulty(machine, injections, SEED, room)
    return played, judged_cycle.judge(1, played)


def play_whole(machine: SoundMachine, faults: tuple[DrawnFault, ...]) -> Played:
    """The same from the start, and watched for the longest time."""
    injections = judged_cycle.place(faults, machine.healthy)
    prepared = machine.prepared
    room = played_cycle.make_room(JUDGED)
    going = FaultyRun(prepared.loop, prepared.start, injections, room, SEED)
    injection.follow(going, played_cycle.WATCHED_S, 0)
    run = injection.take(going, injections)
    return Played(prepared, run, played_cycle.WATCHED_S, NOT_FOLLOWED)


@pytest.mark.parametrize("number", [0, 7])
@pytest.mark.parametrize(
    "faults",
    [
        (Fault.PUMP_LOST,),
        (Fault.READING_LATE,),
        (Fault.MESSAGE_LOST,),
        (Fault.ENCODER_NOISY,),
        (Fault.CONTROLLER_STOPPED, Fault.PUMP_LOST),
        (Fault.MONITOR_LATE,),
    ],
    ids=lambda faults: "+".join(fault.title for fault in faults),
)
def test_a_cycle_from_a_mark_is_the_cycle_from_the_start(
    number: int, faults: tuple[Fault, ...], machines: dict[int, SoundMachine], room: RowBuffer
) -> None:
    """To the last bit, with the faults of a link, too: what they hand on is played before them."""
    machine = machines[number]
    named = tuple(
        one._replace(strength=0.1) if one.fault == Fault.CONTROLLER_STOPPED else one
        for one in drawn(*faults, share=0.7)
    )
    played, case = play(machine, room, *named)
    whole = play_whole(machine, named)
    run = whole.run
    ticks = played.run.columns["phase"].size
    assert ticks > 10_000
    for name in JUDGED:
        for found, wanted in ((played.run.columns, run.columns), (played.run.sent, run.sent)):
            assert np.array_equal(found[name], wanted[name][:ticks], equal_nan=True), name
    assert [one.at_s for one in played.run.faults] == [one.at_s for one in run.faults]
    full = judged_cycle.judge(1, whole)
    for name in ("faults", "commands", "breaches", "left_inside", "false_alarms"):
        assert getattr(case, name) == getattr(full, name)
    # The patient who is followed alone is as well as the one at the machine.
    assert case.endpoints.spo2_least_percent == pytest.approx(
        full.endpoints.spo2_least_percent, abs=0.2
    )
    assert case.endpoints.lung_volume_loss_ml == pytest.approx(
        full.endpoints.lung_volume_loss_ml, rel=1e-3
    )


def test_a_fault_comes_in_the_time_inside_or_a_second_before(
    machines: dict[int, SoundMachine],
) -> None:
    """By the truth of a cycle without it, on every patient and by both approaches."""
    for machine in machines.values():
        rows = machine.rows
        tip_mm, phase = rows[JUDGED.index("truth.tip_mm")], rows[JUDGED.index("phase")]
        inside = exposure.find_inside(machine.prepared.rig.machine, tip_mm)
        ticks = np.flatnonzero(inside)
        for share in (0.0, 0.3, 0.5, 1.0):
            (one,) = judged_cycle.place(drawn(Fault.PUMP_LOST, share=share), machine.healthy)
            tick = round(one.at.after_s / DT_S)
            assert ticks[0] - 1000 <= tick <= ticks[-1]
            assert inside[tick] or share == 0.0
            at = sound_machine.find_instant(machine.healthy, "airway", share)
            assert phase[tick] == at.phase


def test_a_single_fault_always_counts(machines: dict[int, SoundMachine], room: RowBuffer) -> None:
    for share in (0.0, 1.0):
        _, case = play(machines[0], room, *drawn(Fault.POWER_LOST_WITHOUT_RESERVE, share=share))
        assert case.counted == 1


def test_what_comes_when_the_catheter_is_out_does_not_count(
    machines: dict[int, SoundMachine], room: RowBuffer
) -> None:
    """The first fault has had it drawn out long ago."""
    early, late = drawn(Fault.ENCODER_INVALID, share=0.2), drawn(Fault.PUMP_LOST, share=1.0)
    played, case = play(machines[0], room, *early, *late)
    assert not case.completed
    assert played.run.columns["truth.tip_mm"][-1] < 0.0
    assert [one.counts for one in case.faults] == [True, False]
    assert case.counted == 1
    _, both = play(machines[0], room, *early, *drawn(Fault.PUMP_LOST, share=0.21))
    assert both.counted == 2


def test_a_catheter_that_stays_is_told_and_inside_for_the_whole_watch(
    machines: dict[int, SoundMachine], room: RowBuffer
) -> None:
    """As if the machine, which does nothing any more, had been played all the time."""
    faults = drawn(Fault.GEAR_LOST)
    _, case = play(machines[2], room, *faults)
    whole = play_whole(machines[2], faults)
    full = judged_cycle.judge(1, whole)
    assert case.watched_s < played_cycle.WATCHED_S
    assert case.left_inside is not None
    assert case.left_inside.unavoidable
    assert case.left_inside == full.left_inside
    assert case.told
    assert case.breaches == full.breaches == ()
    assert case.endpoints.in_airway_s > played_cycle.WATCHED_S
    assert case.endpoints.in_airway_s == pytest.approx(full.endpoints.in_airway_s, abs=0.01)


@pytest.mark.parametrize(
    ("fault", "strength", "whole"),
    [
        (Fault.MOTOR_INTERMITTENT, 5.0, True),  # half a turn may be quiet
        (Fault.MOTOR_INTERMITTENT, 0.02, False),  # has come and gone 75 times
        (Fault.PUMP_LOST, 0.0, False),
    ],
)
def test_what_comes_and_goes_slowly_is_watched_to_the_end(
    fault: Fault, strength: float, whole: bool, machines: dict[int, SoundMachine], room: RowBuffer
) -> None:
    _, case = play(machines[5], room, DrawnFault(fault, strength, 0.5))
    assert (case.watched_s == played_cycle.WATCHED_S) == whole


def test_a_sound_cycle_is_quiet_and_gives_its_endpoints(
    machines: dict[int, SoundMachine], room: RowBuffer
) -> None:
    for machine in machines.values():
        case = judged_cycle.judge(1, played_cycle.play_sound(machine.prepared, room))
        assert case.completed
        assert not case.is_broken
        assert (case.faults, case.counted, case.left_inside) == ((), 0, None)
        assert case.watched_s < played_cycle.WATCHED_S
        found = case.endpoints
        assert found.removed_ml > 0.0
        assert found.removed_percent is not None
        assert 0.0 < found.removed_percent <= 100.0
        assert 2.0 < found.suction_s < found.in_airway_s < 30.0
        assert 80.0 < found.spo2_least_percent <= 100.0


def test_a_machine_that_never_comes_inside_is_refused(machines: dict[int, SoundMachine]) -> None:
    """Its own cycle is broken off in its pre-use test: no fault could come while it matters."""
    prepared = machines[0].prepared
    controller = prepared.loop.controller
    # A plan whose pre-use test asks for more vacuum than its pump can make.
    line = controller.limits.line._replace(parked_closed_mmhg=0.0)
    limits = controller.limits._replace(line=line, vacuum_mmhg=1.0)
    loop = prepared.loop._replace(controller=controller._replace(limits=limits))
    with pytest.raises(InputError, match="before the tip is inside"):
        sound_machine.play(prepared._replace(loop=loop), played_cycle.make_room(JUDGED))


def test_a_drawn_machine_that_cannot_do_its_protocol_makes_room_for_another() -> None:
    def refuse_first(prepared: object) -> object:
        asked.append(prepared)
        if len(asked) < 3:
            raise InputError("suction does not fit its budget")
        return prepared

    asked: list[object] = []
    found, refused = trial.find_machine(TRIAL, 5, refuse_first)
    assert found is asked[2]
    assert len(refused) == 2
    seed = draw.machine_seed(TRIAL, 5, 0)
    assert refused[0] == f"child-10kg, contact, seed {seed}: suction does not fit its budget"
