import math
from collections.abc import Mapping
from datetime import date
from enum import IntEnum
from typing import Annotated, Any, NamedTuple

import pytest
from annotated_types import Ge, Gt, Interval, Le
from hypothesis import given
from hypothesis import strategies as st
from pydantic import Field

from opensuction.kernel.errors import InputError
from opensuction.settings.validation import validate


class Compensation(IntEnum):
    NONE = 0
    EXACT_INVERSE = 1


class Servo(NamedTuple):
    proportional_v_per_mm: Annotated[float, Gt(0)]
    compensation: Compensation


class Cycle(NamedTuple):
    dwell_s: Annotated[float, Interval(ge=0, le=15)]
    vacuum_mmhg: Annotated[float, Field(ge=0, le=150)]
    offset_mm: float
    strokes: Annotated[int, Ge(1), Le(9)]
    name: str
    is_timed: bool
    servo: Servo
    ratio: Annotated[float, Ge(0), Le(1)] = 0.5


def valid() -> dict[str, Any]:
    return {
        "dwell_s": 9.0,
        "vacuum_mmhg": 120.0,
        "offset_mm": -7.151,
        "strokes": 1,
        "name": "paper",
        "is_timed": False,
        "servo": {"proportional_v_per_mm": 10.0, "compensation": "exact-inverse"},
        "ratio": 0.4,
    }


def refusal(mapping: object) -> str:
    with pytest.raises(InputError) as raised:
        validate(Cycle, mapping, "cycle.toml")
    return str(raised.value)


def test_a_complete_mapping_becomes_a_record_with_its_sections() -> None:
    assert validate(Cycle, valid(), "cycle.toml") == Cycle(
        dwell_s=9.0,
        vacuum_mmhg=120.0,
        offset_mm=-7.151,
        strokes=1,
        name="paper",
        is_timed=False,
        servo=Servo(proportional_v_per_mm=10.0, compensation=Compensation.EXACT_INVERSE),
        ratio=0.4,
    )


def test_a_whole_number_for_a_float_becomes_a_float() -> None:
    record = validate(Cycle, valid() | {"dwell_s": 9}, "cycle.toml")
    assert type(record.dwell_s) is float


def test_a_record_taken_apart_and_changed_validates_again() -> None:
    record = validate(Cycle, valid(), "cycle.toml")
    changed = validate(Cycle, record._asdict() | {"dwell_s": 8.0}, "--dwell")
    assert changed == record._replace(dwell_s=8.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"dwell_s": 20.0},
            "cycle.toml: dwell_s is 20.0 s, above the limit of 15 s; "
            "give a number in s, at least 0 and at most 15",
        ),
        (
            {"vacuum_mmhg": -1},
            "cycle.toml: vacuum_mmhg is -1 mmHg, below the limit of 0 mmHg; "
            "give a number in mmHg, at least 0 and at most 150",
        ),
        (
            {"servo": {"proportional_v_per_mm": 0, "compensation": "none"}},
            "cycle.toml: servo.proportional_v_per_mm is 0 V/mm, exactly the limit of 0 V/mm; "
            "give a number in V/mm, above 0",
        ),
        (
            {"ratio": 1.5},
            "cycle.toml: ratio is 1.5, above the limit of 1; "
            "give a number, at least 0 and at most 1",
        ),
        (
            {"offset_mm": math.nan},
            "cycle.toml: offset_mm is nan, not a finite number; give a number in mm",
        ),
        (
            {"dwell_s": "9"},
            "cycle.toml: dwell_s is '9', not a number; "
            "give a number in s, at least 0 and at most 15",
        ),
        (
            {"offset_mm": True},
            "cycle.toml: offset_mm is true, not a number; give a number in mm",
        ),
        (
            {"strokes": 1.0},
            "cycle.toml: strokes is 1.0, not a whole number; "
            "give a whole number, at least 1 and at most 9",
        ),
        (
            {"is_timed": 1},
            "cycle.toml: is_timed is 1, not true or false; give true or false",
        ),
        (
            {"servo": {"proportional_v_per_mm": 10, "compensation": "exact-invers"}},
            "cycle.toml: unknown servo.compensation 'exact-invers': "
            "did you mean 'exact-inverse'? Known: none, exact-inverse",
        ),
        (
            {"servo": {"compensation": "none"}},
            "cycle.toml: servo.proportional_v_per_mm is missing; give a number in V/mm, above 0",
        ),
        (
            {"servo": 3},
            "cycle.toml: servo is 3, not a section; "
            "keys of the section: proportional_v_per_mm, compensation",
        ),
        (
            {"servo": [10.0, "none"]},
            "cycle.toml: servo is a list, not a section; "
            "keys of the section: proportional_v_per_mm, compensation",
        ),
    ],
)
def test_a_message_says_what_where_the_value_the_limit_and_the_remedy(
    change: dict[str, Any], message: str
) -> None:
    assert refusal(valid() | change) == message


