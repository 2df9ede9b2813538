"""The simulated computer keeps the same contract as the real one: each test runs on both."""

import signal
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from opensuction.evidence.lives.simulated_computer import SimulatedComputer
from opensuction.host.host import NS_PER_S, Host, Steps, Work, after, finish
from opensuction.host.this_computer import THIS_COMPUTER

Test = Callable[[Host], Steps[None]]
Runner = Callable[[Test], None]
ENDS_S = 30.0


def really(test: Test) -> None:
    """Run a test's steps on this computer."""
    finish(test(THIS_COMPUTER), THIS_COMPUTER.clock)


def simulated(test: Test, tmp_path: Path) -> None:
    """Run a test's steps on a simulated computer."""
    computer = SimulatedComputer(1, {"test": lambda host, _: test(host)})
    process = computer.spawn("test", (), tmp_path / "test.log")
    computer.run_until(computer.now_ns + round(ENDS_S * NS_PER_S))
    assert not computer.crashes, computer.crashes
    assert process.poll() == 0


@pytest.fixture(
    params=[pytest.param("this computer", marks=pytest.mark.real_time), "a simulated one"]
)
def run(request: pytest.FixtureRequest, tmp_path: Path) -> Runner:
    return really if request.param == "this computer" else lambda test: simulated(test, tmp_path)


def test_a_step_does_not_begin_before_it_is_due(run: Runner) -> None:
    def test(host: Host) -> Steps[None]:
        for seconds in (0.02, 0.0, 0.05):
            due_ns = after(host.clock, seconds)
            yield due_ns
            assert host.clock.monotonic_ns() >= due_ns

    run(test)


def test_a_lock_is_held_until_it_is_closed(run: Runner, tmp_path: Path) -> None:
    def test(host: Host) -> Steps[None]:
        path = tmp_path / "lock"
        assert host.locks.holder(path) is None
        first = host.locks.take_file(path)
        assert first is not None
        assert host.locks.take_file(path) is None
        yield after(host.clock, 0.0)
        first.close()
        again = host.locks.take_file(path)
        assert again is not None
        again.close()
        with pytest.raises(OSError, match="No such file"):
            host.locks.take_file(tmp_path / "nowhere" / "lock")

    run(test)


def test_datagrams_come_once_in_order_and_are_refused_where_nobody_listens(
    run: Runner, tmp_path: Path
) -> None:
    def test(host: Host) -> Steps[None]:
        path, sender = tmp_path / "inbox", host.datagrams.sender(0.1)
        with pytest.raises(OSError, match=r"No such file|refused"):
            sender.send(path, b"0")
        inbox = host.datagrams.listen(path)
        assert inbox.receive(10) is None
        for text in (b"1", b"2", b"123456"):
            sender.send(path, text)
        yield after(host.clock, 0.01)
        assert [inbox.receive(3) for _ in range(4)] == [b"1", b"2", b"123", None]
        inbox.close()
        with pytest.raises(OSError, match=r"No such file|refused"):
            sender.send(path, b"4")
        sender.close()

    run(test)


def test_an_inbox_has_room_for_some_ten_datagrams(run: Runner, tmp_path: Path) -> None:
    def test(host: Host) -> Steps[None]:
        inbox, sender = host.datagrams.listen(tmp_path / "inbox"), host.datagrams.sender(0.05)
        yield after(host.clock, 0.0)

        def fill() -> None:
            for _ in range(1000):
                sender.send(tmp_path / "inbox", b"1")

        with pytest.raises(OSError, match="timed out"):
            fill()
        count = 0
        while inbox.receive(10) is not None:
            count += 1
        assert 5 < count < 500
        inbox.close()
        sender.close()

    run(test)


def test_a_worker_goes_on_when_it_is_woken_and_when_it_is_due(run: Runner) -> None:
    done: list[str] = []

    def work(host: Host) -> Work:
        done.append("begun")
        yield None
        done.append("woken")
        yield after(host.clock, 0.02)
        done.append("due")

    def test(host: Host) -> Steps[None]:
        worker = host.begin_worker(work(host))
        yield after(host.clock, 0.1)
        assert done == ["begun"]
        worker.wake()
        yield after(host.clock, 0.3)
        assert done == ["begun", "woken", "due"]
        assert worker.has_ended

    run(test)


