"""A command of ``opensuction``: a record of what a person said in, an exit status out.

Exit statuses of ``opensuction``, and their description in the help.
"""

import signal
from collections.abc import Callable, Iterator
from inspect import Parameter, Signature
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import typer

from opensuction.cli.option import OF_A_FILE, OPTIONS

DONE = 0
FAILED = 1
"""Of a run that failed or was aborted; each command's help says what that is for it."""
BAD_INPUT = 2
NOT_WRITTEN = 74
"""A file, the output or the cache could not be written; ``EX_IOERR`` of ``sysexits.h``."""
SIGNALLED = 128
"""Plus the number of the signal, as shells say it."""
HUNG_UP = SIGNALLED + 1
"""As if the signal ``SIGHUP`` (1 wherever there is one) had ended it."""
PIPE_CLOSED = SIGNALLED + 13
"""As if the signal ``SIGPIPE`` (13 wherever there is one) had ended it."""
INTERRUPTED = SIGNALLED + signal.SIGINT
TERMINATED = SIGNALLED + signal.SIGTERM

EVERY = f"{BAD_INPUT} bad input, {NOT_WRITTEN} not written (disk full), {INTERRUPTED} interrupted"
"""What can happen to every command."""

IN_FULL = f"""\b
Exit status of every command:
  {DONE:3}  done
  {FAILED:3}  failed or aborted: the command's own help says what that is
  {BAD_INPUT:3}  bad input: one line says what, where, and what would be right
  {NOT_WRITTEN:3}  something could not be written, such as on a full disk
  {HUNG_UP:3}  the terminal was closed
  {INTERRUPTED:3}  interrupted (Ctrl-C)
  {PIPE_CLOSED:3}  nobody reads the output any more (a closed pipe)
  {TERMINATED:3}  terminated

From {BAD_INPUT} on stdout has no JSON; nothing is ever left half-written."""


class Command(NamedTuple):
    """Entry of a command, by which the application offers it."""

    name: str
    options: type[tuple[Any, ...]]
    """Named tuple that the command line fills; a field that is one itself stands for its fields."""
    run: Callable[[Any], int]
    """Carries it out on such a record; returns the exit status, raises InputError for bad input."""
    sentence: str
    """What it does, whole in the list of commands."""
    details: str
    examples: str
    ends: str
    """What the exit statuses 0 and 1 mean."""


def add(app: typer.Typer, command: Command) -> None:
    """Let an application take a command; its options are those of `option.OPTIONS`."""

    def call(**given: Any) -> int:
        return command.run(_fill(command.options, given))

    parameters = list(_list_parameters(command.options))
    # What typer reads; each option is written once, in its table.
    call.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {one.name: one.annotation for one in parameters}
    app.command(
        name=command.name,
        help=f"{command.sentence}\n\n{command.details}",
        short_help=command.sentence,
        epilog=f"{command.examples}\n\nExit status: {command.ends}, {EVERY}.",
    )(call)


def _is_record(candidate: Any) -> bool:
    return isinstance(candidate, type) and hasattr(candidate, "_field_defaults")


def _is_repeated(candidate: Any) -> bool:
    """True for an option that may be given many times."""
    return get_origin(candidate) is tuple and get_args(candidate)[1:] == (Ellipsis,)


def _list_parameters(record: Any) -> Iterator[Parameter]:
    """Parameters of a command, in the order of the record's fields."""
    for name, hint in get_type_hints(record).items():
        if _is_record(hint):
            yield from _list_parameters(hint)
            continue
        kind, default = hint, record._field_defaults.get(name, Parameter.empty)
        if _is_repeated(hint):
            kind = list[get_args(hint)[0]]  # type: ignore[misc]  # what typer takes for it
            if default is not Parameter.empty:
                kind, default = kind | None, None
        yield Parameter(
            name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, OPTIONS[name]]
        )


def _fill(record: Any, given: dict[str, Any]) -> Any:
    """The record with what was given."""
    values = {}
    for name, kind in get_type_hints(record).items():
        if _is_record(kind):
            values[name] = _fill(kind, given)
        else:
            values[name] = tuple(given[name] or ()) if _is_repeated(kind) else given[name]
        if name in OF_A_FILE:
            values[name] = _decode(values[name])
    return record(**values)


def _decode(given: Any) -> Any:
    """Words as UTF-8 where the locale took their letters for single bytes, as "C" may."""
    if isinstance(given, tuple):
        return tuple(map(_decode, given))
    if not isinstance(given, str):
        return given
    return given.encode("utf-8", "surrogateescape").decode("utf-8", "surrogateescape")