class Lists(NamedTuple):
    strengths: list[float]
    alarm: list[str]
    patient: str | list[str]
    at_s: list[float]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"strengths": [1.0, math.nan]},
            "strengths is a list whose entry 2 is nan, not a finite number; give a list of numbers",
        ),
        ({"at_s": 0.5}, "at_s is 0.5, not a list of numbers; give a list of numbers in s"),
        (
            {"alarm": "PUMP_RUNAWAY"},
            "alarm is 'PUMP_RUNAWAY', not a list of texts in quotes; give a list of texts in "
            "quotes",
        ),
        (
            {"alarm": ["PUMP_RUNAWAY", 3]},
            "alarm is a list whose entry 2 is 3, not a text in quotes; give a list of texts in "
            "quotes",
        ),
        (
            {"patient": ["neonate", 3]},
            "patient is a list, not a text in quotes or a list of them; give a text in quotes or "
            "a list of them",
        ),
        (
            {"at_s": date(1979, 5, 27)},
            "at_s is 1979-05-27, not a list of numbers; give a list of numbers in s",
        ),
    ],
)
def test_a_message_about_a_list_says_which_entry_and_what_belongs_there(
    change: dict[str, Any], message: str
) -> None:
    given = {"strengths": [], "alarm": [], "patient": "neonate", "at_s": []}
    with pytest.raises(InputError) as raised:
        validate(Lists, given | change, "mine.toml")
    assert str(raised.value) == f"mine.toml: {message}"


def test_a_misspelt_key_is_reported_before_the_one_it_leaves_missing() -> None:
    mapping = valid()
    mapping["dwel_s"] = mapping.pop("dwell_s")
    assert refusal(mapping) == (
        "cycle.toml: unknown key dwel_s: did you mean 'dwell_s'? Known: dwell_s, vacuum_mmhg, "
        "offset_mm, strokes, name, is_timed, servo, ratio (and 1 more problem)"
    )


def test_a_default_of_the_record_type_does_not_fill_a_missing_key() -> None:
    mapping = valid()
    del mapping["ratio"]
    assert "ratio is missing" in refusal(mapping)


def test_something_that_is_no_mapping_is_refused() -> None:
    assert refusal([1, 2]).startswith("cycle.toml: found a list, not a section; keys of")


@pytest.mark.parametrize("huge", [10**400, -(10**400), 10**5000], ids=["up", "down", "unwritable"])
def test_a_number_no_float_can_hold_is_refused(huge: int) -> None:
    assert "offset_mm" in refusal(valid() | {"offset_mm": huge})


def test_a_whole_number_beyond_64_bits_is_refused() -> None:
    class Counted(NamedTuple):
        ticks: int

    with pytest.raises(InputError, match="more than 64 bits hold"):
        validate(Counted, {"ticks": 2**63}, "cycle.toml")
    assert validate(Counted, {"ticks": 2**63 - 1}, "cycle.toml").ticks == 2**63 - 1


SCALARS = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text()
    | st.binary()
    | st.just(10**400)
    | st.dates()
)
KEYS = st.sampled_from([*Cycle._fields, *Servo._fields]) | st.text() | st.integers()
ANYTHING = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3)
)


@st.composite
def mutated(draw: st.DrawFn) -> object:
    """A valid mapping after up to three changes, in the section or outside it."""
    mapping = valid()
    for _ in range(draw(st.integers(0, 3))):
        target = draw(st.sampled_from([mapping, mapping.get("servo")]))
        if not isinstance(target, dict):
            return draw(ANYTHING)
        if draw(st.booleans()):
            target[draw(KEYS)] = draw(ANYTHING)
        elif target:
            del target[draw(st.sampled_from(list(target)))]
    return mapping


def is_in_range(record: Cycle) -> bool:
    return (
        0 <= record.dwell_s <= 15
        and 0 <= record.vacuum_mmhg <= 150
        and math.isfinite(record.offset_mm)
        and 1 <= record.strokes <= 9
        and 0 < record.servo.proportional_v_per_mm < math.inf
        and 0 <= record.ratio <= 1
    )


@given(mutated(), st.text())
def test_any_input_gives_a_sound_record_or_one_line(mapping: object, where: str) -> None:
    try:
        record = validate(Cycle, mapping, where)
    except InputError as error:
        assert len(str(error).splitlines()) == 1
        assert str(error).isprintable()
    else:
        assert isinstance(mapping, Mapping)
        assert is_in_range(record)
        assert [type(value) for value in record] == [
            float,
            float,
            float,
            int,
            str,
            bool,
            Servo,
            float,
        ]
