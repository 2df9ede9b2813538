"""Calls by Python whose types are settled once."""

# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call"

from typing import NamedTuple

import numba
from numba.core import types

from opensuction.kernel.compiler import dispatcher


class Inner(NamedTuple):
    first: float
    second: float


class Outer(NamedTuple):
    inner: Inner
    row: tuple[float, ...]
    number: int
    is_on: bool


def test_whole_numbers_in_fields_of_floats_are_floats() -> None:
    whole = Outer(Inner(1, 2), (0, 0.5), 3, True)
    broken = Outer(Inner(1.0, 2.0), (0.0, 0.5), 3, True)
    assert numba.typeof(whole) != numba.typeof(broken)
    assert dispatcher.declared(Outer, numba.typeof(whole)) == numba.typeof(broken)
    assert dispatcher.declared(tuple[int, float], numba.typeof((1, 2))) == types.Tuple(
        (types.int64, types.float64)
    )


def test_a_typed_call_asks_once_for_each_kind_and_tells_unions_apart() -> None:
    seen = []

    def count(one: Inner | None, row: tuple[float, ...]) -> int:
        seen.append(one is None)
        return len(row)

    settled = dispatcher.TypedCall(count, lambda _, row: len(row))
    assert settled(Inner(1, 2), (0.0,)) == 1
    assert settled(None, (0.0,)) == 1
    assert settled(None, (0.0, 1.0)) == 2
    assert seen == [False, True, True]
    assert len(settled._known) == 3
