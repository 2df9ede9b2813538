from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from opensuction.kernel.record import make_zero


class Inner(NamedTuple):
    flag: bool
    number: float


class Outer(NamedTuple):
    ticks: int
    inner: Inner
    other: Inner


class WithArray(NamedTuple):
    values: NDArray[np.float64]
    number: float


def test_all_fields_but_those_given_are_nothing_of_their_own_type() -> None:
    made = make_zero(Outer, other=Inner(True, 2.0))
    assert made == Outer(0, Inner(False, 0.0), Inner(True, 2.0))
    assert [type(value) for value in (made.ticks, *made.inner)] == [int, bool, float]


def test_what_has_no_zero_must_be_given() -> None:
    with pytest.raises(TypeError, match=r"WithArray.values is .*: there is no 0 of it"):
        make_zero(WithArray)
    assert make_zero(WithArray, values=np.ones(2)).number == 0.0


def test_a_field_that_does_not_exist_is_refused() -> None:
    with pytest.raises(TypeError, match="nothing"):
        make_zero(Inner, nothing=1.0)
