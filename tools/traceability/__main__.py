"""``python -m tools.traceability``: refuse claims without a test, and docstrings that ask.

Every problem is one line on stderr, and the exit status is 1; where there is none, one line says
what was looked at.
"""

import sys

from tools.traceability import docstring, matrix


def main() -> int:
    """Hold hazards, requirements and tests against each other, and look through the docstrings."""
    found = matrix.read()
    sources = docstring.read()
    problems = matrix.gaps(found) + docstring.problems(sources)
    for problem in problems:
        print(problem, file=sys.stderr)  # noqa: T201
    if problems:
        return 1
    tests = {mark.test for mark in found.marks}
    print(  # noqa: T201
        f"Traceability: {len(found.hazards)} hazards with faults, {len(found.requirements)} "
        f"requirements verified by {len(tests)} tests, {len(sources)} docstrings of modules"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
