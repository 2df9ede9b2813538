"""The nominal bench, healthy and with faults, driven by hand."""

from opensuction.kernel.interface import Commands
from opensuction.twin import preset
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine.machine import Machine, MachineState
from opensuction.twin.parameter import BENCH, nominal
from tests.twin import holding
from tests.twin.holding import DT_S, hold_machine

VALUES = nominal(BENCH)
HEALTHY = preset.machine(VALUES)
IDLE = holding.IDLE._replace(valve_on=False)
OPENING = IDLE._replace(valve_v=24.0, valve_on=True)
PUSHING = IDLE._replace(insertion_v=12.0)


def parked(head_mm: float = 0.0) -> MachineState:
    return preset.park(HEALTHY, VALUES, head_mm, seed=1, run=2).machine


def run(twin: Machine, state: MachineState, commands: Commands, seconds: float) -> MachineState:
    return hold_machine(twin, state, commands, round(seconds / DT_S))


def faulty(fault: Fault, strength: float = 0.0, twin: Machine = HEALTHY) -> Machine:
    return ROWS[fault].change_machine(twin, strength)
