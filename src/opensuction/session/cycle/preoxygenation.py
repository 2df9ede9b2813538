"""Pre-oxygenation on the twin: 100 % oxygen from the ventilator, and the answer at the machine.

The oxygen stays on for the pass and for what is followed of the patient after it, as the function
of a ventilator does; a lung that collapses behind it (absorption) is not modelled.
"""

from opensuction.kernel.errors import InputError
from opensuction.kernel.name import name_of
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import OXYGEN_SKIPPED, OXYGENATED, Requests
from opensuction.procedure.cycle import interlocks
from opensuction.procedure.cycle.episode import PassRule
from opensuction.procedure.cycle.preoxygenation import Preoxygenation
from opensuction.result.cycle_result import OxygenRecord
from opensuction.simulation import closed_loop, idle_time, trace
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.trace import Columns
from opensuction.twin import preset

GIVEN_S = 60.0
"""How long it is given before the start: 30 to 60 s are usual, and after 30 s saturation falls
further than after a minute or two [K]."""
FULL_RATIO = 1.0
ANSWERS: dict[str, Requests] = {"confirmed": OXYGENATED, "skipped": OXYGEN_SKIPPED}
"""What a person may answer, by the name that the command line takes."""
USUAL = "confirmed"
"""Where guidelines ask for it and nobody has said anything."""


def check(chosen: str | None, rule: PassRule) -> None:
    """Refuse an answer where nobody is asked; raises InputError."""
    if chosen is not None and not rule.asks_for_oxygen:
        raise InputError(
            f"--preoxygenation {chosen}: nobody asks for it on the bench or with a neonate, who "
            "gets no 100 % oxygen: leave it out"
        )


def lead_s(loop: Loop, chosen: str | None) -> float:
    """Time before its start at which a cycle's preparation begins, in s."""
    return GIVEN_S if _is_given(loop, chosen) else 0.0


def _is_given(loop: Loop, chosen: str | None) -> bool:
    return loop.controller.service.passes.asks_for_oxygen and (chosen or USUAL) == USUAL


def pass_idle_time(loop: Loop, state: LoopState, duration_s: float) -> LoopState:
    """Patient and controller's clocks after a time in which the machine is parked."""
    before = state.tick
    state = idle_time.pass_time(loop, state, duration_s)
    core = state.controller.core
    kept = interlocks.pass_idle_time(core.upkeep, (state.tick - before) * DT_S)
    decided = state.controller._replace(core=core._replace(upkeep=kept))
    return state._replace(controller=decided)


def give(loop: Loop, state: LoopState, chosen: str | None) -> tuple[Loop, LoopState]:
    """The loop for the next cycle, and its state once the machine has its answer.

    chosen: a name of `ANSWERS`; None is the usual one. Nothing changes where nobody is asked.
    """
    if not loop.controller.service.passes.asks_for_oxygen:
        return loop, state
    if _is_given(loop, chosen):
        loop = loop._replace(machine=preset.ventilate(loop.machine, FULL_RATIO))
        state = pass_idle_time(loop, state, GIVEN_S)
    return loop, closed_loop.run(loop, state, ANSWERS[chosen or USUAL], trace.rows(DT_S))[0]


def on_record(columns: Columns) -> OxygenRecord:
    """Pre-oxygenation of the first cycle of a trace, as it is on record."""
    codes, testing = columns["counters.preoxygenation"], columns["phase"] == Phase.CHECKING
    code = codes[testing][0] if testing.any() else codes[-1]
    state = Preoxygenation(int(code))
    return OxygenRecord(required=state != Preoxygenation.NOT_REQUIRED, state=name_of(state))
