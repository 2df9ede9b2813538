"""The schema of the commands' objects says what `to_json` makes of their records."""

import json
from collections.abc import Mapping
from typing import Annotated, Any, Generic, Literal, NamedTuple, TypeVar

import pytest
from typer.main import get_command

from docs.generator import benchmark_columns, result_schema
from docs.generator.catalogue import BENCHMARK, DOCS, read
from docs.generator.result_schema import CommandObject
from opensuction.cli.app import app
from opensuction.records.entry import Outcome
from opensuction.result.plain import FLAT, IF_FINITE, IF_KNOWN, to_json
from tests.cli.result_schema import find_faults, load

Value = TypeVar("Value")


class Depth(NamedTuple):
    """A depth, and its
    limit; None: there is none."""

    depth_mm: float
    """Below the ``tube``."""
    limit_mm: float | None


class NoDepth(NamedTuple):
    """In its place."""

    depth_mm: None = None
    limit_mm: None = None


class Pair(NamedTuple, Generic[Value]):
    """Two of a kind."""

    first: Value
    second: Value


class Measurement(NamedTuple):
    """Every kind of field that a result has."""

    name: str
    seed: int | str
    is_valid: bool | None
    side: Literal["left", "right"]
    outcome: Outcome | None
    noise_mm: Annotated[float, IF_FINITE]
    """nan where it was not measured."""
    age_h: Annotated[float | None, IF_KNOWN]
    ends: tuple[float, float] | None
    depths: tuple[Depth, ...]
    by_name: Mapping[str, Depth]
    counts: Pair[int]
    flat: Annotated[Depth | NoDepth, FLAT]


class Recorded(NamedTuple):
    """One that a recording may give, and what its heading says."""

    depth: Annotated[Depth | None, FLAT]
    """None without one."""
    heading: Annotated[Mapping[str, str], FLAT]
    """Whatever there is."""


FOUND = Measurement(
    name="a",
    seed=1,
    is_valid=None,
    side="left",
    outcome=Outcome.COMPLETED,
    noise_mm=float("nan"),
    age_h=None,
    ends=(0.0, 1.0),
    depths=(Depth(1.0, None),),
    by_name={"b": Depth(2.0, 3.0)},
    counts=Pair(1, 2),
    flat=Depth(4.0, None),
)
ALL = json.loads(json.dumps(to_json(FOUND)))


