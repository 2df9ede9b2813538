"""Truth values and whole numbers: Python's where they are known, z3's where they are not.

What is known stays Python's own, so that most of what is translated folds away at once.
"""

from typing import Any, NamedTuple, TypeAlias

import z3

MASK_BITS = 64
"""Width of a bit mask, that of the compiled core's integers."""

Truth: TypeAlias = Any
"""A bool, or a z3 truth value."""


class Choice(NamedTuple):
    """Two whole numbers, of which a condition chooses; integer or mask, as its user needs."""

    condition: z3.BoolRef
    yes: Any
    no: Any


class Unread:
    """Numbers of unknown count: whoever reads them cannot be translated."""


UNREAD = Unread()


def negate(one: Truth) -> Truth:
    """The opposite."""
    return not one if isinstance(one, bool) else z3.Not(one)


def conjoin(*all_of: Truth) -> Truth:
    """True where all hold."""
    if any(one is False for one in all_of):
        return False
    open_ones = [one for one in all_of if one is not True]
    if not open_ones:
        return True
    return open_ones[0] if len(open_ones) == 1 else z3.And(open_ones)


def disjoin(*any_of: Truth) -> Truth:
    """True where any holds."""
    if any(one is True for one in any_of):
        return True
    open_ones = [one for one in any_of if one is not False]
    if not open_ones:
        return False
    return open_ones[0] if len(open_ones) == 1 else z3.Or(open_ones)


def choose_truth(condition: Truth, yes: Truth, no: Truth) -> Truth:
    """One of two truth values."""
    if isinstance(condition, bool):
        return yes if condition else no
    return disjoin(conjoin(condition, yes), conjoin(negate(condition), no))


def lift_truth(one: Truth) -> z3.BoolRef:
    """The same for z3."""
    return z3.BoolVal(one) if isinstance(one, bool) else one


def is_truth(value: Any) -> bool:
    """True where a value is a truth value, known or not."""
    return isinstance(value, bool | z3.BoolRef)


def is_whole(value: Any) -> bool:
    """True where a value is a whole number or a mask, known or not."""
    if isinstance(value, bool):
        return False
    integer = isinstance(value, z3.ArithRef) and value.is_int()
    return integer or isinstance(value, int | Choice | z3.BitVecRef)


def has_mask(value: Any) -> bool:
    """True where a whole number is, or may be, an unknown bit mask."""
    if isinstance(value, Choice):
        return has_mask(value.yes) or has_mask(value.no)
    return isinstance(value, z3.BitVecRef)


def _lift(value: Any, sort: z3.SortRef) -> Any:
    if isinstance(value, Choice):
        return z3.If(value.condition, _lift(value.yes, sort), _lift(value.no, sort))
    if isinstance(value, int):
        is_mask = sort.kind() == z3.Z3_BV_SORT
        return z3.BitVecVal(value, MASK_BITS) if is_mask else z3.IntVal(int(value))
    if value.sort() != sort:
        raise NotImplementedError(f"{value} is used both as a mask and as a count")
    return value


def as_integer(value: Any) -> z3.ArithRef:
    """The whole number as a z3 integer. Raises NotImplementedError for an unknown mask."""
    return _lift(value, z3.IntSort())


def as_mask(value: Any) -> z3.BitVecRef:
    """The whole number as a bit vector. Raises NotImplementedError for an unknown count."""
    return _lift(value, z3.BitVecSort(MASK_BITS))


def is_equal(one: Any, other: Any) -> Truth:
    """True where two whole numbers are the same."""
    if isinstance(one, int) and isinstance(other, int):
        return one == other
    for chosen, compared in ((one, other), (other, one)):
        if isinstance(chosen, Choice):
            yes, no = is_equal(chosen.yes, compared), is_equal(chosen.no, compared)
            return choose_truth(chosen.condition, yes, no)
    if has_mask(one) or has_mask(other):
        return as_mask(one) == as_mask(other)
    return as_integer(one) == as_integer(other)
