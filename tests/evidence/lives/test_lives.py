"""Lives under a simulated clock: the same for a seed, sound as they are, and broken by faults."""

import gc
from io import FileIO
from pathlib import Path
from typing import Any

import pytest

from opensuction.evidence.lives import life, life_fault, lives, simulated_machine
from opensuction.evidence.lives.life_fault import Kind, LifeFault
from opensuction.evidence.lives.life_record import Life, LifeResult
from opensuction.evidence.lives.lives import Campaign
from opensuction.evidence.lives.record_judge import INVARIANTS
from opensuction.evidence.lives.simulated_machine import JUDGED_EVERY_S
from opensuction.host import this_computer
from opensuction.ipc.mailbox import Mailbox
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import NO_REQUESTS, STOP
from opensuction.kernel.vocabulary import Phase
from opensuction.runtime import recorder
from opensuction.runtime.database_writer import DatabaseWriter
from opensuction.runtime.journal import Begun
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.recorder_process import RecorderService
from opensuction.runtime.supervisor import SupervisedProcess
from tests.evidence.lives.chosen_life import broken, play

NOTHING = LifeFault(Kind.SLOW, "", None, 0.0, 0.001)
KILL_RECORDER = LifeFault(Kind.KILL, life_fault.RECORDER, Phase.CHECKING, 0.05, 0.0)
KILL_CONTROL = LifeFault(Kind.KILL, life_fault.CONTROL, Phase.SUCTIONING, 0.05, 0.0)
KILL_EARLY = LifeFault(Kind.KILL, life_fault.CONTROL, Phase.PRELOADING, 0.05, 0.0)
"""The cycle is over before the catheter goes in: the life is short."""
KILL_AT_ONCE = LifeFault(Kind.KILL, life_fault.CONTROL, Phase.CHECKING, 0.02, 0.0)
UNSEEN = range(700_000, 700_060)
"""Seeds of their own beside those of the evidence."""
STOPPED = LifeFault(Kind.STOP, "", Phase.INSERTING, 0.05, 0.0)


@pytest.fixture
def _no_real_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody in a life may ask this computer."""

    def refuse(*_: object) -> int:
        raise AssertionError("the real computer was asked")

    for name in ("monotonic_ns", "wall_ns", "sleep_until"):
        monkeypatch.setattr(this_computer._Clock, name, refuse)
    for port in (this_computer._Locks, this_computer._Datagrams, this_computer._Processes):
        for name in [one for one in vars(port) if not one.startswith("_")]:
            monkeypatch.setattr(port, name, refuse)


@pytest.fixture
def _not_for_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """A life that never settles ends soon after the cycle would."""
    monkeypatch.setattr(life, "LONGEST_S", 20.0)


@pytest.mark.usefixtures("_no_real_clock")
def test_a_life_without_a_fault_is_a_whole_cycle_and_nothing_of_it_is_real() -> None:
    found = play(NOTHING)
    assert found.violations == ()
    phases = [one.what for one in found.events if one.what.startswith("phase")]
    assert phases[:4] == ["phase parked", "phase checking", "phase preloading", "phase inserting"]
    assert phases[-1] == "phase parked"
    assert found.steps > 10_000


@pytest.mark.usefixtures("_no_real_clock")
def test_what_a_controllers_death_leads_to_comes_in_its_order() -> None:
    found = play(KILL_CONTROL)
    assert found.violations == ()
    course = [one.what for one in found.events]
    killed = course.index("control_process was killed")
    later = course[killed:]
    assert later.index("people are told: watchdog-fired") > 0
    assert later.index("control_process is started") < later.index("phase halted")


def _lived_between_two_looks(found: LifeResult) -> bool:
    """True where the first controller was replaced within the second that it had begun in."""
    begun_s = [one.at_s for one in found.events if one.what in ("phase parked", "phase halted")]
    return int(begun_s[0] / JUDGED_EVERY_S) == int(begun_s[1] / JUDGED_EVERY_S)


def test_a_controller_that_lives_between_two_looks_of_the_judge_is_seen() -> None:
    """The rings of the next one are in the place of its own when the judge looks next."""
    found = play(KILL_AT_ONCE)
    assert _lived_between_two_looks(found)
    assert found.violations == ()


def test_what_nobody_kept_of_a_controller_between_two_looks_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It died just after its recorder, in a life of a campaign."""
    faults = (
        LifeFault(Kind.KILL, life_fault.CONTROL, Phase.CHECKING, 0.04904406898830125, 0.0),
        LifeFault(Kind.KILL_WRITING, "", Phase.CHECKING, 0.0204382912380085, 0.0),
    )
    found = life.play(Life(1003135, 46, faults))
    assert _lived_between_two_looks(found)
    assert found.violations == ()
    monkeypatch.setattr(RecorderService, "_finish_before", lambda *_: iter(()))
    assert "rows" in broken(life.play(found.life))


