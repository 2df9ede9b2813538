"""Arithmetic of the core in a proof: numbers, masks, truth values and records, known or unknown."""

import ast
import math
import operator
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import z3

from tools.proof import logic
from tools.proof.abstract_double import AbstractDoubles
from tools.proof.exact_double import ExactDoubles
from tools.proof.logic import Choice, Truth

Doubles: TypeAlias = AbstractDoubles | ExactDoubles

_KNOWN: dict[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
_MASKED = (ast.BitAnd, ast.BitOr, ast.LShift, ast.RShift)
_FUNCTIONS = (min, max, abs, float, int, bool, range, math.isfinite, math.isnan)


def is_known_function(function: Any) -> bool:
    """True where `call` can be asked for it."""
    return any(function is one for one in _FUNCTIONS)


def is_double(doubles: Doubles, value: Any) -> bool:
    """True where a value is a double, known or not."""
    return isinstance(value, float | doubles.kind)


def lift_double(doubles: Doubles, value: Any) -> Any:
    """The value as an unknown double. Raises NotImplementedError for what is none."""
    if isinstance(value, doubles.kind):
        return value
    if isinstance(value, bool | z3.BoolRef):
        raise NotImplementedError("a truth value is used as a number")
    if isinstance(value, int | float):
        return doubles.make(float(value))
    return doubles.from_integer(logic.as_integer(value))


def _is_plain(value: Any) -> bool:
    return isinstance(value, bool | int | float | np.generic)


def choose(doubles: Doubles, condition: Truth, yes: Any, no: Any) -> Any:
    """One of two values of the same kind; of records field by field."""
    if isinstance(condition, bool):
        return yes if condition else no
    if yes is no or (_is_plain(yes) and type(yes) is type(no) and yes == no):
        return yes
    if isinstance(yes, tuple) and not isinstance(yes, doubles.kind | Choice):
        parts = [choose(doubles, condition, a, b) for a, b in zip(yes, no, strict=True)]
        return type(yes)(*parts) if hasattr(yes, "_fields") else tuple(parts)
    if logic.is_truth(yes) and logic.is_truth(no):
        return logic.choose_truth(condition, yes, no)
    if is_double(doubles, yes) or is_double(doubles, no):
        return doubles.choose(condition, lift_double(doubles, yes), lift_double(doubles, no))
    if logic.is_whole(yes) and logic.is_whole(no):
        return Choice(condition, yes, no)
    raise NotImplementedError(f"neither {yes} nor {no} can be chosen")


def element(doubles: Doubles, values: Any, index: Any) -> Any:
    """One of a tuple or a known table."""
    if isinstance(index, tuple) and not isinstance(index, Choice):
        for place in index:  # of a table with several dimensions
            values = element(doubles, values, place)
        return values
    if isinstance(index, int):
        found = values[index]
        return found.item() if isinstance(found, np.generic) else found
    if isinstance(values, np.ndarray):
        values = values.tolist()
    result = values[0]
    for place in range(1, len(values)):
        result = choose(doubles, logic.is_equal(index, place), values[place], result)
    return result


def operate(doubles: Doubles, kind: ast.operator, one: Any, other: Any) -> Any:
    """A sum, difference, product, quotient, or an operation on bits."""
    if _is_plain(one) and _is_plain(other):
        return _KNOWN[type(kind)](one, other)
    if isinstance(kind, _MASKED):
        return _operate_mask(kind, one, other)
    if is_double(doubles, one) or is_double(doubles, other) or isinstance(kind, ast.Div):
        return _operate_double(
            doubles, kind, lift_double(doubles, one), lift_double(doubles, other)
        )
    if isinstance(kind, ast.Add | ast.Sub | ast.Mult):
        return _KNOWN[type(kind)](logic.as_integer(one), logic.as_integer(other))
    raise NotImplementedError(f"{type(kind).__name__} of unknowns")


def _operate_mask(kind: ast.operator, one: Any, other: Any) -> Any:
    if logic.is_truth(one) and logic.is_truth(other):
        raise NotImplementedError("bits of truth values")
    masks = logic.as_mask(one), logic.as_mask(other)
    if isinstance(kind, ast.RShift):
        return z3.LShR(*masks)
    return _KNOWN[type(kind)](*masks)


def _operate_double(doubles: Doubles, kind: ast.operator, one: Any, other: Any) -> Any:
    if isinstance(kind, ast.Add):
        return doubles.add(one, other)
    if isinstance(kind, ast.Sub):
        return doubles.add(one, doubles.negative(other))
    if isinstance(kind, ast.Mult):
        return doubles.multiply(one, other)
    if isinstance(kind, ast.Div):
        return doubles.divide(one, other)
    raise NotImplementedError(f"{type(kind).__name__} of doubles")


def invert(doubles: Doubles, kind: ast.unaryop, value: Any) -> Any:
    """The negative, the opposite, or the other bits."""
    if isinstance(kind, ast.Not) and logic.is_truth(value):
        return logic.negate(value)
    if isinstance(kind, ast.USub):
        if _is_plain(value):
            return -value
        if is_double(doubles, value):
            return doubles.negative(value)
        return -logic.as_integer(value)
    if isinstance(kind, ast.Invert) and logic.is_whole(value):
        return ~value if isinstance(value, int) else ~logic.as_mask(value)
    raise NotImplementedError(f"{type(kind).__name__} of {value}")


def compare(doubles: Doubles, kind: ast.cmpop, one: Any, other: Any) -> Truth:
    """A comparison of two values."""
    if isinstance(kind, ast.In | ast.NotIn):
        among = logic.disjoin(*(compare(doubles, ast.Eq(), one, each) for each in other))
        return among if isinstance(kind, ast.In) else logic.negate(among)
    if _is_plain(one) and _is_plain(other):
        return bool(_KNOWN[type(kind)](one, other))
    if logic.is_truth(one) and logic.is_truth(other):
        same = logic.lift_truth(one) == logic.lift_truth(other)
        return {ast.Eq: same, ast.NotEq: z3.Not(same)}[type(kind)]
    if is_double(doubles, one) or is_double(doubles, other):
        return _compare_doubles(
            doubles, kind, lift_double(doubles, one), lift_double(doubles, other)
        )
    if isinstance(kind, ast.Eq):
        return logic.is_equal(one, other)
    if isinstance(kind, ast.NotEq):
        return logic.negate(logic.is_equal(one, other))
    return _KNOWN[type(kind)](logic.as_integer(one), logic.as_integer(other))


def _compare_doubles(doubles: Doubles, kind: ast.cmpop, one: Any, other: Any) -> Truth:
    if isinstance(kind, ast.Lt):
        return doubles.less(one, other)
    if isinstance(kind, ast.Gt):
        return doubles.less(other, one)
    if isinstance(kind, ast.LtE):
        return logic.disjoin(doubles.less(one, other), doubles.equal(one, other))
    if isinstance(kind, ast.GtE):
        return logic.disjoin(doubles.less(other, one), doubles.equal(one, other))
    if isinstance(kind, ast.Eq):
        return doubles.equal(one, other)
    if isinstance(kind, ast.NotEq):
        return logic.negate(doubles.equal(one, other))
    raise NotImplementedError(f"{type(kind).__name__} of doubles")


def call(doubles: Doubles, function: Any, arguments: list[Any]) -> Any:
    """One of Python's own functions."""
    if all(map(_is_plain, arguments)):
        return function(*arguments)
    if function in (min, max):
        return _extreme(doubles, function is min, arguments)
    (value,) = arguments
    if function is bool and logic.is_truth(value):
        return value
    if function is int and logic.is_whole(value):
        return value
    if not is_double(doubles, value):
        raise NotImplementedError(f"{function.__name__} of {value}")
    if function is abs:
        return doubles.absolute(value)
    if function is math.isfinite:
        return doubles.is_finite(value)
    if function is math.isnan:
        return doubles.is_nan(value)
    if function is float:
        return value
    raise NotImplementedError(f"{function.__name__} of an unknown")


def _extreme(doubles: Doubles, least: bool, values: list[Any]) -> Any:
    """As Python has it: the first, unless a later one is strictly less (greater) than it."""
    result = values[0]
    for value in values[1:]:
        one, other = (value, result) if least else (result, value)
        chosen = choose(doubles, compare(doubles, ast.Lt(), one, other), value, result)
        if isinstance(chosen, doubles.kind):
            pair = lift_double(doubles, result), lift_double(doubles, value)
            chosen = doubles.clamp(chosen, least, *pair)
        result = chosen
    return result
