"""The ``opensuction`` command: every error one plain line, every result readable or JSON."""

import errno
import io
import sys
from typing import Annotated

import typer

from opensuction import __version__
from opensuction.cli import entry, interruption
from opensuction.cli.command import (
    audit,
    benchmark,
    cache,
    calibrate,
    cycle,
    device,
    drives,
    identify,
    inject,
    leaderboard,
    predict,
    recording,
    reproduce,
    run,
    safety_case,
    serve,
    simulate,
    trial,
    users,
)
from opensuction.evidence.worker_pool import WorkerLostError
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import NOT_A_DEVICE
from opensuction.settings import wording

COMMANDS = (
    cycle.COMMAND,
    run.RUN,
    serve.COMMAND,
    run.ASK,
    reproduce.COMMAND,
    calibrate.COMMAND,
    benchmark.COMMAND,
    safety_case.COMMAND,
    trial.COMMAND,
    simulate.COMMAND,
    identify.IDENTIFY,
    identify.COMPARE,
    predict.COMMAND,
    leaderboard.COMMAND,
    recording.REPLAY,
    recording.REPORT,
    recording.EXPORT,
    inject.COMMAND,
    drives.COMMAND,
    device.COMMAND,
    audit.COMMAND,
    users.COMMAND,
    cache.COMMAND,
)
UNWRITABLE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.EACCES)
"""Failures of a disk, not of this program."""
UNNAMED = "the output, or the compiled core (see 'opensuction cache')"
"""What could not be written where the error does not say it."""

EXAMPLES = f"""\b
Examples:
  opensuction cycle                    an adult; the report is under runs/
  opensuction cycle --patient neonate  a neonate, by its age's protocol
  opensuction COMMAND --help           every option, with examples

\b
Environment:
  OPENSUCTION_CACHE_DIR                where the compiled core is kept
  OPENSUCTION_DATABASE                 where records are kept

{entry.IN_FULL}"""

app = typer.Typer(
    name="opensuction",
    help="Automated tracheal suctioning: controller and digital twin. "
    f"{NOT_A_DEVICE} Every performance claim is in-silico.",
    epilog=EXAMPLES,
    invoke_without_command=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"opensuction {__version__}")
        raise typer.Exit


@app.callback()
def main_options(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Options of every command."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


for command in COMMANDS:
    entry.add(app, command)


def _explain(error: typer.TyperException) -> str:
    """Describe the error in the command line, and name the command that shows its help."""
    words = error.format_message().rstrip(".")
    alike = getattr(error, "possibilities", None)
    if alike:
        words = f"{error.message.rstrip('.')}. Did you mean {wording.one_of(alike)}?"
    context = getattr(error, "ctx", None)
    path = "opensuction" if context is None else context.command_path
    return f"{words}{' See' if words.endswith('?') else '; see'} '{path} --help'"


def _carry_out() -> int:
    """Carry out the command line; returns the exit status."""
    try:
        code = app(prog_name="opensuction", standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    except SystemExit as leaving:
        if isinstance(leaving.__context__, BrokenPipeError):  # typer says nothing of it
            raise leaving.__context__ from None
        code = leaving.code
    except InputError as refused:
        return _refuse(str(refused))
    except typer.TyperException as misused:
        return _refuse(_explain(misused))
    except WorkerLostError as lost:
        return _end(f"{lost}; {_say_what_is_left(lost)}", entry.FAILED)
    return code if isinstance(code, int) else entry.DONE


def _refuse(message: str) -> int:
    return _end(message, entry.BAD_INPUT)


def _end(message: str, status: int) -> int:
    line = wording.one_line(" ".join(message.split()))
    print(f"opensuction: {line}", file=sys.stderr)  # noqa: T201
    return status


def main() -> None:
    """Entry point of the console script; never ends in a traceback for what a person did."""
    _let_streams_escape()
    try:
        with interruption.hear():
            code = _carry_out()
    except interruption.Stopped as stopped:
        status = entry.SIGNALLED + stopped.number
        interruption.leave(
            status, f"{interruption.describe(stopped)}; {_say_what_is_left(stopped)}"
        )
    except BrokenPipeError as closed:
        line = f"nobody reads the output any more; {_say_what_is_left(closed)}"
        interruption.leave(entry.PIPE_CLOSED, line)
    except OSError as failed:
        if failed.errno not in UNWRITABLE:
            raise
        where = f"{failed.filename or UNNAMED}: "
        line = f"{where}{(failed.strerror or str(failed)).lower()}; {_say_what_is_left(failed)}"
        interruption.leave(entry.NOT_WRITTEN, line)
    sys.exit(code)


def _let_streams_escape() -> None:
    """A letter that a terminal or a file does not have is no reason to end."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _say_what_is_left(ending: BaseException) -> str:
    """Say what a command that ended early leaves."""
    notes: list[str] = getattr(ending, "__notes__", ["nothing was written"])
    return notes[0]


if __name__ == "__main__":
    main()
