"""A contact switch that does not close: how hard the tip presses until the drive tells of it."""

from functools import cache

import numpy as np
import pytest

from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import JUDGED
from opensuction.evidence.campaign.sound_machine import Kind, SoundMachine
from opensuction.safety.condition import Condition
from opensuction.simulation import outcome
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.faulty_run import RowBuffer
from opensuction.twin.fault.fault import Fault

MOST_N = 0.2
"""Two thirds of what an airway bears; without the drive's word tips pressed with up to .27 N."""
PATIENTS = ("adult-icu", "adult-ards", "child-10kg", "neonate")
FAULTS = {
    Fault.SWITCH_STUCK_OPEN: 0.0,
    Fault.SWITCH_STIFF: 5.0,
    Fault.CONTACT_INTERMITTENT: 10.0,
}
"""With the strengths at which the switch says nothing for longest."""


@cache
def room() -> RowBuffer:
    return played_cycle.make_room(JUDGED)


@cache
def sound(patient: str, seed: int) -> SoundMachine:
    return sound_machine.play(
        sound_machine.prepare(Kind(patient, "contact"), seed, "exact-inverse"), room()
    )


def before_contact_s(machine: SoundMachine, before_s: float) -> float:
    """So long before the tip of the sound cycle touches the carina."""
    force = machine.rows[room().names.index("truth.contact_n")]
    return round(float(np.argmax(force > 0.0)) * 1e-3 - before_s, 3)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda one: one.name.lower())
@pytest.mark.parametrize("patient", PATIENTS)
@pytest.mark.parametrize(
    "seeds",
    [
        pytest.param(range(1, 2), marks=pytest.mark.sweep, id="one"),
        pytest.param(range(1, 51), marks=pytest.mark.soak, id="fifty"),
    ],
)
def test_a_tip_that_no_switch_tells_of_presses_with_little(
    patient: str, fault: Fault, seeds: range
) -> None:
    for seed in seeds:
        machine = sound(patient, seed)
        for before_s in (2.0, 0.005):
            one = Injection(
                fault, FaultInstant(None, before_contact_s(machine, before_s)), FAULTS[fault]
            )
            columns = played_cycle.play_faulty(machine, (one,), seed, room()).run.columns
            assert columns["truth.contact_n"].max() < MOST_N, (seed, before_s)
            told = {each.condition for each in outcome.told(columns)}
            by_turns = fault == Fault.CONTACT_INTERMITTENT
            assert by_turns or Condition.CONTACT_STUCK_OPEN in told, (seed, before_s)
