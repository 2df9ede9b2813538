"""Emulated drives with the driver of this project before them, tick by tick."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from opensuction.controller import controller
from opensuction.controller.real_time_call import INPUT_COLUMNS, OUTPUT_COLUMNS, RealTimeCall
from opensuction.controller.record import Outputs
from opensuction.kernel.codegen import plain_row, row
from opensuction.kernel.interface import START, Commands, DriveMessage, Readings, Requests
from opensuction.kernel.record import make_zero
from opensuction.kernel.vocabulary import Phase
from opensuction.machine.canopen.canopen_machine import CanopenMachine
from opensuction.machine.canopen.device import Device
from opensuction.machine.canopen.frame_bus import CanFrame, FrameBus
from tests.machine.canopen.stepped_bus import stepped_host
from tests.machine.drives.emulated_bench import DEVICE, EmulatedBench, loop

RELEASED_S = 0.2
"""For so long a controller says that it has started."""


class NoisyBus:
    """A bus that loses frames, and repeats some."""

    def __init__(self, bus: FrameBus, seed: int, lost: float, repeated: float) -> None:
        """lost, repeated: shares of the frames, in each direction."""
        self._bus, self._lost, self._repeated = bus, lost, repeated
        self._random = np.random.default_rng(seed)

    def _pass(self, frames: Iterable[CanFrame]) -> list[CanFrame]:
        found: list[CanFrame] = []
        for one in frames:
            if self._random.random() >= self._lost:
                found += [one] * (2 if self._random.random() < self._repeated else 1)
        return found

    def send(self, frames: Sequence[CanFrame]) -> None:
        self._bus.send(self._pass(frames))

    def receive(self) -> Iterable[CanFrame]:
        return self._pass(self._bus.receive())

    def close(self) -> None:
        self._bus.close()


class DrivenBench(EmulatedBench):
    """The paper's bench over the bus."""

    def __init__(
        self, device: Device = DEVICE, wire: Callable[[FrameBus], FrameBus] = lambda bus: bus
    ) -> None:
        """wire: between the driver and the bus."""
        super().__init__(device)
        self.said: list[str] = []
        self.end, self.ticks = wire(self.bus), round(device.bus.period_s * 1e3)
        self.reading = np.zeros(len(row.columns(Readings)))
        self.attach()

    def attach(self) -> None:
        """A driver that starts, until it has readings."""
        host = stepped_host(self.clock)._replace(say=self.said.append)
        self.port = CanopenMachine(self.device, self.end, host)
        for _ in range(20_000):
            if self.port.read(self.reading):
                return
            self.tick()
        raise AssertionError("no readings")

    @property
    def readings(self) -> Readings:
        return plain_row.unpack(Readings, self.reading)

    def drive(self, times: int = 1, released: bool = False, **commands: Any) -> Readings:
        """Cycles with the same command; the last readings."""
        given = make_zero(Commands)._replace(**commands)
        self.obey(given, times, released)
        return self.readings

    def obey(self, commands: Commands, times: int = 1, released: bool = False) -> None:
        """Cycles with these commands."""
        sent = make_zero(DriveMessage, commands=commands, released=released)
        message = plain_row.pack(DriveMessage, sent)
        for _ in range(times):
            self.port.write(message)
            for _ in range(self.ticks):
                self.tick()
            self.port.read(self.reading)

    def stand(self, ticks: int) -> None:
        """The host's process is gone: nobody reads or writes."""
        for _ in range(ticks):
            self.tick()

    def greet(self) -> None:
        """A controller that has just started."""
        self.drive(round(RELEASED_S / self.device.bus.period_s), released=True)


class Course:
    """Course of a cycle: phases as they were gone through, and the tip's way."""

    def __init__(self) -> None:
        self.phases: list[Phase] = []
        self.alarms = 0
        self.tip_mm: list[float] = []


def cycle(
    read: Callable[[], Readings],
    obey: Callable[[Commands, bool], None],
    tip_mm: Callable[[], float],
    period_s: float,
) -> Course:
    """One cycle of the paper's protocol by the core, from start to rest."""
    settings = loop()[0].controller
    call = RealTimeCall(settings, None, controller.start(settings, read().head_mm, 0.0))
    inputs, outputs = np.zeros(len(INPUT_COLUMNS)), np.zeros(len(OUTPUT_COLUMNS))
    places = {
        name: [k for k, one in enumerate(INPUT_COLUMNS) if one.startswith(f"{name}.")]
        for name in ("readings", "requests")
    }
    course, start = Course(), round(1.0 / period_s)
    inputs[INPUT_COLUMNS.index("dt_s")] = period_s
    for tick in range(round(60.0 / period_s)):
        asked = START if tick == start else make_zero(Requests)
        inputs[INPUT_COLUMNS.index("tick")] = tick
        inputs[places["readings"]] = list(plain_row.numbers(read()))
        inputs[places["requests"]] = list(plain_row.numbers(asked))
        call.step(inputs, outputs)
        said = plain_row.unpack(Outputs, outputs)
        phase = Phase(said.phase)
        if course.phases[-1:] != [phase]:
            course.phases.append(phase)
        course.alarms |= said.signals.present | said.signals.latched
        obey(said.commands, tick * period_s < RELEASED_S)
        course.tip_mm.append(tip_mm())
        if phase == Phase.PARKED and len(course.phases) > 1:
            return course
    raise AssertionError(f"the cycle did not end: {course.phases}")
