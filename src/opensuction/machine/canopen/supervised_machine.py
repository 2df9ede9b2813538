"""Machine on a bus under supervision: set up, and commanded for some seconds at half of its torque.

Whoever asks for a move watches it, with a hand at the emergency stop and no catheter in anybody.

Steps, as of any process (`host.host.Steps`): the caller sleeps until the next one.
"""

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from opensuction.host.host import NS_PER_S, Host, Steps, after
from opensuction.kernel.codegen import plain_row, row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Commands, DriveMessage, Readings
from opensuction.kernel.record import make_zero
from opensuction.machine.canopen.canopen_machine import SET_UP_S, CanopenMachine
from opensuction.machine.canopen.device import AxisMode, Device
from opensuction.machine.canopen.frame_bus import FrameBus

TORQUE_SHARE: Final = 0.5
"""Of the device file's highest torque, for the moves."""
GREETS_S: Final = 0.3


class SupervisedMachine:
    """A machine that moves while somebody watches."""

    def __init__(self, device: Device, bus: FrameBus, host: Host) -> None:
        """Moves are at `TORQUE_SHARE` of the torque that the device file allows.

        They go by the drives' own servos, whatever mode the axes have: a machine that nobody has
        identified has no servo of ours.
        """
        axis, position = device.insertion, AxisMode.POSITION
        gentle = axis._replace(most_torque=TORQUE_SHARE * axis.most_torque, mode=position)
        valve = device.valve._replace(mode=position)
        self.device, self.host = device._replace(insertion=gentle, valve=valve), host
        self.port = CanopenMachine(self.device, bus, host)
        self._row = np.zeros(len(row.columns(Readings)))

    @property
    def readings(self) -> Readings:
        """The newest."""
        return plain_row.unpack(Readings, self._row)

    def set_up(self) -> Steps[Readings]:
        """Set the nodes up; what they read. Raises InputError with all differences."""
        ends_ns = after(self.host.clock, SET_UP_S)
        while not self.port.read(self._row):
            if self.host.clock.monotonic_ns() > ends_ns:
                raise InputError(f"the machine '{self.device.name}' gives no readings")
            yield after(self.host.clock, 0.001)
        yield from self.drive(GREETS_S, released=True)
        return self.readings

    def drive(
        self,
        seconds: float,
        command: Callable[[float], dict[str, Any]] = lambda _: {},
        stops: Callable[[], bool] = lambda: False,
        *,
        released: bool = False,
    ) -> Steps[bool]:
        """Command the machine for some time; false where it was stopped before.

        command: what is commanded after so many seconds. stops: ends it at once.
        """
        period_s, begun_ns = self.device.bus.period_s, self.host.clock.monotonic_ns()
        for cycle in range(math.ceil(seconds / period_s)):
            commands = make_zero(Commands)._replace(**command(cycle * period_s))
            sent = make_zero(DriveMessage, commands=commands, released=released)
            self.port.write(plain_row.pack(DriveMessage, sent))
            yield begun_ns + round((cycle + 1) * period_s * NS_PER_S)
            self.port.read(self._row)
            if stops():
                return False
        return True

    def release(self) -> Steps[None]:
        """Take the torque off both drives."""
        yield from self.drive(5 * self.device.bus.period_s)
