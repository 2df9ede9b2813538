"""A process that runs cases of hazards: pickled cases on stdin, pickled results on stdout.

``python -m opensuction.evidence.case_worker``. It ends with its input, so also with the process
that started it.
"""

import os
import pickle
import sys
from typing import BinaryIO


def serve(given: BinaryIO, taken: BinaryIO) -> None:
    """Answer every case until the input ends; a case that raises is answered by its exception."""
    from opensuction.evidence import hazard_case

    while True:
        try:
            case = pickle.load(given)
        except EOFError:
            return
        try:
            answer: object = hazard_case.run(case)
        except Exception as failure:  # told to whoever asked, who knows what to do
            answer = failure
        try:
            pickle.dump(answer, taken)
            taken.flush()
        except BrokenPipeError:
            return


def main() -> None:
    """Serve on the process's own pipes; whatever prints goes to stderr."""
    taken = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    serve(sys.stdin.buffer, taken)


if __name__ == "__main__":
    main()
