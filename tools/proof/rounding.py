"""Bounds of the rounding error of operations on doubles, as facts for z3.

Source: Higham, Accuracy and Stability of Numerical Algorithms, 2nd edition, section 2.2.
"""

from collections.abc import Callable
from fractions import Fraction

import z3

Side = Callable[[z3.ArithRef], z3.BoolRef]
"""What holds of a result."""

EPSILON = Fraction(1, 10**15)
"""More than the unit roundoff of a double, 1.11e-16."""
TINY = Fraction(1, 10**30)
"""More than the smallest double, 5e-324."""
MOST_REPEATED = 8
"""Counts up to that are told apart in products."""


def exactly(number: float | Fraction) -> z3.RatNumRef:
    """A number as z3's rational."""
    return z3.RealVal(str(Fraction(number)))


def limit(factor: z3.ArithRef, largest: float) -> Side:
    """A product is no larger than one factor times the largest size of the other."""
    grown = exactly(Fraction(largest) * (1 + EPSILON))

    def holds(product: z3.ArithRef) -> z3.BoolRef:
        return size(product) <= grown * size(factor) + exactly(TINY)

    return holds


def size(real: z3.ArithRef) -> z3.ArithRef:
    """Absolute value."""
    return z3.If(real >= 0, real, -real)


def repeat(count: z3.ArithRef, factor: z3.ArithRef) -> Side:
    """A product with a count: as often as that, where it is small."""

    def holds(product: z3.ArithRef) -> z3.BoolRef:
        error = exactly(MOST_REPEATED * EPSILON) * size(factor) + exactly(TINY)
        cases = [
            z3.Implies(count == k, size(product - k * factor) <= error)
            for k in range(MOST_REPEATED + 1)
        ]
        return z3.And(cases)

    return holds


def share(dividend: z3.ArithRef, divisor: z3.ArithRef, least: float) -> Side:
    """A quotient by no less than a number is no larger than one by that number."""
    grown = exactly((1 + EPSILON) / Fraction(least))

    def holds(quotient: z3.ArithRef) -> z3.BoolRef:
        most = grown * size(dividend) + exactly(TINY)
        return z3.Implies(divisor >= exactly(least), size(quotient) <= most)

    return holds


def times(one: float, other: float) -> float:
    """Corner of a hull: nothing times without bound is nothing, for the bound is not reached."""
    return 0.0 if 0.0 in (one, other) else one * other
