from typing import Annotated, NamedTuple

import numpy as np
import pytest
from annotated_types import Len
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.codegen import plain_row, row


class Inner(NamedTuple):
    depth_mm: float
    closed: bool


class Outer(NamedTuple):
    tick: int
    inner: Inner
    plays_mm: Annotated[tuple[float, ...], Len(2, 2)]


OUTER = Outer(3, Inner(2.5, True), (0.5, -1.5))


@given(
    tick=st.integers(-(2**53), 2**53),
    floats=st.tuples(*[st.floats(allow_nan=False)] * 3),
    closed=st.booleans(),
)
def test_a_record_comes_back_from_its_row_as_python_s_own_numbers(
    tick: int, floats: tuple[float, float, float], closed: bool
) -> None:
    record = Outer(tick, Inner(floats[0], closed), floats[1:])
    back = plain_row.unpack(Outer, plain_row.pack(Outer, record))
    assert repr(back) == repr(record)


def test_a_row_is_the_one_that_the_compiled_writer_makes() -> None:
    written = np.zeros(5)
    row.writer(Outer)(written, OUTER)
    assert plain_row.pack(Outer, OUTER).tobytes() == written.tobytes()


def test_numbers_of_another_kind_that_mean_the_same_are_taken() -> None:
    record = Outer(np.int64(3), Inner(2, np.bool_(True)), (np.float32(0.5), 1))  # type: ignore[arg-type]
    back = plain_row.unpack(Outer, plain_row.pack(Outer, record))
    assert repr(back) == repr(Outer(3, Inner(2.0, True), (0.5, 1.0)))


@pytest.mark.parametrize(
    ("record", "words"),
    [
        (OUTER._replace(tick=2.5), "tick is 2.5, no int that a row holds"),  # type: ignore[arg-type]
        (OUTER._replace(tick=2**53 + 1), "tick is 9007199254740993, no int that a row holds"),
        (OUTER._replace(tick=float("nan")), "tick is nan, no int"),  # type: ignore[arg-type]
        (OUTER._replace(inner=Inner(2.5, 3)), "inner.closed is 3, no bool that a row holds"),  # type: ignore[arg-type]
        (OUTER._replace(inner=Inner("3", True)), "inner.depth_mm is '3', no float"),  # type: ignore[arg-type]
        (OUTER._replace(inner=Inner(None, True)), "inner.depth_mm is None, no float"),  # type: ignore[arg-type]
        (OUTER._replace(plays_mm=(1.0,)), "Outer is 5 numbers, not 4"),
    ],
)
def test_what_a_row_would_not_give_back_is_refused_by_name(record: Outer, words: str) -> None:
    with pytest.raises((TypeError, ValueError), match=words):
        plain_row.pack(Outer, record)


def test_a_row_that_is_too_short_is_refused() -> None:
    with pytest.raises(IndexError):
        plain_row.unpack(Outer, np.zeros(4))


def test_no_whole_number_is_read_from_nan() -> None:
    with pytest.raises(ValueError, match="NaN"):
        plain_row.unpack(Outer, np.full(5, np.nan))