@pytest.fixture
def measurement(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Definitions of a command whose object is a `Measurement`; the check goes by them."""
    objects = {
        "measure": CommandObject(Measurement),
        "read": CommandObject(Recorded, always=("depth",)),
        "skip": CommandObject(Recorded, never=("depth",)),
        "try": CommandObject(Recorded),
    }
    monkeypatch.setattr(result_schema, "OBJECTS", objects)
    made = result_schema.schema()
    monkeypatch.setattr("tests.cli.result_schema.load", lambda: made)
    definitions: dict[str, Any] = made["$defs"]
    return definitions


@pytest.mark.parametrize(
    ("field", "expected"),
    [
        ("name", {"type": "string"}),
        ("seed", {"type": ["integer", "string"]}),
        ("is_valid", {"type": ["boolean", "null"]}),
        ("side", {"enum": ["left", "right"]}),
        ("age_h", {"type": "number"}),
        ("depths", {"type": "array", "items": {"$ref": "#/$defs/Depth"}}),
        ("by_name", {"type": "object", "additionalProperties": {"$ref": "#/$defs/Depth"}}),
        ("counts", {"$ref": "#/$defs/Pairint"}),
        ("limit_mm", {"type": ["number", "null"]}),
        (
            "noise_mm",
            {"type": ["number", "null"], "description": "null where it was not measured."},
        ),
    ],
)
def test_a_field_has_the_types_of_its_annotation(
    field: str, expected: dict[str, Any], measurement: dict[str, Any]
) -> None:
    assert measurement["measure"]["properties"][field] == expected


def test_text_is_that_of_the_docstrings_in_the_words_of_json(measurement: dict[str, Any]) -> None:
    depth = measurement["Depth"]
    assert depth["title"] == "depth"
    assert depth["description"] == "A depth, and its limit; null: there is none."
    assert depth["properties"]["depth_mm"]["description"] == "Below the `tube`."
    assert "description" not in depth["properties"]["limit_mm"]
    assert measurement["Pairint"]["properties"]["first"] == {"type": "integer"}


def test_required_is_what_is_always_written(measurement: dict[str, Any]) -> None:
    assert set(measurement["measure"]["required"]) == ALL.keys()
    assert "age_h" not in ALL
    assert measurement["read"]["required"] == ["depth_mm", "limit_mm"]
    assert measurement["skip"]["required"] == measurement["try"]["required"] == []
    assert measurement["skip"]["properties"] == {}
    assert measurement["try"]["properties"].keys() == {"depth_mm", "limit_mm"}
    assert measurement["try"]["additionalProperties"] == {
        "type": "string",
        "description": "Whatever there is.",
    }


@pytest.mark.parametrize(
    "record",
    [FOUND, FOUND._replace(flat=NoDepth(), ends=None, age_h=2.0, outcome=None, noise_mm=0.1)],
)
def test_what_to_json_makes_is_valid(record: Measurement, measurement: dict[str, Any]) -> None:
    assert measurement
    assert find_faults("measure", json.loads(json.dumps(to_json(record)))) == []


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"name": None}, "measure.name: None is no string"),
        ({"seed": 1.5}, "measure.seed: 1.5 is no ['integer', 'string']"),
        ({"is_valid": 1}, "measure.is_valid: 1 is no ['boolean', 'null']"),
        ({"side": "up"}, "measure.side: 'up' is none of ['left', 'right']"),
        ({"age_h": None}, "measure.age_h: None is no number"),
        ({"ends": [1.0]}, "measure.ends: 1 entries"),
        ({"depths": [{"depth_mm": 1.0}]}, "measure.depths[0]: no limit_mm"),
        ({"counts": {"first": True, "second": 2}}, "measure.counts.first: True is no integer"),
        ({"depth": 1.0}, "measure: depth is not known"),
        ({"by_name": {"b": 1}}, "measure.by_name.b: 1 is no object"),
    ],
)
def test_what_is_not_as_the_schema_has_it_is_found(
    change: dict[str, Any], fault: str, measurement: dict[str, Any]
) -> None:
    assert measurement
    assert fault in find_faults("measure", ALL | change)


class Odd(NamedTuple):
    """With a number that JSON lacks."""

    odd: tuple[complex, ...]


class Even(NamedTuple):
    """With the same within a record."""

    inner: Odd | None


class Split(NamedTuple):
    """With two records in one place whose keys differ."""

    flat: Annotated[Depth | Pair[int], FLAT]


@pytest.mark.parametrize("record", [Odd, Even, Split])
def test_a_record_that_json_cannot_show_is_refused(
    record: type, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(result_schema, "OBJECTS", {"odd": CommandObject(record)})
    with pytest.raises(TypeError, match=r"JSON lacks|differ in keys"):
        result_schema.schema()


def test_every_command_with_an_object_has_a_schema() -> None:
    """All but ``serve``, which runs until it is stopped and prints none."""
    commands = {
        name
        for name, one in get_command(app).commands.items()  # type: ignore[attr-defined]
        if any("--json" in option.opts for option in one.params)
    }
    assert commands - {"serve"} == load()["$defs"].keys() & commands
    assert len(commands) > 15


def test_every_reference_leads_to_a_definition() -> None:
    text = (DOCS / "reference" / "results.schema.json").read_text("utf-8")
    referred = {part.split('"')[0] for part in text.split('"#/$defs/')[1:]}
    assert referred == load()["$defs"].keys()


def test_the_committed_benchmark_is_as_its_schema_has_it() -> None:
    found = to_json(benchmark_columns.read(read(BENCHMARK)))
    assert find_faults("benchmark", json.loads(json.dumps(found))) == []
