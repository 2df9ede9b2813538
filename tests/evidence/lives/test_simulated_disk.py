"""The simulated disk and the database on it: what they refuse, and what is left then."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from opensuction.evidence.lives.simulated_computer import FIRST_PID, SimulatedComputer
from opensuction.evidence.lives.simulated_disk import SimulatedFiles
from opensuction.evidence.lives.simulated_process import KILLED
from opensuction.host.host import NS_PER_S, Host, Steps, after
from opensuction.recording.cycle_file import frame
from opensuction.records.database.failure import RecordsError
from opensuction.records.records import Records
from opensuction.runtime.database_writer import DatabaseWriter
from opensuction.runtime.flushed import Flushed, Note
from tests.records import example


def run_on(fault: Callable[[SimulatedComputer], None], test: Callable[[Host], None]) -> None:
    """Have a process do something on a computer with a fault."""

    def main(host: Host, _: object) -> Steps[None]:
        test(host)
        yield after(host.clock, 0.0)

    computer = SimulatedComputer(1, {"main": main})
    fault(computer)
    computer.spawn("main", (), Path("/dev/null"))
    computer.run_until(60 * NS_PER_S)
    assert computer.crashes == []


def test_a_full_disk_takes_the_first_part_of_a_write_and_then_none(tmp_path: Path) -> None:
    path, size = tmp_path / "file", 0

    def write(host: Host) -> None:
        nonlocal size
        file = host.files.create(path)
        size = file.write(memoryview(bytes(10**6)))
        with pytest.raises(OSError, match="No space left"):
            file.write(memoryview(b"more"))
        file.seek(0)
        file.truncate()
        assert file.write(memoryview(bytes(10**6))) == size, "there is room again"
        file.close()

    run_on(lambda computer: computer.disk.fill(10 * NS_PER_S), write)
    assert 0 < size < 10**6


def test_a_disk_that_fails_refuses_to_sync_and_has_only_what_it_had(tmp_path: Path) -> None:
    path, disks = tmp_path / "file", []

    def fail(computer: SimulatedComputer) -> None:
        disks.append(computer.disk)

    def write(host: Host) -> None:
        file = host.files.create(path)
        file.write(memoryview(b"1234"))
        host.files.sync(path)
        file.write(memoryview(b"56"))
        disks[0].failing_until_ns = 60 * NS_PER_S
        with pytest.raises(OSError, match="Input/output error"):
            host.files.sync(path)
        file.close()

    run_on(fail, write)
    assert disks[0].synced == {path: 4}


def test_a_slow_disk_keeps_its_process_waiting(tmp_path: Path) -> None:
    at_ns = []

    def main(host: Host, _: object) -> Steps[None]:
        file = host.files.create(tmp_path / "file")
        for _ in range(20):
            at_ns.append(host.clock.monotonic_ns())
            host.files.sync(tmp_path / "file")
            yield after(host.clock, 0.0)
        file.close()

    computer = SimulatedComputer(1, {"main": main})
    computer.disk.slow_until_ns = 600 * NS_PER_S
    computer.spawn("main", (), tmp_path / "log")
    computer.run_until(600 * NS_PER_S)
    waits_s = [(then - one) / NS_PER_S for one, then in pairwise(at_ns)]
    assert len(waits_s) == 19
    assert 0.1 <= min(waits_s) < 0.6
    assert 2.5 < max(waits_s) <= 3.1


def run_to_death(seed: int, folder: Path, main: Callable[[Host], Steps[None]]) -> SimulatedComputer:
    """Have a process die in the middle of what it asks of the disk after its first step."""

    def steps(host: Host, _: object) -> Steps[None]:
        work = main(host)
        yield next(work)
        process = computer.processes[FIRST_PID]
        process.fate = process.kill
        yield from work

    computer = SimulatedComputer(seed, {"main": steps})
    computer.spawn("main", (), folder / "log")
    computer.run_until(10 * NS_PER_S)
    assert computer.crashes == []
    assert computer.processes[FIRST_PID].status == KILLED
    return computer


@pytest.mark.parametrize("seed", range(20))
def test_a_process_that_dies_writing_leaves_a_part_and_does_nothing_more(
    tmp_path: Path, seed: int
) -> None:
    path, done = tmp_path / "file", []

    def main(host: Host) -> Steps[None]:
        lock = host.locks.take(tmp_path / "lock")
        assert lock is not None
        file = host.files.create(path)
        file.write(memoryview(b"whole"))
        yield after(host.clock, 1.0)
        file.write(memoryview(b"01234567"))
        done.append("more")

    computer = run_to_death(seed, tmp_path, main)
    assert not done
    assert computer.holder(tmp_path / "lock") is None
    assert b"whole01234567".startswith(path.read_bytes())
    assert path.read_bytes().startswith(b"whole")


def test_a_process_that_dies_in_a_commit_has_stored_all_of_it_or_nothing(tmp_path: Path) -> None:
    """And whoever comes after it finds the database open."""
    found = set()
    for seed in range(12):
        address = str(tmp_path / f"{seed}.db")

        def main(host: Host, address: str = address) -> Steps[None]:
            yield after(host.clock, 1.0)
            assert isinstance(host.files, SimulatedFiles)
            host.files.disk.open_records(address).begin_cycle(example.start(), "begin")

        run_to_death(seed, tmp_path, main)
        with Records.open(address) as read:
            assert read.audit().broken is None
            left = read.unfinished_cycles()
            for one in left:
                read.end_cycle(one.id, example.COMPLETED, "end")
            found.add(len(left))
    assert found == {0, 1}


def test_a_recording_whose_sync_was_refused_is_told_and_on_record_all_the_same(
    tmp_path: Path,
) -> None:
    path, said = tmp_path / "run-000000001.mcap", set[str]()
    path.write_bytes(b"a recording")
    (extent,) = frame.measure(path)
    notes, database = Flushed(tmp_path / "notes"), str(tmp_path / "records.db")
    notes.put(path.name, Note(path.name, 1, str(tmp_path), extent, extent, is_closed=True))

    def main(host: Host, _: object) -> Steps[None]:
        writer = DatabaseWriter(database, host, computer.disk.open_records)
        writer.bind([path.name], notes, example.MACHINE)
        while not writer.is_idle:
            said.add(writer.lost)
            yield after(host.clock, 0.1)

    computer = SimulatedComputer(1, {"main": main})
    computer.disk.failing_until_ns = 5 * NS_PER_S
    computer.spawn("main", (), tmp_path / "log")
    computer.run_until(60 * NS_PER_S)
    assert computer.crashes == []
    assert f"the disk may not have {path.name}: Input/output error" in said
    with Records.open(database) as records:
        assert (records.audit().broken, records.audit().recordings) == (None, 1)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("away_until_ns", "another program keeps it locked"),
        ("full_until_ns", "the disk is full"),
        ("failing_until_ns", "the disk failed or is full"),
    ],
)
def test_a_database_refuses_as_sqlite_does_and_takes_all_once_it_is_back(
    tmp_path: Path, name: str, words: str
) -> None:
    computer = SimulatedComputer(1, {})
    setattr(computer.disk, name, 5 * NS_PER_S)
    address = str(tmp_path / "records.db")
    with pytest.raises(RecordsError, match=words):
        computer.disk.open_records(address).begin_cycle(example.start(), "begin")
    computer.now_ns = 5 * NS_PER_S
    records = computer.disk.open_records(address)
    cycle = records.begin_cycle(example.start(), "begin")
    setattr(computer.disk, name, 9 * NS_PER_S)
    with pytest.raises(RecordsError, match=words):
        records.end_cycle(cycle, example.COMPLETED, "end")
    computer.now_ns = 9 * NS_PER_S
    records.end_cycle(cycle, example.COMPLETED, "end")
    records.close()
    with Records.open(address) as read:
        assert read.audit().broken is None
        (one,) = read.history.list_cycles(example.start().machine.serial)
        assert one.outcome == example.COMPLETED.outcome
