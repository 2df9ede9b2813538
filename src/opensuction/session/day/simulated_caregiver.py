"""Actions of a person between the cycles of a day: assessment, a new catheter, oxygen."""

from typing import NamedTuple

from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import ASSESSED, CHANGED, RETURN_TO_SERVICE, SERVICE, Requests
from opensuction.procedure.cycle import episode, interlocks
from opensuction.procedure.cycle.refusal import Refusal
from opensuction.session.cycle import preoxygenation
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import closed_loop, trace
from opensuction.simulation.closed_loop import DT_S, LoopState

WORN = (Refusal.CATHETER_LIFE_OVER, Refusal.CATHETER_LIFE_ENDS)


class Attended(NamedTuple):
    """A machine that somebody has been at, about to begin a cycle."""

    ready: Prepared
    """For this cycle: with the oxygen on that was given for it."""
    catheter_changed: bool
    assessed: bool
    """The person looked at the patient, for as many passes as may follow each other were made."""


def _press(prepared: Prepared, state: LoopState, requests: Requests) -> LoopState:
    """One tick in which somebody presses a button."""
    return closed_loop.run(prepared.loop, state, requests, trace.rows(DT_S))[0]


def _is_worn(prepared: Prepared, state: LoopState) -> bool:
    settings = prepared.loop.controller
    refusal = interlocks.refusal(
        settings.service,
        state.controller.core.upkeep,
        Phase.PARKED.value,
        settings.plan.travel_known,
        state.controller.core.governor.patient.conditions,
    )
    return refusal in WORN


def _renew(prepared: Prepared, state: LoopState) -> LoopState:
    """The loop after a person has put a new catheter in; the old one's mucus goes with it."""
    for requests in (SERVICE, CHANGED, RETURN_TO_SERVICE):
        state = _press(prepared, state, requests)
    bore = state.machine.bore._replace(mucus_ml=0.0, tail_ml=0.0, front_ml=0.0)
    return state._replace(machine=state.machine._replace(bore=bore))


def lead_s(prepared: Prepared) -> float:
    """Time before a cycle at which the person comes, in s."""
    return preoxygenation.lead_s(prepared.loop, prepared.resolved.choice.preoxygenation)


def attend(prepared: Prepared, state: LoopState) -> Attended:
    """Somebody comes before a cycle and does what it needs."""
    rule = prepared.loop.controller.service.passes
    assessed = bool(episode.is_exhausted(rule, state.controller.core.upkeep.episode))
    if assessed:
        state = _press(prepared, state, ASSESSED)
    worn = _is_worn(prepared, state)
    if worn:
        state = _renew(prepared, state)
    chosen = prepared.resolved.choice.preoxygenation
    loop, state = preoxygenation.give(prepared.loop, state, chosen)
    return Attended(prepared._replace(loop=loop, start=state), worn, assessed)
