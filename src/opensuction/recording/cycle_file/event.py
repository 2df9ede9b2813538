"""Events of a recording: a message at an instant, each of its own protobuf type."""

from functools import cache
from typing import Any, NamedTuple

from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass

from opensuction.recording.cycle_file.row_schema import PACKAGE, enclose

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
