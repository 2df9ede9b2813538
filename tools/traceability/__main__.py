"""``python -m tools.traceability``: refuse claims without a test, and modules of poor form.

Every problem is one line on stderr, and the exit status is 1; where there is none, one line says
what was looked at.
"""

import sys

from tools.traceability import matrix, module_form


def main() -> int:
    """Hold hazards, requirements and tests against each other, and look at the form of modules."""
    found = matrix.read()
    sources = module_form.read()
    problems = matrix.gaps(found) + module_form.problems(sources)
    for problem in problems:
        print(problem, file=sys.stderr)  # noqa: T201
    if problems:
        return 1
    tests = {mark.test for mark in found.marks}
    print(  # noqa: T201
        f"Traceability: {len(found.hazards)} hazards with faults, {len(found.requirements)} "
        f"requirements verified by {len(tests)} tests, {len(sources)} modules in form"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
