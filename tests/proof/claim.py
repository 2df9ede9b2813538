"""Words for claims: comparisons of unknowns, and records of unknowns within bounds."""

import ast
from collections.abc import Callable, Mapping
from typing import Any

import pytest
import z3

from tools.proof import arithmetic, theorem
from tools.proof.arithmetic import Doubles
from tools.proof.logic import Truth, as_integer, as_mask, conjoin, lift_truth
from tools.proof.unknown import free

Number = Callable[[str], Any]


def _compare(doubles: Doubles, kind: ast.cmpop, one: Any, other: Any) -> z3.BoolRef:
    return lift_truth(arithmetic.compare(doubles, kind, one, other))


def at_most(doubles: Doubles, one: Any, other: Any) -> z3.BoolRef:
    """Both are numbers, and one is not above the other."""
    return _compare(doubles, ast.LtE(), one, other)


def below(doubles: Doubles, one: Any, other: Any) -> z3.BoolRef:
    """Both are numbers, and one is less than the other."""
    return _compare(doubles, ast.Lt(), one, other)


def same(doubles: Doubles, one: Any, other: Any) -> z3.BoolRef:
    """Both are numbers, and equal."""
    return _compare(doubles, ast.Eq(), one, other)


def within(doubles: Doubles, value: Any, size: float) -> z3.BoolRef:
    """A number whose size is not above another."""
    return z3.And(at_most(doubles, -size, value), at_most(doubles, value, size))


def between(doubles: Doubles, low: Any, value: Any, high: Any) -> z3.BoolRef:
    """A number from a low one to a high one, both included."""
    return z3.And(at_most(doubles, low, value), at_most(doubles, value, high))


def is_finite(doubles: Doubles, value: Any) -> z3.BoolRef:
    """Neither NaN nor an infinity."""
    return lift_truth(doubles.is_finite(arithmetic.lift_double(doubles, value)))


def plus(doubles: Doubles, one: Any, number: float) -> Any:
    """The sum of a double and a known number, as the abstraction rounds it."""
    return doubles.add(one, doubles.make(number))


def minus(doubles: Doubles, value: Any) -> Any:
    """The number with the other sign: exact."""
    return doubles.negative(value)


def implies(condition: Truth, claim: Truth) -> z3.BoolRef:
    """The claim, wherever the condition holds."""
    return z3.Implies(lift_truth(condition), lift_truth(claim))


def has(mask: Any, number: int) -> z3.BoolRef:
    """Whether a mask has a condition's bit."""
    return as_mask(mask) & (1 << number) != 0


def is_(whole: Any, number: int) -> z3.BoolRef:
    """Whether a whole number is this one."""
    return as_integer(whole) == int(number)


def bounded(
    doubles: Doubles, sizes: Mapping[str, float | tuple[float, float]], begins: bool = False
) -> Number:
    """Makes doubles: finite and within bounds where the end of their name has them, else any.

    begins: the beginning of a name does, too.
    """

    def number(name: str) -> Any:
        for ending, size in sizes.items():
            at_end = name == ending or name.endswith("." + ending)
            if at_end or (begins and name.startswith(ending + ".")):
                low, high = size if isinstance(size, tuple) else (-size, size)
                return doubles.free_finite(name, low, high)  # type: ignore[union-attr]
        return doubles.free(name)

    return number


def finite(doubles: Doubles, kind: Any, name: str) -> Any:
    """A record of finite doubles."""
    return free(doubles, kind, name, doubles.free_finite)  # type: ignore[union-attr]


def assert_holds(doubles: Doubles, assumed: Truth, claim: Truth) -> None:
    """Prove it, and that what is assumed can be."""
    report(theorem.prove(doubles, assumed, claim))
    if not theorem.is_possible(doubles, assumed):
        pytest.fail("nothing fulfils what is assumed", pytrace=False)


def report(answer: theorem.Answer) -> None:
    """Fail with a counterexample, if there is one."""
    if not answer.holds:
        found = (f"  {name} = {value}" for name, value in answer.counterexample.items())
        pytest.fail("\n".join(["it does not hold for", *found]), pytrace=False)


def all_of(*claims: Truth) -> z3.BoolRef:
    """All claims together."""
    return lift_truth(conjoin(*claims))
