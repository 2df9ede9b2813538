"""The call of the real-time loop against the closed loop of simulation: two roots, one controller.

What the closed loop's controller read is given to the call again; each of its outputs must be the
same in every bit, and so must the whole state, wherever the closed loop can be stopped to look.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.controller import setup
from opensuction.controller.real_time_call import (
    INPUT_COLUMNS,
    OUTPUT_COLUMNS,
    STATE_COLUMNS,
    RealTimeCall,
)
from opensuction.controller.record import State
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.interface import NO_REQUESTS, START, Requests
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning import clinical
from opensuction.procedure.planning.protocol import PAPER
from opensuction.session.cycle import resolution
from opensuction.simulation import closed_loop, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.injection import injection
from opensuction.simulation.trace import Columns

PIECE = 500
"""Ticks after which the closed loop's state is looked at."""
IN_TRACE = [name for name in OUTPUT_COLUMNS if name != "assessment_due"]
"""All but one output are columns of the trace."""


class Machine(NamedTuple):
    """What stands there."""

    preset: str
    patient: str
    kind: CompensationKind
    by_contact: bool = False


BENCH = Machine("bench", "", CompensationKind.PREVIEW)
TABLE = BENCH._replace(kind=CompensationKind.LOOKUP_TABLE)
ADULT = Machine("clinical", "adult-icu", CompensationKind.PREVIEW)
CONTACT = ADULT._replace(by_contact=True)
NEONATE = Machine("clinical", "neonate", CompensationKind.EXACT_INVERSE)


@cache
def ready(chosen: Machine) -> tuple[Loop, LoopState]:
    rig = rigs.rig(chosen.preset, 3, patient=chosen.patient or rigs.DEFAULT_PATIENT)
    calibration = rigs.identify(rig).calibration
    protocol = PAPER
    if chosen.preset == "clinical":
        able = setup.abilities(rig.profile, chosen.kind, calibration, rig.site)
        usual = clinical.PAEDIATRIC if chosen.patient == "neonate" else clinical.ADULT
        protocol = clinical.fitted(usual, able, rig.site, chosen.by_contact)
    return rigs.assemble(rig, protocol, chosen.kind, calibration, 2, chosen.by_contact)


def fed(columns: Columns, first_tick: int, requests: Requests) -> Array:
    """The inputs that the controller had; requests: pressed in the first tick."""
    ticks = columns["time_s"].size
    table = np.zeros((ticks, len(INPUT_COLUMNS)))
    for i, name in enumerate(INPUT_COLUMNS):
        if name.startswith("readings."):
            table[:, i] = columns[name]
        elif name.startswith("requests."):
            table[0, i] = getattr(requests, name.removeprefix("requests."))
    table[:, INPUT_COLUMNS.index("tick")] = first_tick + np.arange(ticks)
    table[:, INPUT_COLUMNS.index("dt_s")] = DT_S
    return table


def call_of(loop: Loop, start: LoopState) -> RealTimeCall:
    return RealTimeCall(loop.controller, loop.heads_mm, start.controller)


def assert_same_outputs(said: Array, columns: Columns) -> None:
    for name in IN_TRACE:
        column = np.ascontiguousarray(said[:, OUTPUT_COLUMNS.index(name)])
        assert column.tobytes() == np.ascontiguousarray(columns[name]).tobytes(), name


@pytest.mark.parametrize("chosen", [BENCH, TABLE, ADULT, CONTACT, NEONATE], ids=str)
def test_a_cycle_is_the_same_in_every_bit(chosen: Machine) -> None:
    loop, state = ready(chosen)
    call, table, requests = call_of(loop, state), trace.rows(PIECE * DT_S), START
    phases: set[int] = set()
    while Phase.PARKED not in phases or len(phases) < 2:
        first = state.tick
        state, ticks = closed_loop.run(loop, state, requests, table)
        columns = trace.by_name(table[:ticks])
        said = np.zeros((ticks, len(OUTPUT_COLUMNS)))
        call.run(fed(columns, first, requests), said)
        assert_same_outputs(said, columns)
        assert call.state_row.tobytes() == plain_row.pack(State, state.controller).tobytes()
        phases |= set(said[:, OUTPUT_COLUMNS.index("phase")].astype(int))
        requests = NO_REQUESTS
    assert {Phase.CHECKING, Phase.INSERTING, Phase.SUCTIONING, Phase.WITHDRAWING} <= phases
    assert (Phase.BACKING_OFF in phases) == chosen.by_contact


FAULTS = (
    "catheter-jammed@inserting+1",
    "switch-bridged",
    "encoder-frozen@inserting+1",
    "encoder-invalid@suctioning",
    "message-lost@suctioning+0.5",
    "reading-intermittent@inserting+0.5",
)
"""Of machine, sensors and link; the governor trips in each."""


@pytest.mark.parametrize("name", FAULTS)
def test_a_cycle_with_a_fault_is_the_same_in_every_bit(name: str) -> None:
    loop, start = ready(ADULT)
    run = injection.run(loop, start, resolution.resolve_faults((name,), "travel"))
    call, ticks = call_of(loop, start), run.columns["time_s"].size
    said, kept = np.zeros((ticks, len(OUTPUT_COLUMNS))), np.zeros((ticks, len(STATE_COLUMNS)))
    call.run(fed(run.columns, start.tick, START), said, kept)
    assert_same_outputs(said, run.sent)
    assert kept[-1].tobytes() == plain_row.pack(State, run.state.controller).tobytes()
    assert run.faults[0].at_s < ticks * DT_S
    assert said[:, OUTPUT_COLUMNS.index("verdict.trips")].any()
