import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, NamedTuple

from opensuction.result.plain import FLAT, IF_KNOWN, measured, to_json


class Inner(NamedTuple):
    depth_mm: float | None
    note: Annotated[str | None, IF_KNOWN] = None


class Outer(NamedTuple):
    name: str
    inner: Inner
    shared: Annotated[Inner | None, FLAT] = None
    rows: tuple[Inner, ...] = ()
    table: Mapping[str, float] = MappingProxyType({})


def test_fields_become_keys_and_records_objects_whatever_they_are_in() -> None:
    outer = Outer("cycle", Inner(90.0, "near"), rows=(Inner(1.0), Inner(2.0)), table={"a": 1.0})
    assert to_json(outer) == {
        "name": "cycle",
        "inner": {"depth_mm": 90.0, "note": "near"},
        "rows": [{"depth_mm": 1.0}, {"depth_mm": 2.0}],
        "table": {"a": 1.0},
    }


def test_a_flat_record_stands_in_the_object_around_it() -> None:
    found = to_json(Outer("cycle", Inner(None), shared=Inner(3.0)))
    assert found["depth_mm"] == 3.0
    assert "shared" not in found
    assert found["inner"] == {"depth_mm": None}


def test_a_number_that_is_not_finite_was_not_measured() -> None:
    outer = Outer("cycle", Inner(math.nan), rows=(Inner(math.inf),), table={"a": -math.inf})
    known = measured(outer)
    assert known.inner.depth_mm is None
    assert known.rows == (Inner(None),)
    assert known.table == {"a": None}
    assert to_json(known) == to_json(outer)
    assert isinstance(known, Outer)


class Headed(NamedTuple):
    machine: str
    heading: Annotated[Mapping[str, str] | None, FLAT]
    ticks: int


def test_the_entries_of_a_flat_mapping_stand_in_the_object_around_it() -> None:
    assert list(to_json(Headed("m", {"patient": "neonate", "seed": "7"}, 3)).items()) == [
        *(("machine", "m"), ("patient", "neonate"), ("seed", "7"), ("ticks", 3))
    ]
    assert to_json(Headed("m", {}, 3)) == {"machine": "m", "ticks": 3}
    assert to_json(Headed("m", None, 3)) == {"machine": "m", "ticks": 3}


def test_an_entry_of_a_flat_mapping_takes_the_place_of_what_stands_before_it() -> None:
    found = to_json(Headed("serial", {"seed": "7", "machine": "clinical"}, 3))
    assert list(found.items()) == [("machine", "clinical"), ("seed", "7"), ("ticks", 3)]
