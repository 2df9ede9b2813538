"""The control loop as a process: ``python -m opensuction.runtime.control_process DIR``.

In the folder lie ``configuration.json`` (what the controller is set to) and the machine's own
files; it writes ``control.ring`` (`loop.ROW_COLUMNS`), ``control.events`` and ``heartbeat``, and
listens at ``control.ask``. When it has crashed before, its last row tells what it must not forget:
how often the patient was suctioned and how old the catheter is. Where the catheter is the head's
sensors tell; if it is in, it comes out first, and the machine waits for a person.
"""

import math
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from opensuction import __version__
from opensuction.controller import configuration, controller
from opensuction.controller.configuration import Configuration
from opensuction.controller.real_time_call import RealTimeCall
from opensuction.controller.record import State
from opensuction.host import this_computer
from opensuction.host.host import NS_PER_S, Allowed, Clock, Host, Steps, after
from opensuction.ipc.deadline_scheduler import DeadlineScheduler, Pacing
from opensuction.ipc.liveness import Heartbeat, Process, ProcessLock
from opensuction.ipc.mailbox import Mailbox
from opensuction.ipc.ring import EventWriter, RingWriter
from opensuction.kernel.codegen import plain_row, row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Readings
from opensuction.kernel.record import Array
from opensuction.machine import port as ports
from opensuction.machine.port import DESCRIPTION, WORDS, Capabilities, Port, describe
from opensuction.procedure.cycle.interlocks import NEW_CATHETER_S
from opensuction.runtime import controller_memory
from opensuction.runtime.controller_memory import Before
from opensuction.runtime.loop import (
    ROW_COLUMNS,
    SET,
    STARTED_FROM,
    Around,
    ControlLoop,
)
from opensuction.runtime.machine_folder import (
    ABOUT,
    ASK,
    BASIS,
    CONFIGURATION,
    CONTROLS,
    EVENTS,
    EVENTS_BEFORE,
    RING,
    RING_BEFORE,
    SLOTS_S,
)
from opensuction.safety.head import head_vote

PERIOD_NS = 1_000_000
"""Of a twin."""
MACHINES_OWN = 0
"""In place of a period: the one that the machine has."""
READINGS = row.columns(Readings)
AT_ONCE = 2
"""Told so often to end it ends, wherever the catheter is: the drives bring it out."""
LOOKS_S = 0.001
"""How often the machine's first readings are looked for."""
RUN_BYTES = 4
"""Of chance in the name of a run: two of one second have different ones."""


def _first_readings(port: Port, clock: Clock) -> Steps[Readings]:
    """First readings of the machine. Raises InputError where it gives none."""
    found: Array = np.zeros(len(READINGS))
    ends_ns = after(clock, port.facts.answers_s)
    while not port.read(found):
        if clock.monotonic_ns() > ends_ns:
            raise InputError(f"the machine '{port.facts.name}' gives no readings")
        yield after(clock, LOOKS_S)
    return plain_row.unpack(Readings, found)


def begin(chosen: Configuration, port: Port, before: Before | None, clock: Clock) -> Steps[State]:
    """State of a controller that starts now."""
    head_mm = head_vote.first_mm((yield from _first_readings(port, clock)))
    if before is None:
        return controller.start(chosen.settings, head_mm, NEW_CATHETER_S)
    return controller.restart(chosen.settings, head_mm, before.kept, before.off_s, before.phase)


def say_lacking(machine: Capabilities, chosen: Configuration) -> str:
    """Name what a machine lacks, and which of it the settings go by; empty for nothing.

    The controller starts all the same: what does not come is alarmed, as where it was lost.
    """
    limits = chosen.settings.limits
    expected = {
        WORDS["monitor"]: limits.patient.monitored,
        WORDS["mouth_barrier"]: math.isfinite(limits.mouth_mm),
    }
    return ", ".join(
        f"{one} (the settings go by it)" if expected.get(one) else one for one in machine.lacking
    )


class Setting:
    """Other settings for a controller that runs: files that whoever asks for them has written."""

    def __init__(self, folder: Path, call: RealTimeCall, chosen: Configuration) -> None:
        """chosen: what the controller goes by now; to read it once more warms up what reads."""
        self._folder, self._call = folder, call
        configuration.from_json(configuration.to_json(chosen))

    def set(self, key: str, readings: Array) -> Iterator[str]:
        """Go by those of a key, a piece of the work at a time; the last one says what became of it.

        Each piece takes less than a tick or two, of a machine at rest.
        """
        file = self._folder / settings_file(key)
        try:
            text = file.read_text(encoding="utf-8")
            yield ""
            chosen = configuration.from_json(text)
            yield ""
            head_mm = head_vote.first_mm(plain_row.unpack(Readings, readings))
            kept = self._call.state.core.upkeep
            state = controller.restart(chosen.settings, head_mm, kept, 0.0)
            yield ""
            self._call.configure(*chosen, state)
            file.replace(self._folder / CONFIGURATION)
            for name in TOGETHER:
                told = self._folder / beside(name, key)
                if told.exists():
                    told.replace(self._folder / name)
            yield SET
        except InputError as error:
            yield f"refused: {error}"
        except (OSError, UnicodeDecodeError):
            yield "refused: no settings of this key"


