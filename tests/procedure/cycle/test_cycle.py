"""When the pump runs: it rests while the catheter goes in, once the line has its vacuum."""

import pytest

from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import NO_REQUESTS
from opensuction.procedure.cycle import cycle
from opensuction.procedure.cycle.demand import Demand
from opensuction.procedure.cycle.progress import ProcedureState
from tests.procedure.cycle.test_progress import AT_HOME, DT_S, PLAN, QUIET

ADVANCING = (Phase.PRELOADING, Phase.INSERTING, Phase.BACKING_OFF)
AWAY = QUIET._replace(head_wanted_mm=30.0)
"""The head is still on its way to its command, so that the phase lasts."""


def stepped(
    phase: Phase, vacuum_mmhg: float, was_ready: bool, valid: bool = True
) -> tuple[ProcedureState, Demand]:
    state: ProcedureState = cycle.begin(PLAN, phase)._replace(phase_ticks=1, line_ready=was_ready)
    readings = AT_HOME._replace(line_vacuum_mmhg=vacuum_mmhg, vacuum_valid=valid)
    after: tuple[ProcedureState, Demand] = cycle.step(
        PLAN, state, readings, NO_REQUESTS, AWAY, DT_S
    )
    return after


@pytest.mark.requirement("OS-R03")
@pytest.mark.parametrize("phase", [Phase.INSERTING, Phase.BACKING_OFF])
def test_the_pump_rests_on_the_way_in_and_leaves_the_set_point(phase: Phase) -> None:
    """Whatever the line has lost since: who refills it hides a valve that lets gas through."""
    for vacuum_mmhg in (PLAN.vacuum_mmhg, 0.5 * PLAN.vacuum_mmhg, 0.0):
        state, asked = stepped(phase, vacuum_mmhg, was_ready=True)
        assert state.phase == phase
        assert state.line_ready
        assert not asked.pump_on
        assert asked.vacuum_mmhg == PLAN.vacuum_mmhg


@pytest.mark.parametrize("phase", ADVANCING)
def test_the_pump_runs_until_the_line_has_its_vacuum(phase: Phase) -> None:
    state, asked = stepped(phase, 0.89 * PLAN.vacuum_mmhg, was_ready=False)
    assert asked.pump_on
    assert not state.line_ready
    assert stepped(phase, 0.91 * PLAN.vacuum_mmhg, was_ready=False)[0].line_ready
    assert not stepped(phase, PLAN.vacuum_mmhg, was_ready=False, valid=False)[0].line_ready


def test_it_fills_the_line_while_the_gap_is_taken_up_and_sucks_with_the_valve_open() -> None:
    for phase in (Phase.PRELOADING, Phase.OPENING, Phase.SUCTIONING, Phase.WITHDRAWING):
        state, asked = stepped(phase, PLAN.vacuum_mmhg, was_ready=True)
        assert state.phase == phase
        assert asked.pump_on


def test_what_the_line_had_in_the_last_cycle_does_not_count() -> None:
    for phase in (Phase.PARKED, Phase.CHECKING, Phase.OPENING, Phase.HALTED):
        assert not stepped(phase, PLAN.vacuum_mmhg, was_ready=True)[0].line_ready
