"""Settings files: TOML from disk to a plain dictionary.

A section of a file that changes some parameters of a documented table.

A value in a file, in the table's unit, is used as it is and not drawn. With a spread it is drawn
like the table's own: ``{ value = 65.0, spread = 5.0 }``. Parameters that the section leaves out
keep their value and spread.
"""

import re
import tomllib
from collections.abc import Mapping
from math import inf, isfinite
from os import PathLike
from pathlib import Path
from typing import Any, Final

from opensuction.settings.validation import trim
from opensuction.settings.wording import join_key, refuse, show, unknown
from opensuction.twin.parameter import SPREAD_LIMIT
from opensuction.twin.parameter_row import Parameter

Table = dict[str, Parameter]
PAIR = ("value", "spread")
"""Keys of a value that is drawn."""
LISTED = "docs/reference/parameters.md"
"""Where all parameters are: too many for a message."""


def change(table: Table, given: object, section: str, where: object) -> Table:
    """The table with the values of a section of a file.

    section: its name in messages, "" for the top of the file. where: the file.
    Raises InputError of one line for a name that the table lacks, and a value that is not a number
    in the plausible range, whatever the spread draws.
    """
    if not isinstance(given, Mapping):
        raise refuse(where, f"{section} is {show(given)}, not a section")
    found = dict(table)
    for name, value in given.items():
        key = join_key(section, name)
        if name not in table:
            raise refuse(where, unknown(f"key {key}", name, table, LISTED))
        found[name] = _entry(table[name], value, key, where)
    return found


def _entry(entry: Parameter, given: object, key: str, where: object) -> Parameter:
    spread = 0.0
    if isinstance(given, Mapping):
        for name in given:
            if name not in PAIR:
                raise refuse(where, unknown(f"key {join_key(key, name)}", name, PAIR))
        for name in PAIR:
            if name not in given:
                raise refuse(where, f"{join_key(key, name)} is missing; give {_wanted(entry)}")
        spread = _number(entry, given["spread"], f"{key}.spread", where)
        given = given["value"]
        if spread < 0.0:
            raise refuse(where, f"{key}.spread is {spread:g}, it should be 0 or more")
    value = _number(entry, given, key, where)
    reach = SPREAD_LIMIT * spread
    if not entry.low <= value - reach <= value + reach <= entry.high:
        drawn = f" +- {SPREAD_LIMIT:g} x {spread:g}" if spread else ""
        raise refuse(
            where, f"{key} is {value:g}{drawn} {_unit(entry)}".rstrip() + f"; give {_wanted(entry)}"
        )
    return entry._replace(value=value, spread=spread, source=f"[file] {where}")


def _number(entry: Parameter, given: object, key: str, where: object) -> float:
    if isinstance(given, bool) or not isinstance(given, int | float):
        raise refuse(where, f"{key} is {show(given)}, not a number; give {_wanted(entry)}")
    try:
        number = float(given)
    except OverflowError:  # an integer that no float holds
        number = inf
    if not isfinite(number):
        raise refuse(where, f"{key} is {show(given)}, not a finite number; give {_wanted(entry)}")
    return number


def _unit(entry: Parameter) -> str:
    return "" if entry.unit == "1" else entry.unit


def _wanted(entry: Parameter) -> str:
    return f"a number from {trim(entry.low)} to {trim(entry.high)} {_unit(entry)}".rstrip()


LARGEST_BYTES: Final = 1_000_000
"""A settings file is written by hand; anything larger is another kind of file."""

_END: Final = re.compile(r" \((at [^()]*)\)$")
"""Where the parser puts the place of an error in its message."""


def load_toml(path: str | PathLike[str]) -> dict[str, Any]:
    """Keys and sections of a TOML file in UTF-8 (with or without byte order mark).

    Raises `InputError` of one line for a file that is missing, a folder, not readable, too large,
    not UTF-8 or not TOML; the last two say in which line, TOML errors also in which column.
    """
    text = _text(Path(path))
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        place = _END.search(message)
        at = place[1].removeprefix("at ") if place else "in the file"
        raise refuse(path, f"{at}: not valid TOML: {_END.sub('', message)}") from None
    except RecursionError:
        raise refuse(path, "not valid TOML: lists or tables are nested too deeply") from None
    except ValueError as error:  # such as an integer with thousands of digits
        raise refuse(path, f"not valid TOML: {error}") from None


def _text(path: Path) -> str:
    """Text of a file; raises `InputError` where there is none."""
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_BYTES + 1)
    except FileNotFoundError:
        raise refuse(path, "no such file; give the path of a TOML file") from None
    except IsADirectoryError:
        raise refuse(path, "is a folder; give the path of a TOML file in it") from None
    except PermissionError:
        raise refuse(path, "may not be read; change its permissions") from None
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise refuse(path, f"cannot be read: {reason}") from None
    if len(content) > LARGEST_BYTES:
        raise refuse(path, f"is larger than {LARGEST_BYTES} bytes, so not a settings file")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise refuse(path, f"line {line}: not UTF-8 text; save the file as UTF-8") from None
