"""Settings files: TOML from disk to a plain dictionary."""

import re
import tomllib
from os import PathLike
from pathlib import Path
from typing import Any, Final

from opensuction.settings.wording import refuse

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
