"""``serve``: a machine in real time that waits for what people ask of it, with its console."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import exit_status
from opensuction.cli.command import run_help, serve_help
from opensuction.cli.command.run import MachineOptions, machine_of, supervise
from opensuction.cli.entry import Command
from opensuction.cli.interruption import Stopped, describe

if TYPE_CHECKING:
    from opensuction.cli.progress import ProgressTeller
    from opensuction.session.running.console_settings import ConsoleSettings


class ServeOptions(NamedTuple):
    """What ``serve`` takes."""

    machine: MachineOptions = MachineOptions()
    host: str = "127.0.0.1"
    port: int = 8080
    certificate: Path | None = None
    key: Path | None = None


def serve(options: ServeOptions) -> int:
    """Carry out ``serve``; returns the exit status. Raises InputError for bad input."""
    from opensuction.session.running import console_settings, machine

    console_settings.check(*options[1:])
    folder = machine.check_free(options.machine.name)
    console_settings.find_place(folder, options.host, options.port)
    with machine_of(options.machine) as (running, out, progress):
        settings = _settings(options, out)
        console_settings.write(running.folder, settings)
        try:
            done = supervise(running, out, None, progress, lambda: _greet(settings, progress))
        except Stopped as stopped:
            progress.tell(f"{describe(stopped)}: ended in order")
            return exit_status.DONE
    return exit_status.DONE if done.ended else exit_status.FAILED


def _settings(options: ServeOptions, out: Path) -> "ConsoleSettings":
    from opensuction.session.running.console_settings import ConsoleSettings

    database = options.machine.database
    is_file = database is not None and "://" not in database
    return ConsoleSettings(
        host=options.host,
        port=options.port,
        database=str(Path(database).absolute()) if is_file and database else database,
        recordings=str(out.absolute()),
        certificate=None if options.certificate is None else str(options.certificate.absolute()),
        key=None if options.key is None else str(options.key.absolute()),
    )


def _greet(settings: "ConsoleSettings", progress: "ProgressTeller") -> None:
    """Say where the console is, and to the first who comes how to get in."""
    from opensuction.session.running import console_settings

    made = console_settings.first_password(settings.database)
    if made is not None:
        progress.tell(
            f"Nobody has signed in yet: sign in as {made.account} with the one-time password "
            f"{made.one_time_password}, until {made.expires_at:%Y-%m-%d %H:%M} UTC"
        )
    progress.tell(f"Console: {settings.url}")
    progress.tell(run_help.NOTICE)


COMMAND = Command(
    name="serve",
    options=ServeOptions,
    run=serve,
    sentence="A machine in real time that waits for what people ask of it at its console.",
    details=serve_help.SERVE,
    examples=serve_help.SERVE_EXAMPLES,
    ends="0 ended in order, 1 not",
)
