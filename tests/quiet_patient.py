"""Patients who lie still: for tests that ask what suction and faults do, and not what coughs do."""

import tempfile
from functools import cache
from pathlib import Path

from opensuction.twin.behaviour.behaviour_parameter import SWITCH


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="quiet-patients-")


def quiet(preset: str) -> str:
    """A patient file, as `RigChoice.patient` takes it: the preset, drawn as usual, but quiet."""
    path = Path(_folder().name) / f"{preset}.toml"
    path.write_text(f'preset = "{preset}"\n{SWITCH} = 0\n')
    return str(path)
