"""A loose contact is gone and comes back at any instant: a drive that works brings the tip out."""

import numpy as np
import pytest

from opensuction.evidence.campaign import sound_machine
from opensuction.evidence.campaign.sound_machine import AIRWAY
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import injection, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.run_judgement import GONE_S
from opensuction.twin.fault.fault import Fault
from tests.oracle import drawn_machine

LOOSE = (Fault.MOTOR_INTERMITTENT, Fault.READING_INTERMITTENT, Fault.MESSAGE_INTERMITTENT)
WATCHED_S = 60.0


@pytest.fixture(scope="module")
def machines() -> list[Prepared]:
    """A machine for each patient and approach."""
    return drawn_machine.pool(4300)


def assert_out(prepared: Prepared, fault: Fault, at_s: float, turn_s: float) -> None:
    loose = Injection(fault, FaultInstant(None, at_s), turn_s)
    run = injection.run(prepared.loop, prepared.start, [loose], after_s=WATCHED_S)
    assert not np.isnan(run.faults[0].at_s)
    cap_mm = prepared.loop.controller.limits.cap_mm
    found = run_judgement.judge(prepared.rig.machine, cap_mm, run.columns, run.faults)
    assert (found.left_inside, found.breaches) == (None, ()), loose


def assert_all_out(machines: list[Prepared], numbers: range) -> None:
    draws = np.random.default_rng([13, 4, numbers.start])
    for number in numbers:
        prepared = machines[number % len(machines)]
        fault = LOOSE[number // len(machines) % len(LOOSE)]
        healthy = drawn_machine.play_healthy(prepared)
        at_s = sound_machine.find_time_s(healthy, AIRWAY, draws.random())
        assert_out(prepared, fault, at_s, 0.01 * (GONE_S / 0.01) ** draws.random())


@pytest.mark.requirement("OS-R45")
@pytest.mark.parametrize(
    "numbers",
    [
        # Each fault at three machines, each machine once or twice.
        pytest.param(range(0, 24, 3), marks=pytest.mark.sweep, id="each"),
        pytest.param(range(48), marks=pytest.mark.soak, id="all"),
    ],
)
def test_a_contact_that_is_loose_by_turns_leaves_nobody_inside(
    machines: list[Prepared], numbers: range
) -> None:
    assert_all_out(machines, numbers)


@pytest.mark.soak
def test_a_thousand_loose_contacts_leave_nobody_inside(machines: list[Prepared]) -> None:
    assert_all_out(machines, range(1000, 2000))


FOUND = [
    # Coasts in for as long as it has no current; as it is back, it is far beyond its bound.
    (29, Fault.MOTOR_INTERMITTENT, 5.057, 0.4544757136361861),
    # Lags, catches up at twice its speed, and goes too far while it is braked.
    (21, Fault.MOTOR_INTERMITTENT, 6.056, 0.4192776341447248),
    (16, Fault.MOTOR_INTERMITTENT, 5.474, 0.43739143777803147),
    # On its way out, 4 mm before the mouth, when the time for that was over.
    (22, Fault.MOTOR_INTERMITTENT, 6.207, 3.8661392132861363),
    # Without current, a millimetre before the mouth, when that time was over.
    (24, Fault.MOTOR_INTERMITTENT, 13.492, 2.614630451378937),
    # Seen again in the tick in which the time of a way that is not seen was over.
    (3, Fault.READING_INTERMITTENT, 19.564, 2.611074188173564),
]


@pytest.mark.requirement("OS-R45")
@pytest.mark.parametrize(("machine", "fault", "at_s", "turn_s"), FOUND)
def test_those_that_were_left_inside_come_out(
    machine: int, fault: Fault, at_s: float, turn_s: float
) -> None:
    assert_out(drawn_machine.prepare(machine, 31_000), fault, at_s, turn_s)
