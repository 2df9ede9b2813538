"""A person teaches the travel length on the twin: hand, machine and controller in the loop.

What is taught is 2 to 4 mm deeper than the carina: the hand presses until it has reacted, and the
model is 1 mm off the plant. Protocols stop that much nearer to it than their 10 mm.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from opensuction.control.compensation import CompensationKind
from opensuction.controller.calibration import Calibration
from opensuction.kernel.phase import RESTING, Phase
from opensuction.kernel.requests import CONFIRM, NO_REQUESTS, TEACH
from opensuction.procedure.cycle.teaching import Taught
from opensuction.procedure.planning import teaching_limit
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.simulation import closed_loop, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.rig import Rig
from opensuction.simulation.trace import Columns
from opensuction.twin.machine import hand

TEACHING_RUN = 3
"""Number of the noise stream and of the person; identification and cycles have others."""
LIMIT_S = 90.0
"""No teaching lasts longer: the governor's time in the airway ends it before."""
FINE_S = 0.02
"""How finely in time the button is pressed."""


class Teaching(NamedTuple):
    """Result of a teaching."""

    taught: Taught
    taught_mm: float
    """Taught length; nan where none was taken."""
    columns: Columns
    home: bool
    """Whether the machine is parked again."""


def assemble(chosen: Rig, calibration: Calibration) -> tuple[Loop, LoopState]:
    """Closed loop of a rig ready to be taught, a person at the catheter head.

    Depth is limited by the plausible range, for the carina is not known yet, and time in the
    airway by the guideline; no cycle can be started.
    """
    age = chosen.site.age
    loop, state = rigs.assemble(
        chosen,
        teaching_limit.protocol(age, teaching_limit.IDLE_VACUUM_MMHG),
        CompensationKind.EXACT_INVERSE,
        calibration,
        TEACHING_RUN,
    )
    settings = loop.controller
    limits = settings.limits._replace(in_airway_s=GUIDELINES[age].in_airway_s)
    plan = settings.plan._replace(travel_known=False)
    person = hand.draw(settings.parked.head_mm, -chosen.site.park_mm, chosen.seed, TEACHING_RUN)
    return (
        loop._replace(
            controller=settings._replace(limits=limits, plan=plan),
            machine=loop.machine._replace(hand=person),
        ),
        state._replace(machine=state.machine._replace(hand=hand.PUSHING)),
    )


def teach(chosen: Rig, calibration: Calibration, names: Sequence[str] = ()) -> Teaching:
    """The travel length that a person teaches on a rig, and how it went.

    calibration: the controller's model of the transmission, found before. names: the columns of
    the trace that are wanted.
    """
    loop, state = assemble(chosen, calibration)
    table = np.empty((trace.RECORDED_ROWS, len(COLUMNS)))
    parts, confirmed, requests = [], False, TEACH
    while state.tick * DT_S < LIMIT_S:
        left_s = hand.confirms_in_s(loop.machine.hand, state.machine.hand)
        if left_s <= 0.0 and not confirmed:
            requests, confirmed = CONFIRM, True
        # Not beyond the instant at which the button may be pressed.
        ahead_s = LIMIT_S if confirmed else min(left_s, LIMIT_S)
        piece = round(max(ahead_s // FINE_S - 1.0, 1.0) * FINE_S / DT_S)
        state, ticks = closed_loop.run(loop, state, requests, table[:piece])
        requests = NO_REQUESTS
        parts.append(trace.copy_columns(table[:ticks], names))
        if state.controller.core.procedure.phase in RESTING:
            break
    found = state.controller.core.procedure.teaching
    taken = found.taught == Taught.TAKEN
    return Teaching(
        taught=Taught(found.taught),
        taught_mm=float(found.taught_mm) if taken else float(np.nan),
        columns=trace.join(parts),
        home=state.controller.core.procedure.phase == Phase.PARKED,
    )
