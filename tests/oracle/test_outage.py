"""A controller that is gone for a moment leaves no catheter behind: judged by the truth alone."""

import numpy as np
import pytest

from opensuction.kernel.vocabulary import CYCLE, Phase
from opensuction.oracle import exposure
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.twin.fault.fault import Fault
from tests.oracle import drawn_machine

LEAST_S, MOST_S = 0.001, 3.0
"""Outages: from one tick on; drives act on their own after 20 ms."""
WATCHED_S = 60.0
TICK_S = 0.001
GUIDELINE_S = {"adult": 30.0, "paediatric": 20.0}
"""Longest stay in the airway; an outage must not lengthen it by more than itself and a reversal."""
REVERSAL_S = 1.0


@pytest.fixture(scope="module")
def machines() -> list[Prepared]:
    """A machine for each patient and approach."""
    return drawn_machine.pool(4100)


def assert_nobody_left_inside(machines: list[Prepared], numbers: range) -> None:
    draws = np.random.default_rng([13, numbers.start])
    spans = [drawn_machine.play_healthy(prepared).spans for prepared in machines]
    came, left = 0, []
    for number in numbers:
        prepared = machines[number % len(machines)]
        lasts = spans[number % len(machines)]
        phases = [one for one in CYCLE if one.name.lower() in lasts]
        phase = phases[number // len(machines) % len(phases)]
        begin_s, end_s = lasts[phase.name.lower()]
        outage_s = round(LEAST_S * (MOST_S / LEAST_S) ** draws.random(), 3)
        at = FaultInstant(phase, round((end_s - begin_s - TICK_S) * draws.random(), 3))
        stopped = Injection(Fault.CONTROLLER_STOPPED, at, outage_s)
        run = injection.run(prepared.loop, prepared.start, [stopped], after_s=WATCHED_S)
        came += not np.isnan(run.faults[0].at_s)
        found = exposure.measure(prepared.rig.machine, run.columns)
        most_s = GUIDELINE_S[prepared.resolved.protocol_name] + outage_s + REVERSAL_S
        if found.inside_at_end or found.in_airway_s > most_s:
            left.append((number, phase.name, stopped, found))
    assert left == []
    assert came == len(numbers)


@pytest.mark.parametrize(
    "numbers",
    [
        # Each phase of a cycle, the machines in turn.
        pytest.param(range(0, 64, 9), marks=pytest.mark.sweep, id="each"),
        pytest.param(range(48), marks=pytest.mark.soak, id="all"),
    ],
)
def test_no_outage_leaves_the_catheter_inside(machines: list[Prepared], numbers: range) -> None:
    assert_nobody_left_inside(machines, numbers)


@pytest.mark.parametrize("outage_s", [0.03, 0.5, 2.0])
def test_a_controller_that_wakes_without_any_reading_leaves_nobody_inside(
    machines: list[Prepared], outage_s: float
) -> None:
    """The bus is gone when it wakes: where the head is, no sensor says for 8 s."""
    for prepared in machines[::3]:
        gone = Injection(
            Fault.READING_INTERMITTENT, FaultInstant(Phase.SUCTIONING, 0.29), strength=8.0
        )
        stopped = Injection(Fault.CONTROLLER_STOPPED, FaultInstant(Phase.SUCTIONING, 0.3), outage_s)
        run = injection.run(prepared.loop, prepared.start, [gone, stopped], after_s=WATCHED_S)
        assert not any(np.isnan(one.at_s) for one in run.faults)
        assert not exposure.measure(prepared.rig.machine, run.columns).inside_at_end


@pytest.mark.soak
def test_no_outage_of_a_thousand_leaves_the_catheter_inside(machines: list[Prepared]) -> None:
    assert_nobody_left_inside(machines, range(1000, 2000))
