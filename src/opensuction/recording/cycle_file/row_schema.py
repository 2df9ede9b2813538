"""Protobuf description of a row of numbers, which is stored in the file with the rows.

No ``.proto`` file: the description is made from the columns' dotted names, a message for each
prefix, so that whoever opens the file sees a tree. It holds all that is needed to read the rows.

Events of a recording: a message at an instant, each of its own protobuf type.

Rows of doubles as protobuf messages of one length, many at once.

Every field is written, zero or not, and has a fixed length: so each number has its place, and a
table is packed and read in one call of machine code (`kernel.message_row`).

Tables of a controller in a recording: a row for each tick, and each state that was set.

The columns are the same for a simulation and a machine. A tick's row has all inputs, all outputs,
and the whole state after the tick.
"""

from collections.abc import Iterator, Sequence
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
from google.protobuf.descriptor_pb2 import (
    DescriptorProto,
    FieldDescriptorProto,
    FileDescriptorProto,
    FileDescriptorSet,
)
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from numpy.typing import NDArray

from opensuction.controller.record import Inputs, Outputs, State
from opensuction.kernel import message_row
from opensuction.kernel.codegen import row
from opensuction.kernel.message_row import Bytes, Places

PACKAGE = "opensuction"
KINDS: dict[type, int] = {
    float: FieldDescriptorProto.TYPE_DOUBLE,
    int: FieldDescriptorProto.TYPE_SFIXED64,
    bool: FieldDescriptorProto.TYPE_BOOL,
}
"""By the kind of a column. All have a fixed length, so that all rows are equally long."""
_OF_TYPE = {number: kind for kind, number in KINDS.items()}


class SchemaColumn(NamedTuple):
    """A column of a table of doubles."""

    name: str
    """Dotted path: ``inputs.readings.head_mm``."""
    kind: type
    """What its numbers stand for: float, int or bool."""


Tree = dict[str, Any]
"""By the part of a path: the index of a column, or a tree."""


def tree_of(columns: Sequence[SchemaColumn]) -> Tree:
    """The columns by the parts of their names. Raises ValueError for a name that comes twice."""
    root: Tree = {}
    for index, column in enumerate(columns):
        *path, last = column.name.split(".")
        node = root
        for part in path:
            node = node.setdefault(part, {})
            if not isinstance(node, dict):
                raise ValueError(f"column {column.name}: {part} is a column itself")
        if last in node:
            raise ValueError(f"column {column.name}: there are two of that name")
        node[last] = index
    return root


def _identifier(part: str) -> str:
    """A part of a name as protobuf allows it: the elements of a tuple are numbers."""
    return part if part.isidentifier() else f"item_{part}"


def _type_name(part: str) -> str:
    return "".join(word.capitalize() for word in _identifier(part).split("_"))


def _describe(
    name: str, scope: str, node: Tree, columns: Sequence[SchemaColumn]
) -> DescriptorProto:
    """A message. scope: full name of what it is in."""
    full = f"{scope}.{name}"
    message = DescriptorProto(name=name)
    for number, (part, child) in enumerate(node.items(), start=1):
        field = message.field.add(
            name=_identifier(part),
            json_name=part,
            number=number,
            label=FieldDescriptorProto.LABEL_OPTIONAL,
        )
        if isinstance(child, dict):
            inner = _describe(_type_name(part), full, child, columns)
            message.nested_type.append(inner)
            field.type = FieldDescriptorProto.TYPE_MESSAGE
            field.type_name = f"{full}.{inner.name}"
        else:
            field.type = KINDS[columns[child].kind]
    return message


def describe(name: str, columns: Sequence[SchemaColumn]) -> bytes:
    """Description of a row as a serialised FileDescriptorSet, what an MCAP schema holds.

    name: of the message, within `PACKAGE`.
    """
    message = _describe(name, f".{PACKAGE}", tree_of(columns), columns)
    return enclose(message)


