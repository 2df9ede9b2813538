"""Classes of transmission: what kind of thing lies between the catheter's head and its tip."""

from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel.name import by_name
from opensuction.twin.conduit.play_line import NO_LINES, PlayLines


class TransmissionKind(IntEnum):
    """Kind of the transmission from the head to the catheter's tip."""

    PLAYS = 0
    """Clearances along the bends, and a narrow friction-limited stretch behind them."""
    BOUC_WEN = 1
    """No clearance: a lag that bends into saturation, by the Bouc-Wen equations."""
    RUBBING = 2
    """Clearances, and behind them a stretch whose friction depends on speed."""
    RECORDED = 3
    """Plays read out by lines of their own, as a real recording asks for."""


KIND_OF_NAME = by_name(TransmissionKind)


class TransmissionClass(NamedTuple):
    """A class with what its parameters in the machine's table do not say."""

    name: str
    kind: TransmissionKind
    lines: PlayLines
    """Of a recorded conduit."""
    offset_mm: float
    """Tip of a recorded conduit with every play at its low end."""


PLAYS = TransmissionClass("plays", TransmissionKind.PLAYS, NO_LINES, 0.0)
BOUC_WEN = TransmissionClass("bouc-wen", TransmissionKind.BOUC_WEN, NO_LINES, 0.0)
RUBBING = TransmissionClass("rubbing", TransmissionKind.RUBBING, NO_LINES, 0.0)


def recorded(name: str, lines: PlayLines, offset_mm: float) -> TransmissionClass:
    """The class of a conduit that a recording was fitted with."""
    return TransmissionClass(name, TransmissionKind.RECORDED, lines, offset_mm)
