"""A machine's processes: started in the folder that they share, and found there.

They belong to no terminal and to no parent: whoever started them may die, and they go on.

Requests to the control loop, and its answers among the loop's events: one client for all.
"""

from collections.abc import Callable
from pathlib import Path

from opensuction.controller import configuration
from opensuction.controller.configuration import Configuration
from opensuction.host.host import Child, Clock, Host, Steps, after, finish
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.liveness import Heartbeat, Process
from opensuction.ipc.mailbox import PATIENCE_S, Sender
from opensuction.ipc.ring import EventReader, RingReader
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.records.database import utc_time
from opensuction.runtime.control_process import MACHINES_OWN
from opensuction.runtime.machine_folder import ASK, CONFIGURATION, EVENTS, RING

PRESSED = "pressed"
"""Verdict: the button went down."""
CONTROLLER_REQUEST_LOOKS_S = 0.002
SENTENCES = {
    "twice": "this was asked for already; look what came of it",
    "not at rest": "the machine is not at rest: wait until it is parked",
    "nobody": "say who asks",
    "too many": "others ask at the same time: try again",
    "stale": "it came too late to mean the machine as it is now: try again",
    "out of order": "something you asked for later was done first: try again",
}
"""Verdicts that are no consent, in words."""


def send(folder: Path, what: str, who: str, key: str, patience_s: float = PATIENCE_S) -> None:
    """Send a request to the controller of a machine's folder.

    what: a button or another of `ipc.mailbox.ASKS`. key: no other request has had it. patience_s:
    how long to wait for room. Raises InputError where no controller takes it.
    """
    sender = Sender(folder / ASK, who, patience_s)
    try:
        sender.ask(what, key, utc_time.now().isoformat())
    finally:
        sender.close()


def ask(folder: Path, what: str, who: str, key: str, answers_s: float) -> str | None:
    """The loop's verdict on a request; None where it has not answered within a time.

    Raises InputError and OSError where no controller takes it.
    """
    events = EventReader(folder / EVENTS)
    events.read()
    send(folder, what, who, key)
    clock = THIS_COMPUTER.clock
    ends_ns = after(clock, answers_s)
    while clock.monotonic_ns() < ends_ns:
        for one in events.read()[0]:
            if one.fields.get("key") == key:
                return str(one.fields["verdict"])
        clock.sleep_until(after(clock, CONTROLLER_REQUEST_LOOKS_S))
    return None


def explain(verdict: str) -> str:
    """A verdict that is no consent, in words."""
    reason = verdict.removeprefix("refused: ")
    return SENTENCES.get(verdict, f"the controller refused: {reason}")


BEGINS_S = 180.0
"""Longest time until a process does its work: it may have to compile first."""
LOOKS_S = 0.005
CONTROL, RECORDER, SUPERVISOR, CONSOLE = (
    "opensuction.runtime.control_process",
    "opensuction.runtime.recorder_process",
    "opensuction.runtime.supervisor",
    "opensuction.console.console_process",
)
"""Modules of the processes. The console's room lies above this one, which only starts it."""


def configure(folder: Path, chosen: Configuration) -> None:
    """Write down what the controller of a folder is set to."""
    text = configuration.to_json(chosen)
    private_file.write(folder / CONFIGURATION, text)


def spawn(folder: Path, module: str, *arguments: str, host: Host = THIS_COMPUTER) -> Child:
    """Start a module as a process; what it says goes into its log in the folder."""
    return host.processes.spawn(module, (str(folder), *arguments), log_of(folder, module))


def log_of(folder: Path, module: str) -> Path:
    """Log file of a process."""
    return folder / f"{module.rpartition('.')[2]}.log"


def last_words(folder: Path, module: str) -> str:
    """Last line in the log of a process; empty where there is none."""
    try:
        lines = log_of(folder, module).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return ""
    return lines[-1].removeprefix("opensuction: ") if lines else ""


def start_control(
    folder: Path, period_ns: int = MACHINES_OWN, module: str = CONTROL, host: Host = THIS_COMPUTER
) -> Child:
    """The control process on the machine of a folder; returns once it ticks.

    module: that is run; another one in its place takes the same arguments. Raises InputError where
    it does not tick.
    """
    ring = folder / RING
    before = _inode(ring)
    process = spawn(folder, module, str(period_ns), host=host)
    return _wait(
        folder, module, process, lambda: _inode(ring) not in (0, before) and _has_rows(ring), host
    )


def start_recorder(folder: Path, out: Path, host: Host = THIS_COMPUTER) -> Child:
    """The recorder of a folder's controller; returns once it has given a sign of life.

    Raises InputError where it does not.
    """
    clock = host.clock
    heartbeat, before_ns = Heartbeat(folder, host), clock.monotonic_ns()
    process = spawn(folder, RECORDER, str(out), host=host)
    return _wait(
        folder,
        RECORDER,
        process,
        lambda: heartbeat.age_s(Process.RECORDER) < (clock.monotonic_ns() - before_ns) * 1e-9,
        host,
    )


def _wait(
    folder: Path, module: str, process: Child, works: Callable[[], bool], host: Host
) -> Child:
    if finish(_starting(process, works, host.clock), host.clock):
        return process
    process.kill()
    process.wait()
    words = last_words(folder, module) or "it took too long"
    title = module.rpartition(".")[2].replace("_", " ")
    raise InputError(f"the {title} does not run: {words}")


def _starting(process: Child, works: Callable[[], bool], clock: Clock) -> Steps[bool]:
    """Steps until a process works; false where it does not."""
    ends_ns = after(clock, BEGINS_S)
    while clock.monotonic_ns() < ends_ns and process.poll() is None:
        if works():
            return True
        yield after(clock, LOOKS_S)
    return False


def _has_rows(path: Path) -> bool:
    return RingReader(path).newest() > 0


def _inode(path: Path) -> int:
    """Inode of a file, 0 of none. A controller's ring is a new one."""
    try:
        return path.stat().st_ino
    except OSError:
        return 0