def enclose(message: DescriptorProto) -> bytes:
    """A message's description as a serialised FileDescriptorSet."""
    file = FileDescriptorProto(
        name=f"{PACKAGE}/{message.name.lower()}.proto", package=PACKAGE, syntax="proto3"
    )
    file.message_type.append(message)
    data: bytes = FileDescriptorSet(file=[file]).SerializeToString(deterministic=True)
    return data


def columns_of(name: str, description: bytes) -> tuple[SchemaColumn, ...]:
    """The columns of a description that `describe` made, in this or another version.

    Raises ValueError for a description of something else.
    """
    files = FileDescriptorSet.FromString(description).file
    messages = [one for file in files for one in file.message_type if one.name == name]
    if len(messages) != 1:
        raise ValueError(f"no description of a {name}")
    return tuple(_columns_of(messages[0], ""))


def _columns_of(message: DescriptorProto, prefix: str) -> Iterator[SchemaColumn]:
    inner = {one.name: one for one in message.nested_type}
    for number, field in enumerate(message.field, start=1):
        path = f"{prefix}{field.json_name or field.name}"
        if field.number != number:
            raise ValueError(f"field {path} has the number {field.number}, not {number}")
        if field.type == FieldDescriptorProto.TYPE_MESSAGE:
            yield from _columns_of(inner[field.type_name.rpartition(".")[2]], f"{path}.")
        elif field.type in _OF_TYPE:
            yield SchemaColumn(path, _OF_TYPE[field.type])
        else:
            raise ValueError(f"field {path} is of a type that a row does not have")


NAME = "Event"
_TYPES = {int: FieldDescriptorProto.TYPE_INT64, str: FieldDescriptorProto.TYPE_STRING}


class RecordedEvent(NamedTuple):
    """Something that happened; its instant in UTC is the message's."""

    tick: int
    """In which, or before which."""
    kind: str
    """``phase``, ``trip``, ``alarm``, ``told``, ``request``, ``fault``, ``start`` or ``gap``."""
    name: str
    """Of the phase, trip, alarm, ..."""
    detail: str = ""
    who: str = ""
    """A request's: who asked; of what people were told: who raised it."""
    key: str = ""
    """A request's: by which its repetition is known."""


@cache
def description() -> bytes:
    """Of the message, as a serialised FileDescriptorSet."""
    message = DescriptorProto(name=NAME)
    for number, (name, kind) in enumerate(RecordedEvent.__annotations__.items(), start=1):
        message.field.add(
            name=name,
            number=number,
            label=FieldDescriptorProto.LABEL_OPTIONAL,
            type=_TYPES[kind],
        )
    return enclose(message)


@cache
def _message() -> Any:
    pool = DescriptorPool()
    pool.Add(FileDescriptorSet.FromString(description()).file[0])
    return GetMessageClass(pool.FindMessageTypeByName(f"{PACKAGE}.{NAME}"))


def encode(event: RecordedEvent) -> bytes:
    """The message of an event."""
    data: bytes = _message()(**event._asdict()).SerializeToString(deterministic=True)
    return data


def decode(data: bytes) -> RecordedEvent:
    """The event of a message; fields of newer versions are left out."""
    message = _message().FromString(data)
    return RecordedEvent(*(getattr(message, name) for name in RecordedEvent._fields))


Table = NDArray[np.float64]

FIXED, VARINT, LENGTH = 1, 0, 2
"""Protobuf's wire types that are used."""
LAYOUTS = 16
"""Layouts that are kept: of a file's two tables, and of those of other versions."""
_NUMBERS = {float: message_row.FLOAT, int: message_row.INT, bool: message_row.BOOL}


class Layout(NamedTuple):
    """Layout of a row's numbers in a message."""

    columns: tuple[SchemaColumn, ...]
    template: Bytes
    """A row of zeros."""
    places: Places
    is_number: NDArray[np.bool_]
    """Of each byte: it belongs to a number, and is no part of the description."""

    @property
    def size(self) -> int:
        """Bytes of a message."""
        return self.template.size


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*out, value))


