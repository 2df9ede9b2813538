import json
import math
from typing import Annotated, NamedTuple

import pytest
from annotated_types import Len
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError


class Inner(NamedTuple):
    depth_mm: float
    closed: bool


class Outer(NamedTuple):
    tick: int
    inner: Inner
    plays_mm: Annotated[tuple[float, ...], Len(2, 2)]


OUTER = Outer(3, Inner(2.5, True), (0.5, math.inf))
WRITTEN = {
    "tick": 3,
    "inner.depth_mm": 2.5,
    "inner.closed": True,
    "plays_mm.0": 0.5,
    "plays_mm.1": "inf",
}


def test_every_scalar_stands_under_its_dotted_path() -> None:
    assert plain_row.write(Outer, OUTER) == WRITTEN
    assert [type(one) for one in plain_row.write(Outer, OUTER).values()] == [
        int,
        float,
        bool,
        float,
        str,
    ]


@given(
    tick=st.integers(-(2**53), 2**53),
    floats=st.tuples(*[st.floats(allow_nan=False)] * 3),
    closed=st.booleans(),
)
def test_a_record_comes_back_from_json_bit_for_bit(
    tick: int, floats: tuple[float, float, float], closed: bool
) -> None:
    record = Outer(tick, Inner(floats[0], closed), floats[1:])
    text = json.dumps(plain_row.write(Outer, record), allow_nan=False)
    back = plain_row.read(Outer, json.loads(text), "here")
    assert plain_row.pack(Outer, back).tobytes() == plain_row.pack(Outer, record).tobytes()
    assert repr(back) == repr(record)


def test_what_is_not_a_number_comes_back_as_such() -> None:
    text = json.dumps(plain_row.write(Inner, Inner(math.nan, False)), allow_nan=False)
    assert math.isnan(plain_row.read(Inner, json.loads(text), "here").depth_mm)


def test_a_whole_number_stands_for_a_double() -> None:
    assert repr(plain_row.read(Inner, {"depth_mm": 2, "closed": True}, "here").depth_mm) == "2.0"


def without(name: str) -> dict[str, object]:
    return {key: value for key, value in WRITTEN.items() if key != name}


@pytest.mark.parametrize(
    ("found", "words"),
    [
        ([1, 2], "here is no object of fields"),
        (without("tick"), "here: 'tick': not there"),
        ({}, "here: 'tick', 'inner.depth_mm', 'inner.closed' and 2 more: not there"),
        (WRITTEN | {"tock": 1}, "here: 'tock': not known"),
        (WRITTEN | {"tick": 3.5}, "here: tick is 3.5: should be a whole number"),
        (WRITTEN | {"tick": True}, "here: tick is True: should be a whole number"),
        (WRITTEN | {"tick": 2**53 + 1}, "here: tick is 9007199254740993: should be a whole"),
        (
            WRITTEN | {"inner.depth_mm": "deep"},
            "here: inner.depth_mm is 'deep': should be a number",
        ),
        (WRITTEN | {"inner.depth_mm": None}, "here: inner.depth_mm is None: should be a number"),
        (WRITTEN | {"inner.depth_mm": False}, "here: inner.depth_mm is False: should be a number"),
        (WRITTEN | {"inner.closed": 1}, "here: inner.closed is 1: should be true or false"),
        (WRITTEN | {"plays_mm.1": 10**400}, "here: plays_mm.1 is 1000.*: should be a number"),
    ],
)
def test_what_is_no_such_record_is_refused_in_one_line(found: object, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        plain_row.read(Outer, found, "here")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 200
