"""Doubles as reals with flags: not a number, plus and minus infinity. Sound, and fast to use.

A sum, product or quotient of finite doubles is some real within the rounding error of the exact
one (the standard model of floating point: relative `EPSILON`, and `TINY` where a product or a
quotient underflows), on the side of each operand on which the exact one is, for rounding is
monotone; beyond the largest double it may be infinite. A fused product and sum, as compilers make
it, is one of the reals allowed. A product of two unknowns is known by its sign and its hull only.
Whatever holds for all of these holds for the doubles of the machine. Not the other way round: a
counterexample here may be none there, and has to be replayed.
Source: Higham, Accuracy and Stability of Numerical Algorithms, 2nd edition, section 2.2.
"""

import itertools
import math
import sys
from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import Any, NamedTuple

import z3

from tools.proof import rounding
from tools.proof.logic import Truth, choose_truth, conjoin, disjoin, lift_truth, negate
from tools.proof.rounding import EPSILON, TINY, exactly

LARGEST = sys.float_info.max
"""The largest double."""
SLACK = 1.0 + 1e-12
"""By which a hull is wider than what Python computes of it."""


class Double(NamedTuple):
    """An unknown double."""

    real: z3.ArithRef
    """Its value where it is finite; else nothing."""
    nan: Truth
    up: Truth
    """Plus infinity."""
    down: Truth
    """Minus infinity."""
    low: float
    high: float
    """Hull of its value where it is finite."""


class Fact(NamedTuple):
    """Definition of an unknown that an operation has made: there is always one."""

    unknown: z3.ExprRef
    holds: z3.BoolRef


def is_finite(value: Double) -> Truth:
    """True where it is neither infinite nor not a number."""
    return negate(disjoin(value.nan, value.up, value.down))


