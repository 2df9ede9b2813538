"""Time between cycles, the machine at rest: the patient breathes and secretions gather.

Nothing of the machine moves, so its thousand ticks a second need not be played: only the bedside
steps, at its own 100 Hz. The patient ends where the closed loop, parked for as long, would have
brought them. What of the machine settles by itself within seconds is not followed: the catheter
creeps by tenths of a millimetre more, and the tip stays where it is.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.twin import bedside
from opensuction.twin.bedside import BedsideState
from opensuction.twin.coupling import TICKS, CouplingState
from opensuction.twin.machine import suction_line

STEP_S = TICKS * DT_S
"""Time passes in steps of the bedside."""


class Worst(NamedTuple):
    """Worst values of a patient's signs."""

    spo2_percent: float
    """Least saturation."""
    lung_volume_loss_ml: float
    """Most volume lost, less what the patient's own muscles take."""


@compiled
def _step_bedside(
    loop: Loop, around: BedsideState, coupling: CouplingState, tip_mm: float
) -> tuple[BedsideState, CouplingState]:
    """One step of the bedside beside a machine that stands."""
    around = bedside.step(loop.machine, around, coupling, tip_mm, DT_S)
    return around, bedside.couple(loop.machine, around, tip_mm)


@compiled
def find_worst(loop: Loop, state: LoopState, duration_s: float) -> Worst:
    """Worst values of a patient's signs in a time at rest; arguments as of `pass_time`."""
    around, coupling = state.bedside, state.machine.coupling
    tip_mm = state.machine.airway.tip_mm
    least, most_ml = coupling.signs.spo2_percent, coupling.signs.relaxed_loss_ml
    for _ in range(round(duration_s / STEP_S)):
        around, coupling = _step_bedside(loop, around, coupling, tip_mm)
        least = min(least, coupling.signs.spo2_percent)
        most_ml = max(most_ml, coupling.signs.relaxed_loss_ml)
    return Worst(least, most_ml)


@compiled
def pass_time(loop: Loop, state: LoopState, duration_s: float) -> LoopState:
    """The closed loop after a time at rest; for a machine that is parked.

    duration_s: rounded to steps of the bedside (10 ms). Its tick goes on, so that time does; the
    controller's clocks are its caller's to move (`upkeep.pass_idle_time`). Mucus in
    the bore stays there.
    """
    span_s = STEP_S
    steps = round(duration_s / span_s)
    if steps < 1:
        return state
    tip_mm = state.machine.airway.tip_mm
    coupling, around = state.machine.coupling, state.bedside
    ticks = coupling.ticks
    for _ in range(steps):
        around, coupling = _step_bedside(loop, around, coupling, tip_mm)
    machine = state.machine._replace(
        # Pump off, valve closed, air let in: of the machine only the line changes.
        line=suction_line.step(
            loop.machine.line, state.machine.line, False, 0.0, 0.0, 0.0, steps * span_s
        ),
        # As far between two steps of the bedside as before.
        coupling=coupling._replace(ticks=ticks, gas_ml=0.0, mucus_ml=0.0, from_mm=tip_mm),
    )
    return state._replace(tick=state.tick + steps * TICKS, machine=machine, bedside=around)
