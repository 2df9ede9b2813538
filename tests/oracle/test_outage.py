"""A controller that is gone for a moment leaves no catheter behind: judged by the truth alone."""

import numpy as np
import pytest

from opensuction.evidence.trial import fault_campaign
from opensuction.kernel.phase import CYCLE, Phase
from opensuction.oracle import exposure
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.twin.fault.fault import Fault

PHASES = tuple(one for one in CYCLE if one not in (Phase.CHECKING, Phase.BACKING_OFF))
LEAST_S, MOST_S = 0.001, 3.0
"""Outages: from one tick on; drives act on their own after 20 ms."""
LATEST_S = 8.0
WATCHED_S = 60.0
GUIDELINE_S = {"adult": 30.0, "paediatric": 20.0}
"""Longest stay in the airway; an outage must not lengthen it by more than itself and a reversal."""
REVERSAL_S = 1.0


@pytest.fixture(scope="module")
def machines() -> list[Prepared]:
    """A machine for each patient and approach."""
    return fault_campaign.pool(8, 4100, "preview")


def assert_nobody_left_inside(machines: list[Prepared], numbers: range) -> None:
    draws = np.random.default_rng([13, numbers.start])
    came, left = 0, []
    for number in numbers:
        prepared = machines[number % len(machines)]
        phase = PHASES[number // len(machines) % len(PHASES)]
        outage_s = round(LEAST_S * (MOST_S / LEAST_S) ** draws.random(), 3)
        at = FaultInstant(phase, round(LATEST_S * draws.random(), 3))
        stopped = Injection(Fault.CONTROLLER_STOPPED, at, outage_s)
        run = injection.run(prepared.loop, prepared.start, [stopped], after_s=WATCHED_S)
        came += not np.isnan(run.faults[0].at_s)
        found = exposure.measure(prepared.rig.machine, run.columns)
        most_s = GUIDELINE_S[prepared.resolved.protocol_name] + outage_s + REVERSAL_S
        if found.inside_at_end or found.in_airway_s > most_s:
            left.append((number, phase.name, stopped, found))
    assert left == []
    assert came > 0.25 * len(numbers)


def test_no_outage_leaves_the_catheter_inside(machines: list[Prepared]) -> None:
    assert_nobody_left_inside(machines, range(48))


@pytest.mark.soak
def test_no_outage_of_a_thousand_leaves_the_catheter_inside(machines: list[Prepared]) -> None:
    assert_nobody_left_inside(machines, range(1000, 2000))
