"""``serve``: a machine in real time that waits for what people ask of it, with its console.

Help text of ``serve``.
"""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import entry
from opensuction.cli.command import run
from opensuction.cli.command.run import MachineOptions, machine_of, supervise
from opensuction.cli.entry import Command
from opensuction.cli.interruption import Stopped, describe

if TYPE_CHECKING:
    from opensuction.accounts.directory import NewPassword
    from opensuction.session.running.console_settings import ConsoleSettings


SERVE = (
    "As run, but nothing starts by itself: people ask, at the bedside console in a browser or with "
    "opensuction ask from another terminal. The console is a process of its own; its address is "
    "printed, and at the first start the administrator's one-time password, which makes the other "
    "accounts. Everybody may look and stop, without signing in; a clinician starts; an engineer "
    "changes limits and calibrates. It is reached from this computer alone, unless --host says "
    "otherwise, and then only with a certificate. When the console dies the machine goes on, says "
    "so, and the console is started anew. Ends with Ctrl-C or SIGTERM, the catheter first. Linux "
    "only."
)
SERVE_EXAMPLES = """\b
Examples:
  opensuction serve --patient neonate            http://127.0.0.1:8080/
  opensuction serve --port 8081 --name ward-3    a second machine beside it
  opensuction ask abort                          stop, from another terminal
  opensuction users reset-password admin         the first password is lost

\b
From another computer, with a certificate that its browser trusts; for a try:
  openssl req -x509 -newkey rsa:3072 -nodes -days 30 -keyout key.pem \\
    -out cert.pem -subj /CN=ward -addext subjectAltName=DNS:$(hostname)
  opensuction serve --host 0.0.0.0 --certificate cert.pem --key key.pem

\b
Files:
  /dev/shm/opensuction-UID/NAME   what the processes share, in memory; and
                                  console.log, what the console refused
  runs/TIME-NAME/*.mcap           a recording for each cycle"""


CONSOLE = "console"
"""Title of its process."""


class ServeOptions(NamedTuple):
    """Options of ``serve``."""

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
        greeting = Greeting(settings, progress.tell)
        try:
            done = supervise(running, out, None, progress, greeting.look)
        except Stopped as stopped:
            lost = machine.find(running.folder)
            progress.tell(f"{describe(stopped)}: {lost.ending if lost else 'ended in order'}")
            return entry.FAILED if lost else entry.DONE
    return entry.DONE if done.ended else entry.FAILED


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


class Greeting:
    """Says where the console is as soon as it answers, and to the first who comes how to get in.

    The one-time password is made in a thread of its own: its hash takes long on purpose, and who
    looks after the machine gives a sign of life meanwhile.
    """

    def __init__(self, settings: "ConsoleSettings", tell: Callable[[str], None]) -> None:
        """tell: takes a line."""
        self._settings, self._tell = settings, tell
        self.password: Future[NewPassword | None] = Future()
        """Of the administrator of a new site; None where somebody has signed in."""
        self._is_said = self._is_awaited = False
        threading.Thread(target=self._make_password, daemon=True, name="first password").start()

    def _make_password(self) -> None:
        from opensuction.session.running import console_settings

        try:
            self.password.set_result(console_settings.first_password(self._settings.database))
        except BaseException as failure:
            self.password.set_exception(failure)

    def look(self, starting: tuple[str, ...]) -> None:
        """Say what is due; to be called now and then. starting: titles of what does not work yet.

        Raises what kept the password from being made.
        """
        if not self._is_said:
            if CONSOLE not in starting and self.password.done():
                self._say(self.password.result(), starting)
        elif self._is_awaited and not starting:
            self._is_awaited = False
            self._tell("Everything works now")

    def _say(self, made: "NewPassword | None", starting: tuple[str, ...]) -> None:
        if made is not None:
            self._tell(
                f"Nobody has signed in yet: sign in as {made.account} with the one-time password "
                f"{made.one_time_password}, until {made.expires_at:%Y-%m-%d %H:%M} UTC"
            )
        self._tell(f"Console: {self._settings.url}")
        self._tell(run.NOTICE)
        if starting:
            self._tell(f"Still starting: {', '.join(map(_title, starting))}")
        self._is_said, self._is_awaited = True, bool(starting)


def _title(process: str) -> str:
    """As people call it."""
    return "controller" if process == "control" else process


COMMAND = Command(
    name="serve",
    options=ServeOptions,
    run=serve,
    sentence="A machine in real time that waits for what people ask of it at its console.",
    details=SERVE,
    examples=SERVE_EXAMPLES,
    ends="0 ended in order, 1 not",
)
