"""A process that runs cases of hazards: pickled cases on stdin, pickled results on stdout.

``python -m opensuction.evidence.safety_case.case_worker``. It ends at once with its input, also in
the middle of a case, so that it never outlives the process that started it.
"""

import os
import pickle
import sys
import threading
from queue import SimpleQueue
from typing import Any, BinaryIO


def _listen(given: BinaryIO, cases: "SimpleQueue[Any]") -> None:
    """Hand on every case; the end of the input is the end of the process."""
    while True:
        try:
            cases.put(pickle.load(given))
        except (EOFError, pickle.UnpicklingError):  # the latter: cut off in the middle
            os._exit(0)


def serve(given: BinaryIO, taken: BinaryIO) -> None:
    """Answer every case; one that raises is answered by its exception."""
    from opensuction.evidence.safety_case import hazard_case

    cases: SimpleQueue[Any] = SimpleQueue()
    threading.Thread(target=_listen, args=(given, cases), daemon=True).start()
    while True:
        case = cases.get()
        try:
            answer: object = hazard_case.run(case)
        except Exception as failure:  # told to whoever asked, who knows what to do
            answer = failure
        pickle.dump(answer, taken)
        taken.flush()


def main() -> None:
    """Serve on the process's own pipes; whatever prints goes to stderr."""
    taken = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    serve(sys.stdin.buffer, taken)


if __name__ == "__main__":
    main()
