"""Work spread over processes of their own; each answers one task at a time.

A process that dies, killed for its memory or by a person, takes nothing along: another one begins
its task anew.
"""

import os
import pickle
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any, TypeVar

MOST_LOST = 3
"""Processes that may die over one task: it is not chance any more."""
WORKER = (sys.executable, "-m", "opensuction.evidence.worker")

Task = TypeVar("Task")
Answer = TypeVar("Answer")


class WorkerLostError(Exception):
    """Process after process died over the same task."""


def count_cores() -> int:
    """Processor cores that this process may use: as many processes can work at once."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class _DiedError(Exception):
    """A process ended without an answer."""


def _ask(
    process: "subprocess.Popen[bytes]", function: Callable[[Task], Answer], task: Task
) -> Answer:
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        pickle.dump((function, task), process.stdin)
        process.stdin.flush()
        answer = pickle.load(process.stdout)
    except (EOFError, pickle.UnpicklingError, BrokenPipeError):
        # What it was not yet told is dropped here: Popen would fail over it as it closes.
        with suppress(BrokenPipeError):
            process.stdin.close()
        raise _DiedError from None
    if isinstance(answer, BaseException):
        raise answer
    found: Answer = answer
    return found


def _describe(status: int) -> str:
    """Ending of a process, in words."""
    return f"killed by signal {-status}" if status < 0 else f"ended with status {status}"


class _WorkerPool:
    """State that the threads of `spread` share; each has one process work after the other."""

    def __init__(self, function: Callable[[Any], Any], tasks: Sequence[Any]) -> None:
        self.answers: dict[int, Any] = {}
        self.failures: list[BaseException] = []
        self._function, self._tasks = function, tasks
        self._waiting: SimpleQueue[int] = SimpleQueue()
        for number in range(len(tasks)):
            self._waiting.put(number)
        self._lost: Counter[int] = Counter()
        self._processes: list[subprocess.Popen[bytes]] = []
        self._lock = threading.Lock()

    def employ(self, tell: Callable[[int, Any], None], warn: Callable[[str], None]) -> None:
        """Have processes work until no task is left or something fails."""
        try:
            while not self.failures:
                # A session of its own: Ctrl-C on a terminal is for the command alone.
                with subprocess.Popen(
                    WORKER, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
                ) as process:
                    self._processes.append(process)
                    self._work(process, tell, warn)
        except Empty:
            pass
        except BaseException as failure:
            self.failures.append(failure)

    def end(self, ending: BaseException) -> None:
        """Have no process work any more, and wait until none does."""
        self.failures.append(ending)
        for process in tuple(self._processes):
            process.kill()
            process.wait()

    def _work(
        self,
        process: "subprocess.Popen[bytes]",
        tell: Callable[[int, Any], None],
        warn: Callable[[str], None],
    ) -> None:
        """Have one process do tasks until none is left, something fails or it dies."""
        while not self.failures:
            number = self._waiting.get_nowait()
            try:
                answer = _ask(process, self._function, self._tasks[number])
            except _DiedError:
                if self.failures:
                    return  # it was ended with the others
                self._lose(number, _describe(process.wait()), warn)
                return
            with self._lock:
                self.answers[number] = answer
                tell(number, answer)

    def _lose(self, number: int, how: str, warn: Callable[[str], None]) -> None:
        """Let another process do a task over which one has died."""
        with self._lock:
            self._lost[number] += 1
            if self._lost[number] == MOST_LOST:
                raise WorkerLostError(
                    f"{MOST_LOST} processes died over the same task, the last one {how}"
                )
            warn(f"A process was {how}: another one does its task anew")
        self._waiting.put(number)


def spread(
    function: Callable[[Task], Answer],
    tasks: Sequence[Task],
    workers: int,
    tell: Callable[[int, Answer], None] = lambda *_: None,
    warn: Callable[[str], None] = lambda _: None,
) -> list[Answer]:
    """Answers of a function to tasks, in their order, found by processes that end with this one.

    function: of a module, so that a process can import it. tell: hears of each answer with the
    number of its task, from other threads, one call at a time. warn: hears of a process that died.
    Raises what a task raised first, and WorkerLostError for one over which `MOST_LOST` died. What
    is raised in the thread that waits here, as a signal, ends the processes first.
    """
    pool = _WorkerPool(function, tasks)
    threads = [
        threading.Thread(target=pool.employ, args=(tell, warn), daemon=True)
        for _ in range(min(workers, len(tasks)))
    ]
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    except BaseException as ending:
        pool.end(ending)
        raise
    if pool.failures:
        raise pool.failures[0]
    return [pool.answers[number] for number in range(len(tasks))]
