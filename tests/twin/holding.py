"""The twin under the same commands for one tick or many, in one call of compiled code."""

from functools import cache

from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Commands
from opensuction.twin import parameter, plant, preset
from opensuction.twin.bedside import BedsideState
from opensuction.twin.machine.machine import Machine, MachineState
from opensuction.twin.plant import PlantState
from tests.settled import settled

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


NEVER_DUE = 10**9
"""So many ticks short of the bedside's next step."""


@compiled
def _hold(twin: Machine, state: PlantState, commands: Commands, ticks: int) -> PlantState:
    for _ in range(ticks):
        state = plant.step(twin, state, commands, DT_S)
    return state


_play = settled(_hold)
"""The one way of these tests into the twin's machine code: each other one is ten seconds of a
compiler's work."""


def hold(twin: Machine, state: PlantState, commands: Commands, ticks: int) -> PlantState:
    """Machine and bedside."""
    return _play(twin, state, commands, ticks)


@cache
def _aside() -> BedsideState:
    """A bedside that nobody looks at."""
    values = parameter.nominal(parameter.BENCH)
    return preset.park(preset.machine(values), values, 0.0, seed=1, run=0).bedside


def hold_machine(
    twin: Machine, state: MachineState, commands: Commands, ticks: int
) -> MachineState:
    """The machine alone, without what the bedside gives it."""
    apart = state.coupling._replace(ticks=state.coupling.ticks - NEVER_DUE)
    before = PlantState(state._replace(coupling=apart), _aside())
    moved = hold(twin, before, commands, ticks).machine
    counted = moved.coupling._replace(ticks=moved.coupling.ticks + NEVER_DUE)
    return moved._replace(coupling=counted)
