"""Work spread over processes: answered in order, ended with whoever asked."""

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from opensuction.evidence import worker, worker_pool

WAITS = "__import__('os').write(1, b'working\\n') and __import__('threading').Event().wait()"
"""One write for the line: two processes share the pipe, and Python may write without a buffer."""


def test_answers_come_in_the_order_of_the_tasks() -> None:
    heard: dict[int, object] = {}
    tasks = ["6 * 7", "len('catheter')", "2 ** 10", "sum(range(5))"]
    answers = worker_pool.spread(eval, tasks, 2, heard.__setitem__)
    assert answers == [42, 8, 1024, 10]
    assert [heard[number] for number in sorted(heard)] == answers


def test_no_tasks_have_no_answers() -> None:
    assert worker_pool.spread(eval, [], 2) == []


def test_what_a_task_raises_is_raised_here() -> None:
    with pytest.raises(ZeroDivisionError):
        worker_pool.spread(eval, ["1 // 0", "1"], 1)


DIES = "__import__('os').kill(__import__('os').getpid(), 9)"


def test_a_task_over_which_a_process_died_is_done_by_another(tmp_path: Path) -> None:
    mark = f"__import__('pathlib').Path({str(tmp_path / 'mark')!r})"
    warned: list[str] = []
    # The first one dies unless the second, which leaves a mark, was done before.
    tasks = [f"7 if {mark}.exists() else {DIES}", f"{mark}.touch() or 5", "1 + 1"]
    assert worker_pool.spread(eval, tasks, 1, warn=warned.append) == [7, 5, 2]
    assert warned == ["A process was killed by signal 9: another one does its task anew"]


def test_a_task_that_kills_every_process_ends_the_work() -> None:
    warned: list[str] = []
    with pytest.raises(worker_pool.WorkerLostError, match="3 processes died over the same task"):
        worker_pool.spread(eval, [DIES], 2, warn=warned.append)
    assert len(warned) == 2


@contextmanager
def begun(program: str, folder: Path) -> Iterator["subprocess.Popen[str]"]:
    """A program whose two processes work; it is gone afterwards, whatever came of it."""
    with subprocess.Popen(
        [sys.executable, "-c", program],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stderr is not None
            assert [process.stderr.readline() for _ in range(2)] == ["working\n"] * 2
            yield process
        finally:
            process.kill()


def test_a_signal_ends_the_processes_before_it_is_heard_of(tmp_path: Path) -> None:
    program = (
        "import os, signal\n"
        "from opensuction.evidence import worker_pool\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "try:\n"
        f"    worker_pool.spread(eval, [{WAITS!r}] * 2, 2, warn=print)\n"
        "except KeyboardInterrupt:\n"
        "    try:\n"
        "        os.waitpid(-1, os.WNOHANG)\n"
        "        print('some are left', flush=True)\n"
        "        os._exit(1)\n"
        "    except ChildProcessError:\n"
        "        print('no process is left')\n"
    )
    with begun(program, tmp_path) as process:
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=60)[0] == "no process is left\n"


def test_no_process_outlives_one_that_was_killed(tmp_path: Path) -> None:
    program = (
        "from opensuction.evidence import worker_pool; "
        f"worker_pool.spread(eval, [{WAITS!r}] * 2, 2)"
    )
    with begun(program, tmp_path) as process:
        assert process.stderr is not None
        process.kill()
        assert process.stderr.read() == ""  # ends when both of its processes have gone


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="the system binds to no cores")
def test_a_process_that_is_bound_to_a_core_counts_that_one() -> None:
    program = (
        "import os; from opensuction.evidence import worker_pool; "
        "os.sched_setaffinity(0, {min(os.sched_getaffinity(0))}); print(worker_pool.count_cores())"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert done.stdout.split() == [b"1"]


def test_a_system_that_binds_to_no_cores_counts_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    assert worker_pool.count_cores() == 6


def test_a_process_whose_answers_nobody_takes_ends_without_a_word() -> None:
    """Its input is still open: it said ``Fatal Python error``, behind the command's last line."""
    command = [sys.executable, "-m", worker.__name__]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        pickle.dump((str, 1), process.stdin)
        process.stdin.flush()
        assert process.wait(60.0) == 0
        assert process.stderr.read() == b""
