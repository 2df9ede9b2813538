"""Backends: the kinds of machines that a controller can be attached to, chosen by name.

Whoever prepares a machine's folder writes down its kind there (`name_backend`); the controller, the
console and whoever else works on that folder load the backend by that name when they need it. So
nothing of theirs is bound to a kind of machine, and none is loaded that is not there.
"""

from importlib import import_module
from pathlib import Path
from typing import Final, Protocol, cast

from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.machine.port import Port, SimulatedHand

BACKEND: Final = "machine.kind"
"""File of a machine's folder that names its backend."""
TWIN: Final = "twin"
MODULES: Final = {TWIN: "opensuction.machine.twin.twin_machine"}
"""Module of each backend, which is a `Backend`."""


class Backend(Protocol):
    """One kind of machine."""

    def attach(self, folder: Path) -> Port:
        """Take hold of the machine of a folder.

        Raises InputError where there is none, or another controller has it.
        """

    def hand_of(self, folder: Path) -> SimulatedHand | None:
        """The hand at the catheter head that software moves; None where a person's own does."""


def name_backend(folder: Path, name: str) -> None:
    """Write down which backend the machine of a folder has."""
    private_file.write(folder / BACKEND, name)


def load(folder: Path) -> Backend:
    """The backend of a folder's machine. Raises InputError where none or no known one is named."""
    try:
        name = (folder / BACKEND).read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError):
        raise InputError(f"no machine in {folder}: no {BACKEND} names its kind") from None
    if name not in MODULES:
        raise InputError(
            f"{folder / BACKEND}: unknown kind of machine '{name[:40]}'; known: "
            f"{', '.join(MODULES)}"
        )
    return cast(Backend, import_module(MODULES[name]))


def attach(folder: Path) -> Port:
    """Take hold of the machine of a folder, of whatever kind. Raises InputError as its backend."""
    return load(folder).attach(folder)
