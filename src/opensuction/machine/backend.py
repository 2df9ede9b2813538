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
from opensuction.machine.port import Capabilities, Port, SimulatedHand, TruthPort

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

    def capabilities_of(self, folder: Path) -> Capabilities:
        """Capabilities of the machine of a folder, attached to a controller or not.

        The same as its port's facts say. Raises InputError where there is none.
        """

    def hand_of(self, folder: Path) -> SimulatedHand | None:
        """The hand at the catheter head that software moves; None where a person's own does."""

    def truth_of(self, folder: Path) -> TruthPort | None:
        """Its truth, for a judge; None of a machine that cannot know it.

        Raises InputError where nothing plays.
        """


def name_backend(folder: Path, name: str) -> None:
    """Write down which backend the machine of a folder has."""
    private_file.write(folder / BACKEND, name)


def kind_of(folder: Path) -> str:
    """Name of the backend of a folder's machine.

    A folder that names none has a twin: older versions wrote no name, and had no other kind. Raises
    InputError for a name that cannot be read, or is not known.
    """
    path = folder / BACKEND
    try:
        name = path.read_text(encoding="ascii").strip()
    except FileNotFoundError:
        return TWIN
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path} does not name the kind of machine: {error}") from None
    if name not in MODULES:
        raise InputError(
            f"{path}: unknown kind of machine '{name[:40]}'; known: {', '.join(MODULES)}"
        )
    return name


def load(folder: Path) -> Backend:
    """The backend of a folder's machine. Raises InputError as `kind_of`."""
    return cast(Backend, import_module(MODULES[kind_of(folder)]))


def attach(folder: Path) -> Port:
    """Take hold of the machine of a folder, of whatever kind. Raises InputError as its backend."""
    return load(folder).attach(folder)


def open_truth(folder: Path) -> TruthPort:
    """The truth of a folder's machine. Raises InputError where nothing plays, or knows none."""
    found = load(folder).truth_of(folder)
    if found is None:
        raise InputError(
            f"the machine in {folder} ({kind_of(folder)}) tells no truth: only a twin is judged"
        )
    return found


def check_faults(folder: Path) -> None:
    """Refuse to put faults into a machine that takes none; raises InputError."""
    if not load(folder).capabilities_of(folder).faults:
        raise InputError(
            f"the machine in {folder} ({kind_of(folder)}) takes no faults on request: only a twin "
            "does"
        )