class AbstractDoubles:
    """The operations, and the facts about what they have made."""

    kind = Double

    def __init__(self, divisors: Iterable[float] = ()) -> None:
        """divisors: where in size a quotient by an unknown is compared with one by a number."""
        self._divisors = tuple(divisors)
        self.facts: dict[str, Fact] = {}
        self._numbers = itertools.count()
        self._known: dict[Any, tuple[Any, Double]] = {}

    # What there is to begin with

    def make(self, value: float) -> Double:
        """A known double."""
        number = math.isfinite(value)
        finite = value if number else 0.0
        nan, up, down = math.isnan(value), value == math.inf, value == -math.inf
        return Double(exactly(finite), nan, up, down, finite, finite)

    def free(self, name: str) -> Double:
        """Any double whatever."""
        nan, up, down = (z3.Bool(f"{name}:{flag}") for flag in ("nan", "up", "down"))
        up_only = z3.And(up, z3.Not(nan))
        down_only = z3.And(down, z3.Not(nan), z3.Not(up))
        return Double(z3.Real(name), nan, up_only, down_only, -math.inf, math.inf)

    def free_finite(self, name: str, low: float = -LARGEST, high: float = LARGEST) -> Double:
        """Any finite double between two numbers, both included."""
        real = z3.Real(name)
        self.facts[name] = Fact(real, z3.And(real >= exactly(low), real <= exactly(high)))
        return Double(real, False, False, False, low, high)

    def from_integer(self, value: z3.ArithRef) -> Double:
        """A count as a double: exact below 2**53, which no count of ticks reaches."""
        return Double(z3.ToReal(value), False, False, False, -(2.0**63), 2.0**63)

    # Comparisons

    def less(self, one: Double, other: Double) -> Truth:
        """True where one is less than the other; false where either is not a number."""
        numbers = negate(disjoin(one.nan, other.nan))
        finite = conjoin(negate(disjoin(one.up, one.down)), negate(disjoin(other.up, other.down)))
        below = disjoin(
            conjoin(one.down, negate(other.down)),
            conjoin(other.up, negate(one.up)),
            conjoin(finite, one.real < other.real),
        )
        return conjoin(numbers, below)

    def equal(self, one: Double, other: Double) -> Truth:
        """True where both are the same number."""
        finite = conjoin(is_finite(one), is_finite(other))
        return disjoin(
            conjoin(one.up, other.up),
            conjoin(one.down, other.down),
            conjoin(finite, one.real == other.real),
        )

    def is_finite(self, value: Double) -> Truth:
        """As `math.isfinite`."""
        return is_finite(value)

    def is_nan(self, value: Double) -> Truth:
        """As `math.isnan`."""
        return value.nan

    def choose(self, condition: z3.BoolRef, yes: Double, no: Double) -> Double:
        """One of two."""
        return Double(
            z3.If(condition, yes.real, no.real),
            choose_truth(condition, yes.nan, no.nan),
            choose_truth(condition, yes.up, no.up),
            choose_truth(condition, yes.down, no.down),
            min(yes.low, no.low),
            max(yes.high, no.high),
        )

    def clamp(self, value: Double, least: bool, one: Double, other: Double) -> Double:
        """The least, or the greatest, of two, with its hull: no further than one that is finite.

        value: the one of both that it is.
        """
        known = [each for each in (one, other) if is_finite(each) is True]
        if not known:
            return value
        if least:
            return value._replace(high=min(each.high for each in known))
        return value._replace(low=max(each.low for each in known))

    # Arithmetic

    def negative(self, value: Double) -> Double:
        """Exact."""
        return Double(-value.real, value.nan, value.down, value.up, -value.high, -value.low)

    def absolute(self, value: Double) -> Double:
        """Exact."""
        high = max(abs(value.low), abs(value.high))
        real = z3.If(value.real >= 0, value.real, -value.real)
        return Double(real, value.nan, disjoin(value.up, value.down), False, 0.0, high)

    def add(self, one: Double, other: Double) -> Double:
        """Sum."""
        return self._recall(self._add, one, other)

    def multiply(self, one: Double, other: Double) -> Double:
        """Product; of two unknowns only its sign and its hull are known."""
        return self._recall(self._multiply, one, other)

    def divide(self, one: Double, other: Double) -> Double:
        """Quotient; the divisor is not 0. By an unknown only its sign is known."""
        return self._recall(self._divide, one, other)

    def _recall(
        self, operation: Callable[[Double, Double], Double], one: Double, other: Double
    ) -> Double:
        """The result of an operation: of the same operands the same each time."""
        key = (operation.__name__, *(_identity(part) for part in (*one, *other)))
        if key not in self._known:
            # The operands are kept, for z3 gives the numbers of those it forgets to others.
            self._known[key] = (one, other), operation(one, other)
        return self._known[key][1]

    def _add(self, one: Double, other: Double) -> Double:
        exact, x, y = one.real + other.real, one.real, other.real
        nan = disjoin(one.nan, other.nan, conjoin(one.up, other.down), conjoin(one.down, other.up))
        sides = [
            lambda r: z3.Implies(y >= 0, r >= x),
            lambda r: z3.Implies(y <= 0, r <= x),
            lambda r: z3.Implies(x >= 0, r >= y),
            lambda r: z3.Implies(x <= 0, r <= y),
        ]
        infinite = disjoin(one.up, other.up), disjoin(one.down, other.down)
        hull = one.low + other.low, one.high + other.high
        return self._round(exact, nan, infinite, hull, sides, Fraction(0))

    def _multiply(self, one: Double, other: Double) -> Double:
        known = [z3.is_rational_value(factor.real) for factor in (one, other)]
        x, y = one.real, other.real
        unbounded = [disjoin(one.up, one.down), disjoin(other.up, other.down)]
        nan = disjoin(
            one.nan,
            other.nan,
            conjoin(unbounded[0], negate(unbounded[1]), y == 0),
            conjoin(unbounded[1], negate(unbounded[0]), x == 0),
        )
        above = [disjoin(v.up, conjoin(is_finite(v), v.real > 0)) for v in (one, other)]
        below = [disjoin(v.down, conjoin(is_finite(v), v.real < 0)) for v in (one, other)]
        grown = disjoin(*unbounded)
        infinite = (
            conjoin(grown, disjoin(conjoin(*above), conjoin(*below))),
            conjoin(grown, disjoin(conjoin(above[0], below[1]), conjoin(below[0], above[1]))),
        )
        corners = [
            rounding.times(a, b) for a in (one.low, one.high) for b in (other.low, other.high)
        ]
        hull = min(corners), max(corners)
        sides = [
            lambda r: z3.Implies(z3.Or(z3.And(x >= 0, y >= 0), z3.And(x <= 0, y <= 0)), r >= 0),
            lambda r: z3.Implies(z3.Or(z3.And(x >= 0, y <= 0), z3.And(x <= 0, y >= 0)), r <= 0),
        ]
        exact = x * y if any(known) else None
        for bounded, factor in ((one, y), (other, x)):
            size = max(abs(bounded.low), abs(bounded.high))
            if exact is None and math.isfinite(size):
                sides.append(rounding.limit(factor, size))
        for count, factor in ((y, x), (x, y)):
            if z3.is_app_of(count, z3.Z3_OP_TO_REAL):
                sides.append(rounding.repeat(count, factor))
        return self._round(exact, nan, infinite, hull, sides, TINY)

    def _divide(self, one: Double, other: Double) -> Double:
        x, y = one.real, other.real
        nan = disjoin(
            one.nan,
            other.nan,
            conjoin(disjoin(one.up, one.down), disjoin(other.up, other.down)),
        )
        positive = disjoin(other.up, conjoin(is_finite(other), y > 0))
        negative = disjoin(other.down, conjoin(is_finite(other), y < 0))
        infinite = (
            disjoin(conjoin(one.up, positive), conjoin(one.down, negative)),
            disjoin(conjoin(one.up, negative), conjoin(one.down, positive)),
        )
        exact, hull = None, (-math.inf, math.inf)
        if z3.is_rational_value(y):
            exact = x / y
            ends = sorted((one.low / other.low, one.high / other.low))
            hull = ends[0], ends[1]
        sides = [
            lambda r: z3.Implies(z3.Or(z3.And(x >= 0, y >= 0), z3.And(x <= 0, y <= 0)), r >= 0),
            lambda r: z3.Implies(z3.Or(z3.And(x >= 0, y <= 0), z3.And(x <= 0, y >= 0)), r <= 0),
        ]
        if exact is None:
            sides += [rounding.share(x, y, divisor) for divisor in self._divisors]
        shrunk = disjoin(other.up, other.down)
        quotient = self._round(exact, nan, infinite, hull, sides, TINY)
        if shrunk is False:
            return quotient
        return self.choose(lift_truth(conjoin(shrunk, is_finite(one))), self.make(0.0), quotient)

    def _round(
        self,
        exact: z3.ArithRef | None,
        nan: Truth,
        infinite: tuple[Truth, Truth],
        hull: tuple[float, float],
        sides: list[Any],
        underflow: Fraction,
    ) -> Double:
        """A rounded result. exact: what is rounded, where it is known."""
        number = next(self._numbers)
        rounded = z3.Real(f"rounded:{number}")
        low, high = (
            hull[0] - abs(hull[0]) * (SLACK - 1.0) - 1e-29,
            (hull[1] + abs(hull[1]) * (SLACK - 1.0) + 1e-29),
        )
        holds = [side(rounded) for side in sides]
        if exact is not None:
            error = exactly(EPSILON) * rounding.size(exact) + exactly(underflow)
            holds += [rounded >= exact - error, rounded <= exact + error]
        for bound, within in ((low, rounded.__ge__), (high, rounded.__le__)):
            if math.isfinite(bound):
                holds.append(within(exactly(bound)))
        self.facts[str(rounded)] = Fact(rounded, z3.And(holds))
        up, down = infinite
        if not (math.isfinite(low) and math.isfinite(high)):
            size = rounded if exact is None else exact
            beyond = z3.Bool(f"overflows:{number}")
            normal = negate(disjoin(nan, up, down))
            most = exactly(LARGEST)
            up = disjoin(up, conjoin(normal, beyond, size > most))
            down = disjoin(down, conjoin(normal, beyond, size < -most))
        # Where it is not a number it is not infinite either.
        return Double(rounded, nan, conjoin(up, negate(nan)), conjoin(down, negate(nan)), low, high)


def _identity(part: Any) -> Any:
    """Identity of one part of an unknown, to tell it from another."""
    return part.get_id() if isinstance(part, z3.ExprRef) else part
