"""Faults of disk and database in lives: what they do, and mistakes that they find."""

import pytest

from opensuction.evidence.lives import life
from opensuction.evidence.lives.life_fault import ALL, RECORDER, Kind, LifeFault
from opensuction.evidence.lives.life_record import Life
from opensuction.ipc.ring import Place, ReadCheckpoint
from opensuction.kernel.vocabulary import CYCLE, Phase, name_of
from opensuction.recording.cycle_file.frame import Extent
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.runtime import database_writer, loop, recorder
from opensuction.runtime.database_writer import DatabaseWriter, Task
from opensuction.runtime.recorder_process import REFUSED_S
from opensuction.runtime.recorder_source import Source
from tests.evidence.lives.chosen_life import broken, play

LOST = "people are told: recorder-lost"
FULL = LifeFault(Kind.DISK_FULL, "", Phase.INSERTING, 0.05, 5.0)
FULL_FOR_A_MOMENT = FULL._replace(seconds=0.3)
FAILING = LifeFault(Kind.DISK_FAILING, "", Phase.CLOSING, 0.05, 5.0)
FAILING_AT_THE_SYNC = FAILING._replace(after_s=1.4, seconds=0.3)
"""A second after the machine has come to rest; no entry is stored then."""
SLOW = LifeFault(Kind.DISK_SLOW, "", Phase.INSERTING, 0.05, 8.0)
AWAY = LifeFault(Kind.DATABASE, "", Phase.CHECKING, 0.0, 8.0)


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(FULL, id="full"),
        pytest.param(FAILING, id="failing", marks=pytest.mark.soak),
        pytest.param(FAILING_AT_THE_SYNC, id="failing at the sync", marks=pytest.mark.sweep),
        pytest.param(SLOW, id="slow", marks=pytest.mark.soak),
        pytest.param(AWAY, id="away", marks=pytest.mark.sweep),
    ],
)
def test_people_are_told_of_a_disk_or_database_that_keeps_nothing(fault: LifeFault) -> None:
    found = play(fault)
    assert found.violations == ()
    course = [one.what for one in found.events]
    assert LOST in course[course.index(f"fault {fault.title}") :]


def test_nobody_is_told_of_a_disk_that_is_full_for_a_moment_and_nothing_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nor is it asked all the time: what it has refused is read again each time."""
    refused, go_back = [], Source.go_back

    def note(source: Source, row: int) -> None:
        refused.append(row)
        go_back(source, row)

    monkeypatch.setattr(Source, "go_back", note)
    found = play(FULL_FOR_A_MOMENT)
    assert found.violations == ()
    assert LOST not in [one.what for one in found.events]
    assert 1 <= len(refused) <= FULL_FOR_A_MOMENT.seconds / REFUSED_S + 1.0


@pytest.mark.sweep
def test_rows_that_a_disk_never_took_while_it_was_full_are_told_to_the_last() -> None:
    """Full for longer than the ring holds: they were followed, and are in no recording."""
    assert play(FULL._replace(seconds=13.0)).violations == ()


@pytest.mark.soak
def test_a_recording_that_a_full_disk_let_begin_and_not_go_on_loses_no_row() -> None:
    """Its first rows are given again from the controller's first tick on."""
    full = LifeFault(Kind.DISK_FULL, "", None, 1.369787175134571, 1.8172825967691226)
    assert life.play(Life(20298, 60, (full,))).violations == ()


def test_a_recording_goes_on_where_its_first_rows_are_given_again() -> None:
    """Those of the rest before the cycle are among them, at each try: the rest after it is not
    over with them, and the state before a later row is not that before them.
    """
    full = LifeFault(Kind.DISK_FULL, "", Phase.CHECKING, 0.0241827261014269, 6.786021635629751)
    assert life.play(Life(72, 19, (full,))).violations == ()


def test_a_disk_that_is_full_twice_has_no_row_twice() -> None:
    """At first as the recording begins: it begins with the state before its rows or not at all."""
    faults = (
        LifeFault(Kind.DISK_FULL, "", None, 9.775208979312207, 1.043801994584547),
        LifeFault(Kind.DISK_FULL, "", Phase.CHECKING, 0.028947704318824874, 0.0032601508136754723),
    )
    assert life.play(Life(255396259, 36, faults)).violations == ()


