"""Time between cycles, the machine at rest: the patient breathes and secretions gather.

Nothing of the machine moves, so its thousand ticks a second need not be played: only the bedside
steps, at its own 100 Hz. The patient ends where the closed loop, parked for as long, would have
brought them. What of the machine settles by itself within seconds is not followed: the catheter
creeps by tenths of a millimetre more, and the tip stays where it is.
"""

from opensuction.kernel.compiled import compiled
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.twin import bedside
from opensuction.twin.coupling import TICKS, CouplingState
from opensuction.twin.machine import suction_line
from opensuction.twin.machine.machine import MachineState

STEP_S = TICKS * DT_S
"""Time passes in steps of the bedside."""


@compiled
def _rested(
    loop: Loop, state: MachineState, coupling: CouplingState, span_s: float
) -> MachineState:
    """The machine afterwards: pump off, valve closed, air let in; only the line changes."""
    return MachineState(
        insertion=state.insertion,
        head_mm=state.head_mm,
        transmission=state.transmission,
        valve=state.valve,
        line=suction_line.step(loop.machine.line, state.line, False, 0.0, 0.0, 0.0, span_s),
        bore=state.bore,
        airway=state.airway,
        switch=state.switch,
        laser=state.laser,
        coupling=coupling,
        hand=state.hand,
    )


@compiled
def pass_time(loop: Loop, state: LoopState, duration_s: float) -> LoopState:
    """The closed loop after a time at rest; for a machine that is parked.

    duration_s: rounded to steps of the bedside (10 ms). Its tick goes on, so that time does; the
    controller's clocks are its caller's to move (`controller.pass_idle_time`). Mucus in
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
        around = bedside.step(loop.machine, around, coupling, tip_mm, DT_S)
        coupling = bedside.met(loop.machine, around, tip_mm)
    # As far between two steps of the bedside as before.
    coupling = CouplingState(
        ticks=ticks,
        gas_ml=0.0,
        mucus_ml=0.0,
        reachable_ml=coupling.reachable_ml,
        from_mm=tip_mm,
        shown=coupling.shown,
    )
    body = _rested(loop, state.machine, coupling, steps * span_s)
    return LoopState(
        tick=state.tick + steps * TICKS,
        controller=state.controller,
        machine=body,
        bedside=around,
    )
