"""A machine that has been in use for a while: its catheter's age, the time since its last cycle."""

from opensuction.controller import controller, setup
from opensuction.procedure.cycle import interlocks, schedule
from opensuction.procedure.cycle.schedule import ScheduleMode, ScheduleState
from opensuction.simulation.closed_loop import Loop, LoopState


def aged(state: LoopState, age_s: float) -> LoopState:
    """The same with a catheter that has been in use."""
    return state._replace(
        controller=controller.with_upkeep(state.controller, interlocks.start(age_s))
    )


def clocked(
    machine: tuple[Loop, LoopState], mode: ScheduleMode, waited_s: float
) -> tuple[Loop, LoopState]:
    """The same on a schedule of an hour, of which some has passed."""
    loop, state = machine
    hourly = schedule.schedule(mode, 3600.0)
    kept = state.controller.core.upkeep._replace(schedule=ScheduleState(waited_s, waited_s))
    return (
        loop._replace(controller=setup.with_schedule(loop.controller, hourly)),
        state._replace(controller=controller.with_upkeep(state.controller, kept)),
    )
