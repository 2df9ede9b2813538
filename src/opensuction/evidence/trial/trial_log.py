"""The parts of a trial on disk: one that was cut off goes on where it was.

A file of lines: the first says which trial it is and of which sources, each other one holds a part.
A line is written when its part is there; one that was cut off in the middle is as if it were not.
"""

import hashlib
import json
from pathlib import Path
from typing import NamedTuple

from pydantic import ConfigDict, TypeAdapter, ValidationError

from opensuction import __version__
from opensuction.evidence.trial.part import PlayedPart
from opensuction.kernel.compiled import PACKAGE, sources_hash
from opensuction.kernel.errors import InputError
from opensuction.result.plain import to_json
from opensuction.result.trial_result import Trial

NAME = "trial-parts.jsonl"
JUDGING_ROOMS = ("oracle", "result", "session", "settings", "evidence")
"""Rooms that decide what a case is, beside the core."""


class Heading(NamedTuple):
    """Heading of a trial's log."""

    version: str
    """Of the software."""
    sources: str
    """Hash of all that decides what a case is."""
    trial: Trial
    cycles: int


class TrialLog(NamedTuple):
    """Content of a trial's log."""

    heading: Heading
    parts: dict[int, PlayedPart]
    """By the number of the machine."""
    size: int
    """Bytes that are whole."""


_HEADING = TypeAdapter(Heading)
_PART = TypeAdapter(PlayedPart, config=ConfigDict(ser_json_inf_nan="constants"))


def hash_sources() -> str:
    """Hash of the core's sources and of those that draw and judge; 16 hexadecimal digits."""
    digest = hashlib.sha256(sources_hash().encode())
    for room in JUDGING_ROOMS:
        for source in sorted((PACKAGE / room).rglob("*.py")):
            digest.update(str(source.relative_to(PACKAGE)).encode() + b"\0")
            digest.update(source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def make_heading(trial: Trial, cycles: int) -> Heading:
    """Heading of a trial by this software."""
    return Heading(__version__, hash_sources(), trial, cycles)


def begin(folder: Path, heading: Heading) -> None:
    """Begin a log in a folder; what another trial has left there is gone. May raise OSError."""
    _write(folder / NAME, json.dumps(to_json(heading)).encode() + b"\n", "wb")


def keep(folder: Path, part: PlayedPart) -> None:
    """Add a part that was played. May raise OSError; what was kept before stays."""
    _write(folder / NAME, _PART.dump_json(part) + b"\n", "ab")


def _write(file: Path, line: bytes, mode: str) -> None:
    try:
        with file.open(mode) as stream:
            stream.write(line)
    except OSError as error:
        # An error while writing has no name: it is about a file that was opened before.
        raise OSError(error.errno, error.strerror, str(file)) from None


def read(folder: Path) -> TrialLog:
    """Trial that a folder keeps. Raises InputError where there is none, or it is damaged."""
    file = folder / NAME
    if not file.is_file():
        raise InputError(
            f"--resume: {folder} holds no trial (no {NAME}); name the folder of one with --out, or "
            "leave --resume out"
        )
    lines = file.read_bytes().splitlines(keepends=True)
    if lines and not lines[-1].endswith(b"\n"):  # its writer was cut off
        lines.pop()
    heading, parts = None, {}
    for number, line in enumerate(lines, start=1):
        try:
            if heading is None:
                heading = _HEADING.validate_json(line)
            else:
                part = _PART.validate_json(line)
                parts[part.machine] = part
        except ValidationError:
            raise InputError(
                f"{file}, line {number}: this is no part of a trial; begin anew in another folder"
            ) from None
    if heading is None:
        raise InputError(f"{file}: the trial has not begun; leave --resume out and add --force")
    return TrialLog(heading, parts, sum(len(line) for line in lines))


def go_on(folder: Path, wanted: Heading) -> dict[int, PlayedPart]:
    """The parts of a trial that goes on, by machine; a line that was cut off is removed.

    Raises InputError where the folder holds another trial, or one by other software.
    """
    found = read(folder)
    for name in Trial._fields:
        old, new = (getattr(heading.trial, name) for heading in (found.heading, wanted))
        if old != new:
            _refuse(folder, name, old, new)
    if found.heading.cycles != wanted.cycles:
        _refuse(folder, "cycles", found.heading.cycles, wanted.cycles)
    if found.heading.sources != wanted.sources:
        raise InputError(
            f"--resume: the trial in {folder} was begun by other sources "
            f"(version {found.heading.version}, {found.heading.sources}; these are version "
            f"{wanted.version}, {wanted.sources}): its cycles would be other cycles; begin anew in "
            "another folder"
        )
    with (folder / NAME).open("rb+") as stream:
        stream.truncate(found.size)
    return found.parts


def _refuse(folder: Path, name: str, old: object, new: object) -> None:
    raise InputError(
        f"--resume: {folder} holds another trial: --{name} {old}, not {new}; leave --{name} out, "
        "or begin anew in another folder"
    )
