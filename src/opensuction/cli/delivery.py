"""From the work of a command to its folder, its JSON object or summary, and its exit status."""

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from opensuction.cli import exit_status, output_folder
from opensuction.cli.interruption import Stopped
from opensuction.result.plain import Json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller


class OutputChoice(NamedTuple):
    """Options for the place and form of the results."""

    out: Path | None = None
    force: bool = False
    as_json: bool = False


class CommandResult(NamedTuple):
    """Results of a command."""

    data: Json
    """The one object of ``--json``."""
    files: Mapping[str, str | bytes]
    """By their names in the folder."""
    summarise: "Callable[[Console, Path], None]"
    """Prints it for a person; takes the folder that the files are in."""
    is_good: bool = True
    """Whether the exit status is 0."""
    stale: tuple[str, ...] = ()
    """Files that an earlier run may have left in the folder and that would now tell a lie."""


def to_text(data: Json) -> str:
    """A JSON object as its file holds it."""
    return json.dumps(data, indent=2) + "\n"


def show(as_json: bool, data: Json, summarise: "Callable[..., None]") -> None:
    """Print the one object of ``--json``, or the summary for a person."""
    from opensuction.cli.progress import PlainConsole

    try:
        if as_json:
            print(json.dumps(data))  # noqa: T201 - the result
        else:
            summarise(PlainConsole())
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(error.errno, error.strerror, "stdout") from None


def deliver(
    output: OutputChoice,
    name: int | str,
    work: "Callable[[ProgressTeller, Path], CommandResult]",
    doing: str | None = None,
    writes: bool = False,
) -> int:
    """Carry out the work of a command; returns the exit status.

    name: of the folder where none was named. work: takes the folder in which its files will be.
    writes: it writes large files itself, and takes a folder that becomes that one.
    doing: said while all of the work is done in the background; None: the work waits by itself.
    Raises InputError for a folder that cannot be written and for what the work refuses.
    """
    from opensuction.cli.progress import ProgressTeller

    progress = ProgressTeller()
    with (
        output_folder.reserve(output.out, name) as folder,
        output_folder.stage(folder, output.force) as staging,
    ):
        place = staging if writes else folder
        if doing is None:
            done = work(progress, place)
        else:
            done = progress.wait(lambda: work(progress, place), doing)
        output_folder.write(staging, done.files)
    for stale in done.stale:
        (folder / stale).unlink(missing_ok=True)
    try:
        show(output.as_json, done.data, lambda console: done.summarise(console, folder))
    except (OSError, Stopped) as ending:
        ending.add_note(f"the results are in {folder}")
        raise
    return exit_status.DONE if done.is_good else exit_status.FAILED


def delivering(
    name: str, doing: str, work: "Callable[[Any, ProgressTeller, Path], CommandResult]"
) -> Callable[[Any], int]:
    """Function that carries a command out in the background and delivers its results.

    work: takes the command's options first; their field ``results`` says where to deliver.
    """
    return lambda options: deliver(
        options.results, name, lambda progress, folder: work(options, progress, folder), doing
    )
