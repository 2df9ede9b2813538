"""The whole twin: the machine at 1 kHz and the bedside at 100 Hz, put together."""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Commands
from opensuction.twin import bedside as bedside_model
from opensuction.twin.bedside import BedsideState
from opensuction.twin.coupling import TICKS
from opensuction.twin.machine import machine as machine_model
from opensuction.twin.machine.machine import Machine, MachineState


class PlantState(NamedTuple):
    """State of a machine and of the bedside it stands at."""

    machine: MachineState
    bedside: BedsideState


@compiled
def is_due(state: MachineState) -> bool:
    """True where the bedside steps before the machine's next tick."""
    return state.coupling.ticks >= TICKS


@compiled
def settle(
    machine: Machine, state: MachineState, bedside: BedsideState, dt_s: float
) -> tuple[MachineState, BedsideState]:
    """Step the bedside and couple it to the machine anew; to be called where `is_due`."""
    tip_mm = state.airway.tip_mm
    later = bedside_model.step(machine, bedside, state.coupling, tip_mm, dt_s)
    return state._replace(coupling=bedside_model.couple(machine, later, tip_mm)), later


@compiled
def step(machine: Machine, state: PlantState, commands: Commands, dt_s: float) -> PlantState:
    """Advance everything by one tick of the machine under the given commands."""
    moved = machine_model.step(machine, state.machine, commands, dt_s)
    bedside = state.bedside
    if is_due(moved):
        moved, bedside = settle(machine, moved, bedside, dt_s)
    return PlantState(machine=moved, bedside=bedside)
