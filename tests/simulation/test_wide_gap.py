"""A gap wider than the head's way home: the barrier tells, and the head goes further back."""

import pytest

from opensuction.evidence.safety_case.hazard_case import COMPENSATION
from opensuction.evidence.trial import judged_cycle, sound_machine
from opensuction.evidence.trial.cohort import Kind
from opensuction.oracle import exposure
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.twin.fault.fault import Fault


@pytest.mark.parametrize(
    ("kind", "seed", "at_s"),
    [
        (Kind("adult-icu", "contact"), 6, 18.388),
        (Kind("child-10kg", "contact"), 2, 10.617),
        (Kind("neonate", "travel"), 6, 8.234),
    ],
    ids=str,
)
def test_three_times_the_gap_leaves_no_tip_in_the_tube(kind: Kind, seed: int, at_s: float) -> None:
    """Found by the search for harm, of machines drawn twice as far: 1.1 mm short of out."""
    room = judged_cycle.make_room()
    machine = sound_machine.play(sound_machine.prepare(kind, seed, COMPENSATION, spread=2.0), room)
    fault = Injection(Fault.CONDUIT_REROUTED, FaultInstant(None, at_s), 3.0)
    played = judged_cycle.play_faulty(machine, (fault,), seed, room)
    borne = exposure.measure(machine.prepared.rig.machine, played.run.columns)
    assert borne.end_mm < borne.outside_mm - 1.0
    park_mm = machine.prepared.loop.controller.limits.park_head_mm
    # The rack ends ten millimetres behind.
    assert played.run.columns["truth.head_mm"].min() > park_mm - 7.0
