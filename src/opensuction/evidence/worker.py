"""A process that works for another: pickled functions and arguments on stdin, answers on stdout.

``python -m opensuction.evidence.worker``. It ends at once with its input, also in the middle of a
task, so that it never outlives the process that started it, however that one ends.
"""

import os
import pickle
import sys
import threading
from queue import SimpleQueue
from typing import Any, BinaryIO


def _listen(given: BinaryIO, tasks: "SimpleQueue[Any]") -> None:
    """Hand on every task; the end of the input is the end of the process."""
    while True:
        try:
            tasks.put(pickle.load(given))
        except (EOFError, pickle.UnpicklingError):  # the latter: cut off in the middle
            os._exit(0)


def serve(given: BinaryIO, taken: BinaryIO) -> None:
    """Answer every task, a pair of function and argument; one that raises by its exception."""
    tasks: SimpleQueue[Any] = SimpleQueue()
    threading.Thread(target=_listen, args=(given, tasks), daemon=True).start()
    while True:
        function, argument = tasks.get()
        try:
            answer: object = function(argument)
        except Exception as failure:  # told to whoever asked, who knows what to do
            answer = failure
        try:
            pickle.dump(answer, taken)
            taken.flush()
        except BrokenPipeError:
            # Whoever asked has gone. To end as usual would wait for the input, which is being read.
            os._exit(0)


def main() -> None:
    """Serve on the process's own pipes; whatever prints goes to stderr."""
    taken = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    serve(sys.stdin.buffer, taken)


if __name__ == "__main__":
    main()
