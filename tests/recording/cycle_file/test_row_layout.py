import math

import numpy as np
import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from hypothesis import given
from hypothesis import strategies as st

from opensuction.recording.cycle_file import row_schema
from opensuction.recording.cycle_file.row_schema import SchemaColumn

PARTS = st.sampled_from(["head_mm", "cam", "plays", "0", "1", "is_on", "core"])
NUMBERS = {
    float: st.floats(allow_nan=True, allow_infinity=True, width=64),
    int: st.integers(-(2**53), 2**53).map(float),
    bool: st.booleans().map(float),
}


@st.composite
def columns(draw: st.DrawFn) -> tuple[SchemaColumn, ...]:
    """Columns of records within records, fields of one record beside each other."""
    kinds = st.sampled_from([float, int, bool])
    tops = draw(st.lists(PARTS, min_size=1, max_size=4, unique=True))
    found = []
    for top in tops:
        inner = draw(st.lists(PARTS, max_size=5, unique=True))
        names = [f"{top}.{part}" for part in inner] or [top]
        found += [SchemaColumn(name, draw(kinds)) for name in names]
    return tuple(found)


@given(columns(), st.data())
def test_a_table_comes_back_bit_for_bit_and_protobuf_reads_the_same(
    columns: tuple[SchemaColumn, ...], data: st.DataObject
) -> None:
    table = np.array([[data.draw(NUMBERS[one.kind]) for one in columns] for _ in range(3)])
    layout = row_schema.layout_of(columns)
    rows = np.empty((3, 4 + layout.size), np.uint8)
    row_schema.pack(layout, table, rows, 4)
    assert row_schema.unpack(layout, rows, 4).tobytes() == table.tobytes()

    description = row_schema.describe("Tick", columns)
    pool = DescriptorPool()
    pool.Add(FileDescriptorSet.FromString(description).file[0])
    message = GetMessageClass(pool.FindMessageTypeByName("opensuction.Tick"))
    read = message.FromString(rows[1, 4:].tobytes())
    for column, number in zip(columns, table[1], strict=True):
        value = read
        for part in column.name.split("."):
            value = getattr(value, part if part.isidentifier() else f"item_{part}")
        assert value == number or (math.isnan(value) and math.isnan(number))
        assert column.kind is float or isinstance(value, column.kind)


@given(columns())
def test_the_description_holds_names_and_kinds(columns: tuple[SchemaColumn, ...]) -> None:
    assert row_schema.columns_of("Tick", row_schema.describe("Tick", columns)) == columns


def test_a_name_that_comes_twice_is_refused() -> None:
    with pytest.raises(ValueError, match=r"a\.b: there are two"):
        row_schema.describe("Tick", [SchemaColumn("a.b", float), SchemaColumn("a.b", int)])
    with pytest.raises(ValueError, match="a is a column itself"):
        row_schema.describe("Tick", [SchemaColumn("a", float), SchemaColumn("a.b", int)])


def test_a_row_of_another_layout_is_refused() -> None:
    one = row_schema.layout_of([SchemaColumn("a", float), SchemaColumn("b.c", bool)])
    other = row_schema.layout_of([SchemaColumn("b.c", bool), SchemaColumn("a", float)])
    rows = np.empty((1, one.size), np.uint8)
    row_schema.pack(one, np.ones((1, 2)), rows, 0)
    with pytest.raises(ValueError, match="not laid out"):
        row_schema.unpack(other, rows, 0)
