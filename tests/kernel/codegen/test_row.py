from typing import Annotated, NamedTuple

import numpy as np
import pytest
from annotated_types import Len
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.kernel.codegen import row
from tests.conformance.plain import run_plain


class Inner(NamedTuple):
    depth_mm: float
    closed: bool


class Outer(NamedTuple):
    tick: int
    inner: Inner
    samples: NDArray[np.float64]
    again: Inner
    speed_mm_per_s: float


NAMES = (
    "tick",
    "inner.depth_mm",
    "inner.closed",
    "again.depth_mm",
    "again.closed",
    "speed_mm_per_s",
)

write_outer = row.writer(Outer)


def outer(tick: int, first: float, second: float, closed: bool, speed: float) -> Outer:
    return Outer(tick, Inner(first, closed), np.ones(3), Inner(second, not closed), speed)


def test_columns_are_dotted_paths_in_order_without_arrays() -> None:
    assert row.columns(Outer) == NAMES
    assert row.columns(Inner) == ("depth_mm", "closed")


@given(
    tick=st.integers(-(2**53), 2**53),
    floats=st.tuples(*[st.floats(width=64)] * 3),
    closed=st.booleans(),
)
def test_a_row_holds_each_scalar_in_its_column(
    tick: int, floats: tuple[float, float, float], closed: bool
) -> None:
    first, second, speed = floats
    values = np.full(len(NAMES), -1.0)
    write_outer(values, outer(tick, first, second, closed, speed))
    expected = [tick, first, closed, second, not closed, speed]
    np.testing.assert_array_equal(values, np.array(expected, dtype=np.float64))


def test_what_lies_beyond_the_columns_is_left_alone() -> None:
    values = np.full(len(NAMES) + 2, 7.0)
    write_outer(values, outer(1, 2.0, 3.0, True, 4.0))
    assert values.tolist() == [1.0, 2.0, 1.0, 3.0, 0.0, 4.0, 7.0, 7.0]


def test_a_row_too_short_is_refused_and_not_touched() -> None:
    values = np.full(len(NAMES) - 1, 7.0)
    with pytest.raises(IndexError, match="a row of Outer has 6 columns"):
        write_outer(values, outer(1, 2.0, 3.0, True, 4.0))
    assert values.tolist() == [7.0] * 5


def test_a_table_takes_a_record_in_the_row_that_is_named_and_nowhere_else() -> None:
    table = np.full((3, len(NAMES) + 1), 7.0)
    row.table_writer(Outer)(table, 1, outer(1, 2.0, 3.0, True, 4.0))
    assert table.tolist() == [[7.0] * 7, [1.0, 2.0, 1.0, 3.0, 0.0, 4.0, 7.0], [7.0] * 7]


def test_a_table_gives_the_record_of_the_row_that_is_named() -> None:
    table = np.array([[9.0, 0.0], [2.5, 1.0], [8.0, 0.0]])
    assert row.table_reader(Inner)(table, 1) == Inner(2.5, True)
    assert row.table_reader(Inner)(table, 2) == Inner(8.0, False)


class Text(NamedTuple):
    name: str


class Maybe(NamedTuple):
    depth_mm: float | None


class Nested(NamedTuple):
    text: Text


@pytest.mark.parametrize(
    ("record", "where"), [(Text, "Text.name"), (Maybe, "Maybe.depth_mm"), (Nested, "Text.name")]
)
def test_a_field_that_is_no_number_is_refused_by_name(record: type, where: str) -> None:
    with pytest.raises(TypeError, match=where):
        row.columns(record)
    with pytest.raises(TypeError, match=where):
        row.writer(record)


def rows() -> list[list[float]]:
    values = np.zeros((3, len(NAMES)))
    for i, record in enumerate(
        [outer(3, 0.1, -2.5, True, 1e300), outer(0, 5e-324, 0.0, False, -0.0)]
    ):
        write_outer(values[i], record)
    return [[float(value) for value in line] for line in values]


def test_compiled_equals_plain_python() -> None:
    assert run_plain("tests.kernel.codegen.test_row", "rows") == rows()


def test_the_trace_has_no_two_columns_of_one_name() -> None:
    from opensuction.simulation.closed_loop import COLUMNS

    assert len(set(COLUMNS)) == len(COLUMNS)
    assert {"time_s", "phase", "verdict.trips", "commands.insertion_v"} <= set(COLUMNS)


class Flat(NamedTuple):
    tick: int
    inner: Inner
    again: Inner
    speed_mm_per_s: float


write_flat, read_flat = row.writer(Flat), row.reader(Flat)


@given(
    tick=st.integers(-(2**53), 2**53),
    floats=st.tuples(*[st.floats(allow_nan=False)] * 3),
    closed=st.booleans(),
)
def test_a_record_comes_back_from_its_row(
    tick: int, floats: tuple[float, float, float], closed: bool
) -> None:
    first, second, speed = floats
    record = Flat(tick, Inner(first, closed), Inner(second, not closed), speed)
    values = np.zeros(len(row.columns(Flat)))
    write_flat(values, record)
    assert read_flat(values) == record


def test_a_record_is_not_read_from_a_row_that_is_too_short() -> None:
    with pytest.raises(IndexError, match="a row of Flat has 6 columns"):
        read_flat(np.zeros(5))


def test_no_record_with_an_array_is_read_from_a_row() -> None:
    with pytest.raises(TypeError, match=r"Outer\.samples"):
        row.reader(Outer)


class Plays(NamedTuple):
    tick: int
    positions_mm: Annotated[tuple[float, ...], Len(3, 3)]
    inner: Inner


PLAYS = Plays(7, (0.5, -0.0, float("inf")), Inner(2.5, True))


def test_a_tuple_that_declares_its_length_has_a_column_for_each_number() -> None:
    assert row.columns(Plays) == (
        "tick",
        "positions_mm.0",
        "positions_mm.1",
        "positions_mm.2",
        "inner.depth_mm",
        "inner.closed",
    )
    assert [column.kind for column in row.layout(Plays)] == [int, float, float, float, float, bool]


def test_a_tuple_comes_back_from_its_row_and_from_a_table() -> None:
    values, table = np.zeros(6), np.zeros((2, 6))
    row.writer(Plays)(values, PLAYS)
    row.table_writer(Plays)(table, 1, PLAYS)
    assert values.tolist() == table[1].tolist() == [7.0, 0.5, -0.0, float("inf"), 2.5, 1.0]
    assert row.reader(Plays)(values) == row.table_reader(Plays)(table, 1) == PLAYS


class Unsized(NamedTuple):
    positions_mm: tuple[float, ...]


class Ranged(NamedTuple):
    positions_mm: Annotated[tuple[float, ...], Len(1, 3)]


class Whole(NamedTuple):
    counts: Annotated[tuple[int, ...], Len(2, 2)]


@pytest.mark.parametrize("record", [Unsized, Ranged, Whole])
def test_a_tuple_that_does_not_declare_one_length_of_doubles_is_refused(record: type) -> None:
    with pytest.raises(TypeError, match=rf"{record.__name__}\."):
        row.columns(record)
    with pytest.raises(TypeError, match=rf"{record.__name__}\."):
        row.reader(record)
