"""Identity of machine, catheter, protocol and patient, for recordings and records."""

import json
from pathlib import Path
from typing import Any, NamedTuple

from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.records.entry import Catheter, Machine, SettingsFile
from opensuction.runtime.paths import ABOUT

NOWHERE = (0, 0)
"""Identity of a file that is not there."""


class About(NamedTuple):
    """Facts known before a cycle."""

    machine: Machine
    catheter: Catheter
    protocol: SettingsFile
    approach: str
    patient: str | None
    """Pseudonym; None on a bench."""
    parameter_file: SettingsFile | None
    database: str | None
    """Where it is put on record; None: nowhere."""
    heading: dict[str, str]
    """What else recordings say, by name: seed, notice."""


def write(folder: Path, about: About, name: str = ABOUT) -> None:
    """Into the machine's folder, whole or not at all. name: of the file."""
    told: dict[str, Any] = about._asdict()
    for field, value in told.items():
        if hasattr(value, "_asdict"):
            told[field] = value._asdict()
    private_file.write(folder / name, json.dumps(told))


def identity(folder: Path) -> tuple[int, int]:
    """Inode and time of change of the file with the machine's identity; `NOWHERE` for none."""
    try:
        found = (folder / ABOUT).stat()
    except OSError:
        return NOWHERE
    return found.st_ino, found.st_mtime_ns


def read(folder: Path) -> About:
    """From the machine's folder. Raises InputError where it is not there or not whole."""
    try:
        told = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
        parameters = told.pop("parameter_file")
        return About(
            machine=Machine(**told.pop("machine")),
            catheter=Catheter(**told.pop("catheter")),
            protocol=SettingsFile(**told.pop("protocol")),
            parameter_file=None if parameters is None else SettingsFile(**parameters),
            **told,
        )
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise InputError(f"{folder / ABOUT} does not say whose machine it is: {error}") from None
