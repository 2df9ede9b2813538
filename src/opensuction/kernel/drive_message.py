"""Message of a controller to the drives and the bedside annunciator, once in each tick."""

from typing import NamedTuple

from opensuction.kernel.codegen import row
from opensuction.kernel.commands import Commands


class DriveMessage(NamedTuple):
    """Commands of a tick, and what people shall be told with them."""

    commands: Commands
    wanted: int
    """Mask of the conditions that people shall be told."""
    reset: bool
    """A person pressed the button."""
    released: bool
    """The controller has just started: drives that act on their own obey it again."""


MESSAGE_COLUMNS = row.columns(DriveMessage)
"""Columns of the row that passes."""
