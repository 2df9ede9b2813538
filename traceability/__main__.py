"""``python -m traceability``: is anything claimed that nothing shows? Exit 1 if so.

Every gap is one line on stderr; where there is none, one line says what was looked at.
"""

import sys

from traceability import matrix


def main() -> int:
    """Hold hazards, requirements and tests against each other."""
    found = matrix.read()
    gaps = matrix.gaps(found)
    for gap in gaps:
        print(gap, file=sys.stderr)  # noqa: T201
    if gaps:
        return 1
    tests = {mark.test for mark in found.marks}
    print(  # noqa: T201
        f"Traceability: {len(found.hazards)} hazards with faults, {len(found.requirements)} "
        f"requirements verified by {len(tests)} tests"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