TOGETHER = (ABOUT, BASIS)
"""What goes with settings: another one of it takes the place of the present one in the same tick,
so that nothing is ever recorded under the name of settings that were not in force."""


def settings_file(key: str) -> str:
    """Name of the file with the settings that a request with this key is about."""
    return f"settings-{key}.json"


def beside(name: str, key: str) -> str:
    """Name of the file that takes the place of one of `TOGETHER` once those settings are set."""
    return f"{name.removesuffix('.json')}-{key}.json"


def _read_configuration(folder: Path) -> Configuration:
    """Settings that the controller shall take. Raises InputError where there are none."""
    try:
        text = (folder / CONFIGURATION).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"no configuration to run: {error}") from None
    return configuration.from_json(text)


def _name_run(host: Host) -> str:
    """Name of a controller's run, which no other one has."""
    began = datetime.fromtimestamp(host.clock.wall_ns() / NS_PER_S, tz=UTC)
    return f"{began:%Y%m%dT%H%M%S}-{host.token(RUN_BYTES).hex()}"


def steps(
    host: Host,
    folder: Path,
    period_ns: int = MACHINES_OWN,
    attach: Callable[[Path, Host], Port] = ports.attach,
    pace: Callable[[int, int], Pacing] = DeadlineScheduler,
    tell: Callable[[ControlLoop, Pacing], None] = lambda *_: None,
) -> Steps[None]:
    """Control the machine of a folder until the process is told to end.

    A cycle is broken off then, and the process ends once the catheter is out.

    period_ns: of the loop. attach: takes hold of the machine. pace: of the loop, which takes the
    period and the time, ns.
    tell: told of the loop as it begins.

    Raises InputError where it cannot begin.
    """
    clock = host.clock
    with ProcessLock(folder / CONTROLS, "a controller runs", host):
        chosen = _read_configuration(folder)
        before = controller_memory.read_before(folder, clock)
        port = attach(folder, host)
        period_ns = period_ns or round(port.facts.period_s * NS_PER_S)
        state = yield from begin(chosen, port, before, clock)
        call = RealTimeCall(chosen.settings, chosen.heads_mm, state)
        told = {
            "version": __version__,
            "run": _name_run(host),
            "settings": configuration.hash_of(chosen),
            DESCRIPTION: describe(port.facts),
            "period_ns": str(period_ns),
            # Of the monotonic clock's zero: the only time that anybody takes from the wall clock.
            "began_utc_ns": str(clock.wall_ns() - clock.monotonic_ns()),
            STARTED_FROM: call.state_row.tobytes().hex(),
        }
        slots = round(SLOTS_S * NS_PER_S / period_ns)
        with (
            closing(Mailbox(folder / ASK, host)) as mailbox,
            EventWriter(folder / EVENTS, folder / EVENTS_BEFORE, host) as events,
            RingWriter(folder / RING, ROW_COLUMNS, slots, told, folder / RING_BEFORE, host) as ring,
        ):
            heartbeat, setting = Heartbeat(folder, host), Setting(folder, call, chosen)
            around = Around(port, mailbox, ring, events, heartbeat, clock, setting.set)
            loop = ControlLoop(call, around, period_ns / NS_PER_S)
            began = {
                "recovered": "yes" if before is not None and before.died else "no",
                "lacks": say_lacking(port.facts.capabilities, chosen),
            }
            with host.hardened() as allowed:
                _tell_begun(events, allowed, began)
                pacing = pace(period_ns, clock.monotonic_ns())
                tell(loop, pacing)
                yield from _tick(loop, pacing, host)
            events.write(controller_memory.ENDED, loop.tick)
        heartbeat.end(Process.CONTROL)
        port.close()


def _tell_begun(events: EventWriter, allowed: Allowed, began: dict[str, str]) -> None:
    """Tell that the loop begins, and with which rights. began: what is told besides."""
    events.write(
        "began",
        0,
        scheduler=allowed.scheduler,
        memory_locked=str(allowed.memory_locked).lower(),
        refusals="; ".join(allowed.refusals),
        **began,
    )


def _tick(loop: ControlLoop, pace: Pacing, host: Host) -> Steps[None]:
    """Tick until told to end, and until the catheter is out."""
    while not ((ending := host.terminations()) and loop.is_resting) and ending < AT_ONCE:
        loop.stopping = bool(ending) and not loop.is_resting
        yield pace.due_ns
        skipped = pace.begin(host.clock.monotonic_ns())
        loop.step(pace.deadline_ns, skipped)


if __name__ == "__main__":
    _folder = Path(sys.argv[1])
    _period_ns = int(sys.argv[2]) if len(sys.argv) > 2 else MACHINES_OWN
    this_computer.run(lambda host: steps(host, _folder, _period_ns))