@pytest.mark.parametrize(
    "seconds",
    [
        pytest.param(1.2, marks=pytest.mark.soak),
        pytest.param(2.5, marks=pytest.mark.soak),
        pytest.param(9.0, marks=pytest.mark.sweep),
    ],
)
def test_a_controller_that_stood_still_with_its_whole_computer_is_not_ended(
    seconds: float,
) -> None:
    """Its supervisor stood still as well, and looks before the other can give a sign of life."""
    still = LifeFault(Kind.STANDSTILL, "", Phase.INSERTING, 0.05, seconds)
    found = play(still)
    assert found.violations == ()
    assert not any("killed" in one.what for one in found.events)


@pytest.mark.soak
def test_a_controller_that_comes_just_before_the_end_is_on_record() -> None:
    """Its recorder still looked at the one before, and was told to end."""
    all_killed = LifeFault(Kind.KILL, life_fault.ALL, None, 13.772205654355773, 0.0)
    assert life.play(Life(1005, 60, (all_killed,))).violations == ()


@pytest.mark.parametrize(
    "workers", [pytest.param(1, marks=pytest.mark.sweep), pytest.param(2, marks=pytest.mark.soak)]
)
def test_a_seed_gives_the_same_life_in_this_and_in_other_processes(workers: int) -> None:
    seeds = UNSEEN[47:49]  # of the shorter ones
    campaign = Campaign(seeds, workers=workers)
    alone = [life.play(life.draw(seed)) for seed in seeds]
    shared = lives.run(campaign)
    assert alone == shared
    assert len({one.trace for one in alone}) == 2
    assert [one.life for one in alone] == [life.draw(seed) for seed in seeds]
    result = lives.to_result(campaign, alone, {}, 1.0)
    assert result.trace == lives.to_result(campaign, shared, {}, 2.0).trace
    assert (result.lives, result.asked, result.complete) == (2, 2, True)
    assert [one for one in alone if one.violations] == []
    assert result.ok
    assert result.invariants == INVARIANTS


def test_a_life_of_two_cycles_has_the_faults_of_each() -> None:
    """The first is drawn as for a life of one; the second waits until the patient has rested."""
    drawn = life.draw(4, cycles=2)
    assert tuple(one for one in drawn.faults if one.cycle == 0) == life.draw(4).faults
    assert any(one.title.endswith("#2") for one in drawn.faults)
    found = life.play(drawn)
    assert found.violations == ()
    began_s = [one.at_s for one in found.events if one.what == "phase checking"]
    rested_s = began_s[0] + 180.0
    assert began_s[-1] > rested_s
    came_s = {one.what: one.at_s for one in found.events if one.kind == "fault"}
    came = [one for one in drawn.faults if f"fault {one.title}" in came_s]
    assert {one.cycle for one in came} == {0, 1}
    for fault in came:
        assert (came_s[f"fault {fault.title}"] > rested_s) == (fault.cycle == 1)


def test_a_cycle_that_is_started_after_a_stop_is_no_stop_that_was_not_acted_on() -> None:
    """The nurse presses start 46 ms after a second person's STOP, who looks 60 ms after it."""
    stop = LifeFault(Kind.STOP, "", None, 1.485853564687936, 0.0)
    assert life.play(Life(138678040, 36, (stop,))).violations == ()


def test_a_second_cycle_that_is_not_put_on_record_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    put, begun = DatabaseWriter.put, []

    def put_the_first(writer: DatabaseWriter, entry: Any, context: Any) -> None:
        if isinstance(entry.what, Begun):
            begun.append(entry)
            if len(begun) > 1:
                return
        put(writer, entry, context)

    monkeypatch.setattr(DatabaseWriter, "put", put_the_first)
    assert broken(life.play(Life(1, 3, ()))) == set()
    begun.clear()
    assert broken(life.play(Life(1, 3, (), cycles=2))) == {"kept"}


@pytest.mark.soak
def test_lives_of_three_cycles_hold() -> None:
    found = lives.run(Campaign(range(100, 200), workers=2, cycles=3))
    assert [one for one in found if one.violations] == []


@pytest.mark.soak
def test_lives_that_nobody_has_seen_before_hold() -> None:
    found = lives.run(Campaign(UNSEEN, workers=2))
    assert [one for one in found if one.violations] == []


def test_an_end_that_is_not_put_on_record_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(DatabaseWriter, "_end", lambda *_: None)
    assert broken(play(KILL_EARLY)) == {"record"}


