"""Doubles bit for bit, as IEEE 754 has them and z3 knows them: exact, and slow to prove with."""

from typing import Any

import z3

SORT = z3.Float64()
NEAREST = z3.RNE()


class ExactDoubles:
    """The operations; each is z3's own."""

    kind = z3.FPRef

    def __init__(self) -> None:
        self.facts: dict[str, Any] = {}

    def make(self, value: float) -> z3.FPRef:
        """A known double."""
        return z3.FPVal(value, SORT)

    def free(self, name: str) -> z3.FPRef:
        """Any double whatever."""
        return z3.FP(name, SORT)

    def from_integer(self, value: z3.ArithRef) -> z3.FPRef:
        """A count as a double."""
        return z3.fpRealToFP(NEAREST, z3.ToReal(value), SORT)

    def less(self, one: z3.FPRef, other: z3.FPRef) -> z3.BoolRef:
        """True where one is less than the other."""
        return z3.fpLT(one, other)

    def equal(self, one: z3.FPRef, other: z3.FPRef) -> z3.BoolRef:
        """True where both are the same number; 0.0 and -0.0 are."""
        return z3.fpEQ(one, other)

    def is_finite(self, value: z3.FPRef) -> z3.BoolRef:
        """As `math.isfinite`."""
        return z3.Not(z3.Or(z3.fpIsNaN(value), z3.fpIsInf(value)))

    def is_nan(self, value: z3.FPRef) -> z3.BoolRef:
        """As `math.isnan`."""
        return z3.fpIsNaN(value)

    def choose(self, condition: z3.BoolRef, yes: z3.FPRef, no: z3.FPRef) -> z3.FPRef:
        """One of two."""
        return z3.If(condition, yes, no)

    def clamp(self, value: z3.FPRef, least: bool, one: z3.FPRef, other: z3.FPRef) -> z3.FPRef:
        """The least, or the greatest, of two: there is nothing to add to it."""
        del least, one, other
        return value

    def negative(self, value: z3.FPRef) -> z3.FPRef:
        """Exact."""
        return z3.fpNeg(value)

    def absolute(self, value: z3.FPRef) -> z3.FPRef:
        """Exact."""
        return z3.fpAbs(value)

    def add(self, one: z3.FPRef, other: z3.FPRef) -> z3.FPRef:
        """Sum."""
        return z3.fpAdd(NEAREST, one, other)

    def multiply(self, one: z3.FPRef, other: z3.FPRef) -> z3.FPRef:
        """Product."""
        return z3.fpMul(NEAREST, one, other)

    def divide(self, one: z3.FPRef, other: z3.FPRef) -> z3.FPRef:
        """Quotient; the divisor is not 0."""
        return z3.fpDiv(NEAREST, one, other)
