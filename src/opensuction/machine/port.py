"""The control loop's interface to a machine, whether it turns motors or only computes.

A machine keeps its own time. The loop reads its newest readings, and the machine takes the loop's
newest commands; neither waits for the other. Without new commands for `MachineFacts.watchdog_s` the
machine's drives act on their own, and obey nothing until a controller says that it has started anew
(`DriveMessage.released`).
"""

from enum import StrEnum
from typing import NamedTuple, Protocol

from opensuction.kernel.record import Array


class MachineFacts(NamedTuple):
    """Self-description of a machine."""

    name: str
    version: str
    """Of whatever drives it."""
    in_silico: bool
    """Nothing moves but numbers."""
    period_s: float
    """How often it reads and obeys."""
    watchdog_s: float
    """Without new commands for longer than this its drives act on their own."""
    most: dict[str, float]
    """Highest magnitude of what it obeys, by the name of the command's column; more is cut."""


class Port(Protocol):
    """A machine, as the loop sees it."""

    facts: MachineFacts

    def read(self, readings: Array) -> int:
        """Write the newest readings into a row by the columns of `Readings`; their number.

        Numbers grow with what is new. 0: there are none yet, and the row is as it was. Never waits.
        """

    def write(self, sent: Array) -> None:
        """Give a row by `MESSAGE_COLUMNS`, which the drives' watchdog waits for, too.

        Never waits.
        """

    def close(self) -> None:
        """Let go of the machine: it gets no more commands."""


class HandTask(StrEnum):
    """Task of a hand at the catheter head."""

    PUSH = "push"
    DRAW = "draw"
    LET_GO = "let-go"


class SimulatedHand(Protocol):
    """A hand at the catheter head that software moves, where a machine has one: a twin."""

    def hold(self, task: HandTask, park_head_mm: float, quick_mm: float) -> None:
        """Have it do something from now on.

        park_head_mm: where it lets go on the way back. quick_mm: length of the way inside the tube.
        Raises InputError or OSError where the machine does not answer.
        """

    def feels_carina(self) -> bool | None:
        """True while it feels the carina; None where the machine does not say."""