def test_tokens_differ(run: Runner) -> None:
    def test(host: Host) -> Steps[None]:
        assert len({host.token(8) for _ in range(100)}) == 100
        assert len(host.token(5)) == 5
        yield after(host.clock, 0.0)

    run(test)


def test_a_file_is_made_once_and_holds_what_was_written(run: Runner, tmp_path: Path) -> None:
    path = tmp_path / "file"

    def test(host: Host) -> Steps[None]:
        file = host.files.create(path)
        with pytest.raises(FileExistsError):
            host.files.create(path)
        assert file.write(memoryview(b"whole and more")) == 14
        file.seek(5)
        file.truncate()
        assert path.read_bytes() == b"whole"
        host.files.sync(path)
        file.close()
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
        with pytest.raises(FileNotFoundError):
            host.files.sync(tmp_path / "nowhere")
        with pytest.raises(FileNotFoundError):
            host.files.create(tmp_path / "nowhere" / "file")
        yield after(host.clock, 0.0)

    run(test)


def test_a_simulated_process_that_is_killed_does_nothing_more_and_its_locks_are_free(
    tmp_path: Path,
) -> None:
    steps: list[int] = []
    path = tmp_path / "lock"

    def main(host: Host, _: object) -> Steps[None]:
        host.locks.take(path)
        host.datagrams.listen(tmp_path / "inbox")
        while True:
            steps.append(host.clock.monotonic_ns())
            yield after(host.clock, 0.01)

    computer = SimulatedComputer(1, {"main": main})
    process = computer.spawn("main", (), tmp_path / "log")
    computer.run_until(3 * NS_PER_S)
    assert computer.holder(path) == process.pid
    computer.freeze(process.pid, 0.5)
    count = len(steps)
    computer.run_until(computer.now_ns + round(0.4 * NS_PER_S))
    assert len(steps) == count, "it stands still"
    computer.run_until(computer.now_ns + round(0.4 * NS_PER_S))
    assert len(steps) > count
    process.send_signal(signal.SIGKILL)
    count = len(steps)
    computer.run_until(10 * NS_PER_S)
    assert len(steps) == count
    assert process.poll() == -signal.SIGKILL
    assert computer.holder(path) is None
    assert not computer.inboxes


def test_a_simulated_process_cannot_sleep_within_a_step(tmp_path: Path) -> None:
    def main(host: Host, _: object) -> Steps[None]:
        host.clock.sleep_until(after(host.clock, 1.0))
        yield 0

    computer = SimulatedComputer(1, {"main": main})
    assert computer.spawn("main", (), tmp_path / "log").poll() is None
    computer.run_until(5 * NS_PER_S)
    assert "sleeps until" in computer.crashes[0]


def test_a_simulated_process_that_is_stopped_goes_on_when_it_is_told_to(tmp_path: Path) -> None:
    steps: list[str] = []

    def work(host: Host) -> Work:
        yield None
        steps.append("woken")
        yield after(host.clock, 0.1)
        steps.append("due")

    def main(host: Host, _: object) -> Steps[None]:
        worker = host.begin_worker(work(host))
        yield after(host.clock, 0.5)
        worker.wake()
        while True:
            steps.append("step")
            yield after(host.clock, 0.1)

    computer = SimulatedComputer(1, {"main": main})
    process = computer.spawn("main", (), tmp_path / "log")
    while "woken" not in steps:
        computer.run_until(computer.now_ns + NS_PER_S // 100)
    process.send_signal(signal.SIGSTOP)
    known = list(steps)
    computer.run_until(computer.now_ns + 60 * NS_PER_S)
    assert steps == known
    process.send_signal(signal.SIGCONT)
    computer.run_until(computer.now_ns + NS_PER_S // 2)
    assert steps.count("due") == 1
    assert 3 <= len(steps) - len(known) <= 8
    process.send_signal(signal.SIGSTOP)
    process.kill()
    computer.run_until(computer.now_ns + NS_PER_S)
    assert process.poll() == -signal.SIGKILL
