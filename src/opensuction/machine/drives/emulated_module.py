"""Module of CiA 401, emulated: sensors, pump, regulator and the display at the bedside."""

import math
from pathlib import Path
from typing import Final, NamedTuple

from opensuction.host.host import Clock
from opensuction.kernel.interface import Readings
from opensuction.kernel.record import make_zero
from opensuction.machine.canopen import device
from opensuction.machine.canopen.device import Analogue, InputModule
from opensuction.machine.canopen.objects import (
    CONDITION_BITS,
    FLAG_SHIFT,
    NO_VALUE,
    AnnunciatorFlag,
    Module,
)
from opensuction.machine.drives.emulated_node import EmulatedNode
from opensuction.safety.condition import Condition

EDS: Final = Path(__file__).with_name("module.eds")
ALONE: Final = 1 << Condition.WATCHDOG_FIRED
"""Told at the bedside without a host: the display has a battery of its own, and a line that opens
where the module is lost."""
_CHANNELS: Final = 8
_INPUT_BYTES: Final = 2


class Outputs(NamedTuple):
    """Outputs of the module in a tick."""

    pump_on: bool
    vacuum_mmhg: float
    wanted: int
    """Mask of the conditions that people shall be told."""
    reset: bool
    released: bool


def counts_of(channel: Analogue, value: float, is_valid: bool) -> int:
    """Counts of an analogue input; `NO_VALUE` where its sensor tells nothing."""
    if not (is_valid and math.isfinite(value)):
        return NO_VALUE
    return max(device.output_of(channel, value), NO_VALUE + 1)


class EmulatedModule(EmulatedNode):
    """Inputs and outputs on the bus."""

    def __init__(self, module: InputModule, clock: Clock) -> None:
        self.module, self._readings = module, make_zero(Readings)
        super().__init__(module.node, EDS, clock)

    def on_lost_host(self) -> None:
        """See `EmulatedNode.on_lost_host`: outputs as their error modes say."""
        values = self.values
        mode, safe = values[Module.OUTPUT_ERROR_MODE, 1], values[Module.OUTPUT_ERROR_VALUE, 1]
        now = values[Module.DIGITAL_OUTPUTS, 1]
        values[Module.DIGITAL_OUTPUTS, 1] = (now & ~mode) | (safe & mode)
        for channel in (1, 2):
            if values[Module.ANALOGUE_ERROR_MODE, channel]:
                safe = values[Module.ANALOGUE_ERROR_VALUE, channel]
                values[Module.ANALOGUE_OUTPUT, channel] = min(max(safe, -0x8000), 0x7FFF)

    def measure(self, readings: Readings) -> None:
        """Take what the sensors read."""
        self._readings = readings

    def refresh(self) -> None:
        """See `EmulatedNode.refresh`."""
        module, readings = self.module, self._readings
        monitor = readings.monitor
        for channel, value, is_valid in (
            (module.vacuum, readings.line_vacuum_mmhg, readings.vacuum_valid),
            (module.carriage, readings.carriage_mm, readings.carriage_valid),
            (module.spo2, monitor.spo2_percent, True),
            (module.heart_rate, monitor.heart_rate_per_min, True),
            (module.airway_pressure, monitor.airway_pressure_cmh2o, True),
        ):
            if channel.channel:
                counts = counts_of(channel, value, is_valid)
                self.values[Module.ANALOGUE_INPUT, channel.channel] = counts
        bits = (module.mouth_bit, module.monitor_bit, *module.validity_bits)
        told = (
            readings.mouth_clear,
            monitor.connected,
            monitor.spo2_valid,
            monitor.heart_rate_valid,
            monitor.airway_pressure_valid,
        )
        inputs = sum(1 << bit for bit, one in zip(bits, told, strict=True) if bit >= 0 and one)
        for place in range(_INPUT_BYTES):
            self.values[Module.DIGITAL_INPUTS, place + 1] = inputs >> 8 * place & 0xFF

    @property
    def outputs(self) -> Outputs:
        """State of its outputs."""
        module, values = self.module, self.values
        counts = values[Module.ANALOGUE_OUTPUT, module.regulator.channel]
        told = values[Module.ANNUNCIATOR, 1]
        flags = told >> FLAG_SHIFT
        return Outputs(
            pump_on=bool(values[Module.DIGITAL_OUTPUTS, 1] >> module.pump_bit & 1),
            vacuum_mmhg=max(device.value_of(module.regulator, counts), 0.0),
            wanted=told & ((1 << CONDITION_BITS) - 1) | (ALONE if self._misses_host else 0),
            reset=bool(flags & AnnunciatorFlag.RESET),
            released=bool(flags & AnnunciatorFlag.RELEASED),
        )
