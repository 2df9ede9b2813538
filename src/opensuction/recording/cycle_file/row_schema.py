"""Protobuf description of a row of numbers, which is stored in the file with the rows.

No ``.proto`` file: the description is made from the columns' dotted names, a message for each
prefix, so that whoever opens the file sees a tree. It holds all that is needed to read the rows.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from google.protobuf.descriptor_pb2 import (
    DescriptorProto,
    FieldDescriptorProto,
    FileDescriptorProto,
    FileDescriptorSet,
)

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
