"""Drawn out by sensors that are in doubt the insertion motor pulls, and never pushes."""

import numpy as np
import pytest

from opensuction.controller import controller
from opensuction.kernel.record import make_zero
from opensuction.kernel.vocabulary import Phase
from opensuction.safety.condition import Condition
from opensuction.safety.governor.governor import Verdict
from opensuction.safety.handling import Reaction
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.twin.fault.fault import Fault
from tests.controller.bedside import at_bed


@pytest.mark.requirement("OS-R10")
@pytest.mark.parametrize("reaction", Reaction)
@pytest.mark.parametrize("condition", [Condition.HEAD_SENSORS_DISAGREE, Condition.HEAD_STALLED])
def test_only_where_both_are_so(reaction: Reaction, condition: Condition) -> None:
    verdict = make_zero(Verdict)._replace(reaction=reaction, trips=1 << condition)
    wanted = reaction == Reaction.WITHDRAW and condition == Condition.HEAD_SENSORS_DISAGREE
    assert controller._pulls_only(verdict) == wanted


@pytest.mark.parametrize("drift_mm_per_s", [-3.0, 2.0])
def test_and_the_catheter_comes_out_by_that(drift_mm_per_s: float) -> None:
    fault, at = Fault.HEAD_SENSORS_DRIFTING, FaultInstant(Phase.INSERTING, 1.0)
    loop, start = at_bed("neonate")
    seen = injection.run(loop, start, [Injection(fault, at, drift_mm_per_s)], after_s=5.0).columns
    doubtful = seen["verdict.trips"].astype(np.int64) >> Condition.HEAD_SENSORS_DISAGREE & 1 == 1
    pulled = doubtful & (seen["verdict.reaction"] == Reaction.WITHDRAW)
    assert np.count_nonzero(pulled) > 100
    assert seen["commands.insertion_v"][pulled].max() <= 0.0
    assert seen["commands.insertion_v"][pulled].min() < -2.0
    assert seen["truth.tip_mm"].max() > 0.0
    assert seen["truth.tip_mm"][-1] < loop.machine.mouth_mm
