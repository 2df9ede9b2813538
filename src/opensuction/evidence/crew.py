"""Work spread over processes of their own; each answers one task at a time."""

import pickle
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from queue import Empty, SimpleQueue
from typing import Generic, TypeVar

WORKER = (sys.executable, "-m", "opensuction.evidence.worker")

Task = TypeVar("Task")
Answer = TypeVar("Answer")


class _Crew(Generic[Task, Answer]):
    """Processes, and a thread for each that hands out tasks."""

    def __init__(
        self,
        function: Callable[[Task], Answer],
        tasks: Sequence[Task],
        tell: Callable[[int, Answer], None],
    ) -> None:
        self._function = function
        self._tasks: SimpleQueue[tuple[int, Task]] = SimpleQueue()
        for numbered in enumerate(tasks):
            self._tasks.put(numbered)
        self._tell = tell
        self._lock = threading.Lock()
        self.answers: dict[int, Answer] = {}
        self.failures: list[BaseException] = []

    def work(self) -> None:
        """Have one process do tasks until none is left or something fails."""
        # A session of its own: Ctrl-C on a terminal is for the command alone.
        with subprocess.Popen(
            WORKER, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
        ) as process:
            try:
                while not self.failures:
                    number, task = self._tasks.get_nowait()
                    answer = self._ask(process, task)
                    with self._lock:
                        self.answers[number] = answer
                        self._tell(number, answer)
            except Empty:
                pass
            except BaseException as failure:
                self.failures.append(failure)

    def _ask(self, process: "subprocess.Popen[bytes]", task: Task) -> Answer:
        assert process.stdin is not None
        assert process.stdout is not None
        pickle.dump((self._function, task), process.stdin)
        process.stdin.flush()
        answer = pickle.load(process.stdout)
        if isinstance(answer, BaseException):
            raise answer
        found: Answer = answer
        return found


def spread(
    function: Callable[[Task], Answer],
    tasks: Sequence[Task],
    workers: int,
    tell: Callable[[int, Answer], None] = lambda *_: None,
) -> list[Answer]:
    """Answers of a function to tasks, in their order, found by processes that end with this one.

    function: of a module, so that a process can import it. tell: hears of each answer with the
    number of its task, from other threads, one call at a time. Raises what a task raised first.
    """
    crew = _Crew(function, tasks, tell)
    threads = [
        threading.Thread(target=crew.work, daemon=True) for _ in range(min(workers, len(tasks)))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if crew.failures:
        raise crew.failures[0]
    return [crew.answers[number] for number in range(len(tasks))]
