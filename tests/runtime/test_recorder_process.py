"""The recorder beside a machine that runs: what it keeps, and what its death does."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from opensuction.controller import configuration
from opensuction.ipc.ring import EventReader, ReadCheckpoint, RingReader
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.recording.cycle_file.reader import RecordingReader
from opensuction.records.entry import Outcome
from opensuction.records.records import Records
from opensuction.runtime import machine_folder
from opensuction.runtime.control_process import settings_file
from opensuction.runtime.machine_folder import CONFIGURATION, EVENTS, MARK, RING
from tests.runtime.identity import ABOUT
from tests.runtime.kept import replayed, ticks_of, told_of
from tests.runtime.room import INSIDE_MM, Room
from tests.runtime.simulated_room import simulated


@pytest.fixture
def room() -> Iterator[Room]:
    with simulated() as made:
        yield made


def is_followed(room: Room) -> bool:
    """Whether a recorder has read rows of the controller that lives."""
    run = RingReader(room.folder / RING).facts.told["run"]
    return ReadCheckpoint(room.folder / MARK).find(run) is not None


def test_a_cycle_is_kept_whole_and_replays_to_the_last_bit(room: Room, tmp_path: Path) -> None:
    room.record(tmp_path / "kept")
    # A recording is whole where its recorder has followed the second before it.
    assert room.wait(lambda: is_followed(room))
    followed = room.now("inputs.tick")
    assert room.wait(lambda: room.now("inputs.tick") > followed + 1500.0)
    room.reach(lambda: room.phase() == Phase.CLOSING)
    assert room.wait(lambda: room.phase() == Phase.PARKED)
    room.end_recorder()
    path = sorted((tmp_path / "kept").glob("*.mcap"))[-1]
    ticks = ticks_of(path)
    assert (np.diff(ticks[:, 0]) == 1.0).all()
    told = told_of(path)
    assert ("request", "start") in told
    phases = [name for kind, name in told if kind == "phase"]
    at = phases.index("checking")  # after a cycle that was broken off it was halted, too
    assert phases[at - 1 : at + 2] == ["parked", "checking", "preloading"]
    verdict = replayed(path)
    assert verdict.identical, verdict.first
    assert (verdict.ticks, verdict.gaps, verdict.starts) == (len(ticks), 0, 1)
    with Records.open(str(room.folder / "records.db")) as records:
        last = records.history.list_cycles("twin-1", 1)[0]
        assert last.recording == path.name
        assert (last.outcome, last.requested_by) == (Outcome.COMPLETED, "nurse")
        (bound,) = records.history.list_recordings([last])
        assert (bound.file.name, bound.file.is_closed) == (path.name, True)
        assert records.audit().recordings == len(list((tmp_path / "kept").glob("*.mcap")))
        assert records.audit().broken is None


def test_killed_it_is_missed_and_another_goes_on_where_it_was(room: Room, tmp_path: Path) -> None:
    room.record(tmp_path)
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    assert room.recorder is not None
    room.recorder.kill()
    room.recorder.wait()
    last = room.now("inputs.tick")
    first = sorted(tmp_path.glob("*.mcap"))[-1]
    # This test's own way to look included.
    assert last - ticks_of(first)[-1, 0] < 250.0
    assert room.wait(room.is_recorder_missed, 4.0)
    room.record(tmp_path)
    assert room.wait(lambda: not room.is_recorder_missed(), 5.0)
    assert room.wait(lambda: room.phase() in RESTING)
    room.end_recorder()
    second = first.with_name(f"{first.stem}-2.mcap")
    # The ring had what nobody wrote.
    assert ticks_of(second)[0, 0] == ticks_of(first)[-1, 0] + 1.0
    assert replayed(second).identical
    assert ("alarm", "recorder-lost") in told_of(second)
    with Records.open(str(room.folder / "records.db")) as records:
        cycles = records.history.list_cycles("twin-1", 9)
        assert cycles[0].recording == first.name
        assert cycles[0].outcome in (Outcome.COMPLETED, Outcome.ABORTED)
        assert records.unfinished_cycles() == []
        bound = [one.file for one in records.history.list_recordings(cycles[:1])]
        assert [(one.name, one.is_closed) for one in bound] == [
            (first.name, False),
            (second.name, True),
        ]
        assert records.audit().broken is None
        first.write_bytes(first.read_bytes()[:-1000])
        assert f"the recording {first.name} of cycle {cycles[0].number} of" in str(
            records.audit().broken
        )


def test_of_a_controller_that_was_killed_everything_is_kept(room: Room, tmp_path: Path) -> None:
    room.record(tmp_path)
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    room.stop()
    last = room.now("inputs.tick")
    before = sorted(tmp_path.glob("*.mcap"))[-1]
    room.begin()
    assert room.wait(lambda: "controller-restarted" in done(room))
    assert room.wait(lambda: room.phase() in RESTING)
    room.end_recorder()
    assert ticks_of(before)[-1, 0] == last
    with Records.open(str(room.folder / "records.db")) as records:
        cycle = records.history.list_cycles("twin-1", 1)[0]
        assert (cycle.recording, cycle.outcome) == (before.name, Outcome.INTERRUPTED)
        assert "the controller died while" in cycle.detail
    # Where the next one has started late the drives have brought the catheter out before it.
    recorded = len(list(tmp_path.glob("*.mcap"))) > 1
    assert done(room) >= {"start", "controller-restarted"} | ({"drawn-out"} if recorded else set())


def done(room: Room) -> set[str]:
    """What is on record that was done."""
    with Records.open(str(room.folder / "records.db")) as records:
        return {one.what for one in records.history.list_actions("twin-1", 20)}


def test_after_the_death_of_both_nothing_of_either_is_missing(room: Room, tmp_path: Path) -> None:
    room.record(tmp_path)
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    assert room.recorder is not None
    room.recorder.kill()
    room.recorder.wait()
    room.stop()
    last = room.now("inputs.tick")
    first = sorted(tmp_path.glob("*.mcap"))[-1]
    room.begin()
    room.record(tmp_path)
    assert room.wait(lambda: room.phase() in RESTING)
    room.end_recorder()
    second = first.with_name(f"{first.stem}-2.mcap")
    kept = np.concatenate((ticks_of(first)[:, 0], ticks_of(second)[:, 0]))
    assert (np.diff(kept) == 1.0).all()
    assert kept[-1] == last
    with Records.open(str(room.folder / "records.db")) as records:
        cycle = records.history.list_cycles("twin-1", 1)[0]
        assert (cycle.recording, cycle.outcome) == (first.name, Outcome.INTERRUPTED)
        assert records.audit().broken is None


def test_without_a_database_it_is_missed_and_later_everything_is_on_record(
    room: Room, tmp_path: Path
) -> None:
    # One that ended as it should is missed by nobody; of what it left the next one takes first.
    room.record(tmp_path)
    room.end_recorder()
    room.stop()
    room.begin()
    database = tmp_path / "away" / "records.db"
    machine_folder.write(room.folder, ABOUT._replace(database=str(database)))
    (tmp_path / "away").write_text("no folder")
    room.record(tmp_path)
    room.reach(lambda: room.phase() in (Phase.CLOSING, Phase.ABORTING))
    assert room.wait(room.is_recorder_missed, 4.0)
    (tmp_path / "away").unlink()
    assert room.wait(lambda: not room.is_recorder_missed(), 6.0)
    assert room.wait(lambda: room.phase() in RESTING)
    room.end_recorder("opensuction: not kept: ")
    with Records.open(str(database)) as records:
        assert records.history.list_cycles("twin-1", 1)[0].requested_by == "nurse"
        conditions = {one.condition for one in records.history.list_alarms("twin-1", 9)}
        assert "RECORDER_LOST" in conditions


def test_a_catheter_that_was_changed_is_the_one_of_the_next_cycle(
    room: Room, tmp_path: Path
) -> None:
    database = str(tmp_path / "records.db")
    told = ABOUT._replace(database=database)
    machine_folder.write(room.folder, told)
    room.record(tmp_path)
    machine_folder.write(room.folder, told._replace(catheter=told.catheter._replace(label="c-2")))
    room.reach(lambda: room.phase() in (Phase.CLOSING, Phase.ABORTING))
    assert room.wait(lambda: room.phase() in RESTING)
    room.end_recorder()
    with Records.open(database) as records:
        cycles = records.history.list_cycles("twin-1", 9)
        assert {one.catheter for one in cycles} == {"c-2"}


def test_other_settings_are_taken_at_rest_and_recorded_as_what_they_are(
    room: Room, tmp_path: Path
) -> None:
    text = (room.folder / CONFIGURATION).read_text()
    chosen = configuration.from_json(text)
    limits = chosen.settings.limits
    other = chosen._replace(
        settings=chosen.settings._replace(
            limits=limits._replace(vacuum_mmhg=limits.vacuum_mmhg - 1.0)
        )
    )
    room.record(tmp_path)
    (room.folder / settings_file("k-1")).write_text(configuration.to_json(other))
    room.ask("set_protocol", "k-1")
    assert room.wait(lambda: ("k-1", "set") in verdicts(room))
    (room.folder / settings_file("k-2")).write_text("{}")
    for key in ("k-2", "k-3", "../k"):
        room.ask("set_protocol", key)
        assert room.wait(lambda key=key: key in dict(verdicts(room)))  # type: ignore[misc]
    said = dict(verdicts(room))
    assert said["k-2"].startswith("refused: controller settings")
    assert said["k-3"] == "refused: no settings of this key"
    assert said["../k"] == "malformed"
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    (room.folder / settings_file("k-4")).write_text(text)
    room.ask("set_protocol", "k-4")
    assert room.wait(lambda: ("k-4", "not at rest") in verdicts(room))
    assert room.wait(lambda: room.phase() in RESTING)
    room.end_recorder()
    path = sorted(tmp_path.glob("*.mcap"))[-1]
    reader = RecordingReader(path)
    assert reader.heading.settings_hash == configuration.hash_of(other)
    reader.close()
    verdict = replayed(path)
    assert verdict.identical, verdict.first


def verdicts(room: Room) -> list[tuple[str, str]]:
    told = EventReader(room.folder / EVENTS).read()[0]
    asked = [one.fields for one in told if one.fields["kind"] == "request"]
    return [(one["key"], one["verdict"]) for one in asked if one["ask"] in ("", "set_protocol")]