def test_a_stop_that_is_answered_and_not_obeyed_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    receive = Mailbox.receive

    def deaf(box: Mailbox) -> object:
        pressed, answers = receive(box)
        return pressed._replace(abort=False) if pressed != NO_REQUESTS else pressed, answers

    assert STOP == "abort"
    assert play(STOPPED).violations == ()
    monkeypatch.setattr(Mailbox, "receive", deaf)
    assert broken(play(STOPPED)) == {"stop"}


def test_a_recording_that_is_not_what_was_done_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    take, place = recorder.Recorder.take, ROW_COLUMNS.index("outputs.commands.insertion_v")

    def spoil(self: recorder.Recorder, found: object, happened: object) -> None:
        rows = found.rows.copy()  # type: ignore[attr-defined]
        rows[:, place] += 1e-6
        take(self, found._replace(rows=rows), happened)  # type: ignore[attr-defined, arg-type]

    monkeypatch.setattr(recorder.Recorder, "take", spoil)
    assert "recording" in broken(play(KILL_EARLY))


@pytest.mark.usefixtures("_not_for_long")
def test_an_error_that_a_process_does_not_know_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("a mistake")

    monkeypatch.setattr(DatabaseWriter, "reach", fail)
    found = play(NOTHING)
    assert "crash" in broken(found)
    assert any("ZeroDivisionError: a mistake" in one.detail for one in found.violations)


@pytest.mark.usefixtures("_not_for_long")
def test_a_supervisor_that_replaces_nobody_is_found_with_the_fewest_faults_that_show_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(SupervisedProcess, "look", lambda _: None)
    found = play(NOTHING, KILL_RECORDER, LifeFault(Kind.WALL_CLOCK, "", None, 3.0, 60.0))
    assert "rest" in broken(found)
    fewest = lives.shrink(found)
    assert fewest == (KILL_RECORDER,)
    reported = lives.to_played(found, fewest=fewest)
    assert reported.fewest == ("kill-recorder@checking+0.0500",)


def test_faults_are_drawn_over_all_kinds_targets_and_places() -> None:
    drawn = [fault for seed in range(400) for fault in life.draw(seed).faults]
    assert {one.kind for one in drawn} == set(Kind)
    assert {one.target for one in drawn} == {"", *life_fault.TARGETS}
    assert any(one.phase is None for one in drawn)
    assert all(0.0 <= one.after_s <= life_fault.SPAN_S for one in drawn)
    lasting = [one.seconds for one in drawn if one.kind in life_fault.LASTS]
    assert min(lasting) < 0.002
    assert max(lasting) > 9.0
    kills = life.draw(5, (Kind.KILL,)).faults
    assert {one.kind for one in kills} == {Kind.KILL}


def test_the_files_of_a_life_are_closed_and_gone_after_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """That of a recorder that was killed, too."""
    monkeypatch.setattr("opensuction.evidence.lives.simulated_machine.MEMORY", tmp_path)
    assert play(KILL_RECORDER, KILL_EARLY).violations == ()
    files = [one for one in gc.get_objects() if type(one) is FileIO and not one.closed]
    # Others may have files of their own open.
    assert [one.name for one in files if str(one.name).startswith(str(tmp_path))] == []
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_kind_of_fault_is_refused_in_one_line() -> None:
    assert life_fault.check_kinds(["mail", "kill", "mail"]) == (Kind.MAIL, Kind.KILL)
    assert life_fault.check_kinds(["kill, freeze", "mail"]) == (Kind.KILL, Kind.FREEZE, Kind.MAIL)
    assert life_fault.check_kinds([]) == tuple(Kind)
    with pytest.raises(
        InputError, match="unknown kind of fault 'plague'; known: kill, kill-writing, freeze"
    ):
        life_fault.check_kinds(["plague"])


def test_folders_of_commands_that_were_killed_are_removed_by_the_next_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(simulated_machine, "MEMORY", tmp_path)
    other = tmp_path / "other"
    other.mkdir()
    with simulated_machine.room() as lives_on:
        killed = tmp_path / f"{simulated_machine.ROOM}killed"
        killed.mkdir(mode=0o700)
        (killed / "control.ring").touch()
        with simulated_machine.room() as own:
            assert set(tmp_path.iterdir()) == {other, lives_on, own}
    assert list(tmp_path.iterdir()) == [other]


@pytest.mark.soak
def test_a_process_that_is_dead_does_not_stand_still_and_nobody_else_does() -> None:
    dead = LifeFault(Kind.KILL, "supervisor", Phase.INSERTING, 0.1, 0.0)
    frozen = LifeFault(Kind.FREEZE, "supervisor", Phase.INSERTING, 0.2, 2.0)
    alone = life.play(Life(1, 3, (dead,)))
    assert life.play(Life(1, 3, (dead, frozen))).trace == alone.trace