def _place(node: Tree, columns: Sequence[SchemaColumn], places: dict[int, int], at: int) -> bytes:
    """A message of zeros. places: taken down for each column, from ``at`` on."""
    out = bytearray()
    for number, child in enumerate(node.values(), start=1):
        if isinstance(child, dict):
            # Its length stands before it and moves it: known from a first, idle placing.
            size = len(_place(child, columns, {}, 0))
            out += _varint(number << 3 | LENGTH) + _varint(size)
            out += _place(child, columns, places, at + len(out))
            continue
        narrow = columns[child].kind is bool
        out += _varint(number << 3 | (VARINT if narrow else FIXED))
        places[child] = at + len(out)
        out += bytes(1 if narrow else 8)
    return bytes(out)


def layout_of(columns: Sequence[SchemaColumn]) -> Layout:
    """Layout of the message that `row_schema.describe` describes.

    Once it is there, `pack` and `unpack` compile nothing.
    """
    return _layout_of(tuple(columns))


@lru_cache(LAYOUTS)
def _layout_of(columns: tuple[SchemaColumn, ...]) -> Layout:
    for column in columns:
        if column.kind not in KINDS:
            raise ValueError(f"column {column.name} is {column.kind}")
    found: dict[int, int] = {}
    template = np.frombuffer(_place(tree_of(columns), columns, found, 0), np.uint8)
    at = [found[index] for index in range(len(columns))]
    is_number = np.zeros(template.size, np.bool_)
    for column, first in zip(columns, at, strict=True):
        is_number[first : first + (1 if column.kind is bool else message_row.WORD)] = True
    kind = [_NUMBERS[column.kind] for column in columns]
    places = Places(np.array(at, np.uint64), np.array(kind, np.int64))
    made = Layout(columns, template, places, is_number)
    row = np.empty((1, made.size), np.uint8)
    pack(made, np.zeros((1, len(columns))), row, 0)
    row.flags.writeable = False  # as a reader has them: machine code of another kind
    unpack(made, row, 0)
    return made


def pack(layout: Layout, table: Table, rows: Bytes, at: int) -> None:
    """Write the messages of a table's rows.

    table: shape (rows, columns). rows: written; shape (rows, bytes), contiguous, the message of a
    row from the byte ``at`` on.
    """
    messages = rows[:, at : at + layout.size]
    messages[:] = layout.template
    numbers = np.ascontiguousarray(table)
    message_row.write(layout.places, numbers, numbers.view(np.uint64), messages)


def unpack(layout: Layout, rows: Bytes, at: int) -> Table:
    """The table that `pack` wrote. Raises ValueError for rows of another layout."""
    messages = rows[:, at : at + layout.size]
    if not message_row.is_described(layout.template, layout.is_number, messages[0]):
        raise ValueError("a row is not laid out as its description says")
    table = np.empty((len(rows), len(layout.columns)))
    message_row.read(layout.places, messages, table, table.view(np.uint64))
    return table


TICKS = "/tick"
"""Topic of the ticks; a tick that is missing was not made, or its row was lost."""
STARTS = "/start"
"""Topic of states that were set from outside; each belongs before the tick that it names."""
INPUTS, OUTPUTS, STATE = "inputs", "outputs", "state"
"""How the names of a tick's columns begin."""


def prefixed(prefix: str, record_type: type) -> tuple[SchemaColumn, ...]:
    """Columns of a record, their names behind a prefix."""
    return tuple(SchemaColumn(f"{prefix}.{one.name}", one.kind) for one in row.layout(record_type))


TICK_COLUMNS = (
    *prefixed(INPUTS, Inputs),
    *prefixed(OUTPUTS, Outputs),
    *prefixed(STATE, State),
)
START_COLUMNS = (SchemaColumn("tick", int), *prefixed(STATE, State))

TABLES = {TICKS: TICK_COLUMNS, STARTS: START_COLUMNS}
"""Columns of each topic, as a writer takes them."""

INPUT_PART = slice(0, len(row.columns(Inputs)))
OUTPUT_PART = slice(INPUT_PART.stop, INPUT_PART.stop + len(row.columns(Outputs)))
STATE_PART = slice(OUTPUT_PART.stop, len(TICK_COLUMNS))
"""Where a tick's row has them."""
