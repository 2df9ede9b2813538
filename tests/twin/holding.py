"""The twin under the same commands for many ticks, in one call of compiled code."""

from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Commands
from opensuction.twin import plant
from opensuction.twin.machine import machine
from opensuction.twin.machine.machine import Machine, MachineState
from opensuction.twin.plant import PlantState

DT_S = 0.001
IDLE = Commands(
    head_mm=0.0,
    insertion_v=0.0,
    insertion_on=True,
    cam_rad=0.0,
    valve_v=0.0,
    valve_on=True,
    pump_on=False,
    vacuum_mmhg=0.0,
)


@compiled
def hold_machine(
    twin: Machine, state: MachineState, commands: Commands, ticks: int
) -> MachineState:
    """The machine alone, without what the bedside gives it."""
    for _ in range(ticks):
        state = machine.step(twin, state, commands, DT_S)
    return state


@compiled
def hold(twin: Machine, state: PlantState, commands: Commands, ticks: int) -> PlantState:
    """Machine and bedside."""
    for _ in range(ticks):
        state = plant.step(twin, state, commands, DT_S)
    return state
