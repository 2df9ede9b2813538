"""The control loop before the twin without a clock: both step as many ticks as they are told.

What is looked at here does not depend on who else works on this machine: the same loop as in the
control process, ring and all, on a machine that moves 1 ms a tick, whatever the loop's period.
"""

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Generic, Protocol, SupportsFloat, TypeVar, cast

import numpy as np

from opensuction.controller.real_time_call import RealTimeCall
from opensuction.host.host import NS_PER_S, Host
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.liveness import Heartbeat
from opensuction.ipc.mailbox import Mailbox, MailboxAnswer, MailboxRequest
from opensuction.ipc.ring import EventWriter, RingWriter
from opensuction.kernel.interface import MESSAGE_COLUMNS, NO_REQUESTS, START, Requests
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.machine.port import EVERYTHING, MachineFacts, Port
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_machine import READINGS
from opensuction.runtime.loop import ROW_COLUMNS, Around, ControlLoop
from opensuction.simulation import machine_side
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.machine_side import SHOWN_COLUMNS, MachineCall
from opensuction.twin.machine import fail_safe
from opensuction.twin.plant import PlantState

TICK_NS = round(DT_S * NS_PER_S)
SLOTS = 16
PHASE = ROW_COLUMNS.index("outputs.phase")


class Steppable(Port, Protocol):
    """A `ports.Port` to a machine that moves when it is told to."""

    shown: list[Array]
    """What it gave in each tick, by `SHOWN_COLUMNS`."""

    def move(self, ticks: int) -> None:
        """So many ticks of 1 ms."""


class SteppedMachine:
    """A `ports.Port` to a twin that moves when it is told to."""

    def __init__(self, loop: Loop, state: LoopState) -> None:
        plant = PlantState(state.machine, state.bedside)
        self.call = MachineCall(machine_side.begin(twin_machine.side_of(loop, seed=1), plant))
        self.facts = MachineFacts(
            "stepped twin", "", True, DT_S, fail_safe.SILENCE_S, {}, EVERYTHING
        )
        self._sent, self._new, self.number = np.zeros(len(MESSAGE_COLUMNS)), False, 0
        self.shown: list[Array] = []
        """What it gave in each tick, by `SHOWN_COLUMNS`."""
        self.stands_still = False
        """It gives no new readings."""
        self.falsified: Mapping[int, SupportsFloat] = {}
        """What is read instead, by place."""
        self.move(1)

    def move(self, ticks: int) -> None:
        """So many ticks of 1 ms."""
        for _ in range(ticks):
            self.call.step(self._sent, new=self._new)
            self._new = False
            self.shown.append(self.call.shown_row.copy())
        self.number += ticks * (not self.stands_still)

    def read(self, readings: Array) -> int:
        """See `ports.Port.read`."""
        readings[:] = self.call.shown_row[READINGS]
        for place, value in self.falsified.items():
            readings[place] = value
        return self.number

    def write(self, sent: Array) -> None:
        """See `ports.Port.write`."""
        self._sent[:], self._new = sent, True

    def close(self) -> None:
        """See `ports.Port.close`."""


class Buttons:
    """In the mailbox's place: what shall be pressed in the next tick."""

    def __init__(self) -> None:
        self.pressed = NO_REQUESTS
        self.answers: list[MailboxAnswer] = []
        self.setting: MailboxRequest | None = None

    def receive(self) -> tuple[Requests, list[MailboxAnswer]]:
        """See `Mailbox.receive`."""
        pressed, self.pressed = self.pressed, NO_REQUESTS
        answers, self.answers = self.answers, []
        return pressed, answers


Machine = TypeVar("Machine", bound=Steppable)


class LoopRoom(Generic[Machine]):
    """The loop before a machine."""

    def __init__(
        self,
        folder: Path,
        machine: Machine,
        loop: Loop,
        state: LoopState,
        period: int = 1,
        host: Host = THIS_COMPUTER,
    ) -> None:
        """period: of the loop, in ticks of the machine."""
        self.period, self.machine, self.buttons = period, machine, Buttons()
        call = RealTimeCall(loop.controller, loop.heads_mm, state.controller)
        self._files = ExitStack()
        ring = self._files.enter_context(
            RingWriter(folder / "stepped.ring", ROW_COLUMNS, SLOTS, {})
        )
        events = self._files.enter_context(EventWriter(folder / "stepped.events"))
        mailbox = cast(Mailbox, self.buttons)
        around = Around(
            self.machine,
            mailbox,
            ring,
            events,
            Heartbeat(folder, host),
            host.clock,
            lambda *_: iter(["refused"]),
        )
        self.loop = ControlLoop(call, around, period * DT_S)
        self.rows: list[Array] = []
        """Those of the loop, by `ROW_COLUMNS`."""

    def step(self, requests: Requests = NO_REQUESTS, skipped: int = 0) -> None:
        """A tick of the loop, and the machine's until the next. skipped: missed before it."""
        self.machine.move(skipped * self.period)
        self.buttons.pressed = requests
        self.loop.step(self.loop.tick * self.period * TICK_NS, skipped)
        self.rows.append(self.loop.row.copy())
        self.machine.move(self.period)

    def phase(self) -> Phase:
        """Of the last tick."""
        return Phase(int(self.rows[-1][PHASE]))

    def run(self, seconds: float, requests: Requests = NO_REQUESTS) -> None:
        """For so long by the loop's ticks; requests: pressed in the first."""
        for _ in range(round(seconds / (self.period * DT_S))):
            self.step(requests)
            requests = NO_REQUESTS

    def cycle(self, limit_s: float = 90.0) -> None:
        """From a start until it rests."""
        self.step(START)
        for _ in range(round(limit_s / (self.period * DT_S))):
            self.step()
            if self.phase() in RESTING:
                return
        raise AssertionError(f"it is {self.phase().name} after {limit_s:g} s")

    def columns(self) -> dict[str, Array]:
        """Those of the loop, by name."""
        return dict(zip(ROW_COLUMNS, np.array(self.rows).T, strict=True))

    def shown(self) -> dict[str, Array]:
        """Those of the machine, by name, with the time of its own."""
        table = dict(zip(SHOWN_COLUMNS, np.array(self.machine.shown).T, strict=True))
        return {**table, "time_s": table["tick"] * DT_S}

    def close(self) -> None:
        """Let go of the files."""
        self._files.close()


class SteppedRoom(LoopRoom[SteppedMachine]):
    """The loop before a twin."""

    def __init__(
        self,
        folder: Path,
        loop: Loop,
        state: LoopState,
        period: int = 1,
        host: Host = THIS_COMPUTER,
    ) -> None:
        """See `LoopRoom`."""
        super().__init__(folder, SteppedMachine(loop, state), loop, state, period, host)
