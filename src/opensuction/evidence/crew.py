"""Work spread over processes of their own; each answers one task at a time."""

import pickle
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from queue import Empty, SimpleQueue
from typing import TypeVar

WORKER = (sys.executable, "-m", "opensuction.evidence.worker")

Task = TypeVar("Task")
Answer = TypeVar("Answer")


def _ask(
    process: "subprocess.Popen[bytes]", function: Callable[[Task], Answer], task: Task
) -> Answer:
    assert process.stdin is not None
    assert process.stdout is not None
    pickle.dump((function, task), process.stdin)
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
    waiting: SimpleQueue[tuple[int, Task]] = SimpleQueue()
    for numbered in enumerate(tasks):
        waiting.put(numbered)
    lock = threading.Lock()
    answers: dict[int, Answer] = {}
    failures: list[BaseException] = []

    def work() -> None:
        """Have one process do tasks until none is left or something fails."""
        # A session of its own: Ctrl-C on a terminal is for the command alone.
        with subprocess.Popen(
            WORKER, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
        ) as process:
            try:
                while not failures:
                    number, task = waiting.get_nowait()
                    answer = _ask(process, function, task)
                    with lock:
                        answers[number] = answer
                        tell(number, answer)
            except Empty:
                pass
            except BaseException as failure:
                failures.append(failure)

    threads = [threading.Thread(target=work, daemon=True) for _ in range(min(workers, len(tasks)))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if failures:
        raise failures[0]
    return [answers[number] for number in range(len(tasks))]