@pytest.mark.soak
def test_what_a_controller_left_waits_for_room_where_all_died_on_a_full_disk() -> None:
    faults = (FULL._replace(seconds=8.5), LifeFault(Kind.KILL, ALL, Phase.INSERTING, 2.6, 0.0))
    assert play(*faults).violations == ()


def test_rows_that_a_full_disk_refused_and_nobody_asks_for_again_are_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Source, "go_back", lambda *_: None)
    assert broken(play(FULL_FOR_A_MOMENT)) == {"rows"}


@pytest.mark.soak
def test_a_recording_that_nobody_syncs_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(database_writer, "_sync", lambda *_, **__: None)
    assert broken(play(FULL_FOR_A_MOMENT)) == {"kept"}


def test_a_sync_that_failed_and_that_nobody_tells_of_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(DatabaseWriter, "_show_loss", lambda _: iter(()))
    assert broken(play(FAILING_AT_THE_SYNC)) == {"kept"}


@pytest.mark.soak
def test_rows_noted_as_kept_before_a_slow_disk_has_them_are_found_where_nobody_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A recorder that dies while the disk is slow is replaced by one that goes on behind them."""
    put = ReadCheckpoint.set

    def hasty(mark: ReadCheckpoint, run: str, place: Place) -> None:
        put(mark, run, place._replace(row=place.row + 500))

    dies = LifeFault(Kind.KILL, RECORDER, Phase.INSERTING, 2.0, 0.0)
    assert play(SLOW, dies).violations == ()
    monkeypatch.setattr(ReadCheckpoint, "set", hasty)
    monkeypatch.setattr(loop, "WATCHED", {})
    assert "rows" in broken(play(SLOW, dies))


@pytest.mark.parametrize(
    "seed", [43, *(pytest.param(one, marks=pytest.mark.soak) for one in range(44, 64))]
)
def test_a_disk_that_keeps_the_recorder_waiting_for_ten_seconds_loses_no_row(seed: int) -> None:
    """One write in twenty takes .1 to 3 s: what comes meanwhile is written in one."""
    slow = SLOW._replace(after_s=0.1 * (seed - 43), seconds=10.0)
    assert play(slow, seed=seed).violations == ()


@pytest.mark.soak
def test_a_recorder_that_asks_a_slow_disk_for_each_fifty_rows_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(recorder, "MOST_ROWS", 50)
    slow = SLOW._replace(seconds=10.0)
    assert any("rows" in broken(play(slow, seed=seed)) for seed in range(43, 63))


DIES_WRITING = LifeFault(Kind.KILL_WRITING, "", Phase.INSERTING, 0.05, 0.0)


@pytest.mark.parametrize(
    "phase",
    [
        Phase.INSERTING,
        *(pytest.param(one, marks=pytest.mark.soak) for one in sorted(CYCLE)),
    ],
    ids=name_of,
)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.soak)])
def test_a_recorder_that_dies_in_the_middle_of_a_write_loses_nothing(
    phase: Phase, seed: int
) -> None:
    found = play(DIES_WRITING._replace(phase=int(phase)), seed=seed)
    assert found.violations == ()
    course = [one.what for one in found.events]
    came = course.index("fault kill-writing comes")
    assert course[came + 1] == "recorder_process was killed"


def test_a_write_that_is_noted_after_it_and_not_before_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What a write that was broken off has left counts as put there by somebody else then."""

    def hash_of(writer: RecordingWriter, data: bytes) -> object:
        hashed = writer._sha256.copy()
        hashed.update(data)
        if writer._flushing is not None:
            writer.extent = Extent(writer._offset + len(data), hashed.hexdigest())
        return hashed

    monkeypatch.setattr(RecordingWriter, "_hash", hash_of)
    assert broken(play(DIES_WRITING)) == {"record"}
    assert broken(play(DIES_WRITING._replace(kind=Kind.KILL, target=RECORDER))) == set()


@pytest.mark.sweep
def test_an_entry_that_is_dropped_while_the_database_is_away_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    try_it = DatabaseWriter._try

    def careless(writer: DatabaseWriter, task: Task) -> bool:
        try_it(writer, task)
        writer.lost = ""
        return True

    monkeypatch.setattr(DatabaseWriter, "_try", careless)
    assert "kept" in broken(play(AWAY))
