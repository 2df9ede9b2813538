"""``cache``: where the compiled core is kept, how much of it, and how to be rid of it."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli.delivery import show
from opensuction.cli.entry import Command
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from rich.console import Console

MB = 1e6


class CacheOptions(NamedTuple):
    """Options of ``cache``."""

    clear: bool = False
    as_json: bool = False


class CacheVersion(NamedTuple):
    """Machine code of a version of the core."""

    folder: str
    size_bytes: int
    is_current: bool
    """It is this version's."""


class CacheResult(NamedTuple):
    """Machine code that is kept, and whether it has been removed."""

    folder: str
    size_bytes: int
    """Of all versions, before they were removed."""
    versions: tuple[CacheVersion, ...]
    cleared: bool


def run(options: CacheOptions) -> int:
    """Show or clear the cache; returns the exit status. Raises OSError where it stays."""
    # The import makes the folder of this version.
    from opensuction.kernel import compiled

    versions = tuple(
        CacheVersion(str(folder), _size_bytes(folder), folder == compiled.CACHE_FOLDER)
        for folder in compiled.kept_caches()
    )
    found = CacheResult(
        folder=str(compiled.CACHE_FOLDER.parent),
        size_bytes=sum(version.size_bytes for version in versions),
        versions=versions,
        cleared=options.clear,
    )
    if options.clear:
        compiled.clear_cache()
    show(options.as_json, to_json(found), lambda console: _summarise(console, found))
    return 0


def _size_bytes(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def _summarise(console: "Console", found: CacheResult) -> None:
    console.print(f"Compiled core: {found.folder}", soft_wrap=True)
    for version in found.versions:
        name, size_mb = Path(version.folder).name, version.size_bytes / MB
        note = "  this version" if version.is_current else ""
        console.print(f"  {name} {size_mb:8.1f} MB{note}")
    size_mb = found.size_bytes / MB
    if found.cleared:
        console.print(f"Removed {size_mb:.1f} MB: the next command compiles anew.")
    else:
        console.print(f"{size_mb:.1f} MB. OPENSUCTION_CACHE_DIR=DIR keeps it elsewhere.")


COMMAND = Command(
    name="cache",
    options=CacheOptions,
    run=run,
    sentence="Where the compiled core is kept and how much of it; --clear removes it.",
    details="The first command of a version compiles the control core and keeps the machine code "
    "under the user's cache folder, or under the folder that the environment variable "
    "OPENSUCTION_CACHE_DIR names. A few versions are kept, older ones removed by themselves.",
    examples="""\b
Examples:
  opensuction cache          folder and size
  opensuction cache --clear  remove it; compiled anew when needed
  opensuction cache --json | jq .size_bytes
  OPENSUCTION_CACHE_DIR=/tmp/core opensuction cycle""",
    ends="0 done",
)
