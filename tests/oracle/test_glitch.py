"""One bad sample, a pulse or a lag strands nobody: judged by the truth alone."""

import math

import numpy as np
import pytest

from opensuction.evidence.campaign import sound_machine
from opensuction.evidence.campaign.sound_machine import AIRWAY
from opensuction.oracle import exposure
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS
from tests.oracle import drawn_machine

GLITCHES = (
    Fault.ENCODER_GLITCH,
    Fault.CARRIAGE_GLITCH,
    Fault.CAM_GLITCH,
    Fault.VACUUM_GLITCH,
    Fault.CONTACT_GLITCH,
    Fault.CURRENT_GLITCH,
)
"""One tick of one sensor each: no cycle may so much as end by it."""
LASTING = (
    Fault.CURRENT_PULSE,
    Fault.CURRENT_OFFSET,
    Fault.ENCODER_OFFSET,
    Fault.ENCODER_JUMPING,
    Fault.ENCODER_NOISY,
    Fault.ENCODER_FROZEN,
    Fault.ENCODER_REVERSED,
    Fault.ENCODER_SLIPPING,
    Fault.ENCODER_INVALID,
    Fault.CARRIAGE_SENSOR_FROZEN,
    Fault.CARRIAGE_SENSOR_INVALID,
    Fault.MOTOR_REVERSED,
)
"""These may end a cycle, with the catheter out."""
WATCHED_S = 60.0
FORCE_N = 0.3


@pytest.fixture(scope="module")
def machines() -> list[Prepared]:
    """A machine for each patient and approach."""
    return drawn_machine.pool(4200)


def strength_of(fault: Fault, share: float) -> float:
    """Anywhere in the fault's range, to either side where it has two; by ratio where it is wide."""
    known = ROWS[fault].strength
    if known is None:
        return 0.0
    if known.least < 0.0 < known.most:
        size = known.most * 1e-3 ** abs(2.0 * share - 1.0)
        return math.copysign(size, share - 0.5)
    return float(known.least * (known.most / known.least) ** share)


def assert_nobody_left_inside(
    machines: list[Prepared], faults: tuple[Fault, ...], numbers: range, *, ends: bool
) -> None:
    draws = np.random.default_rng([13, 2, numbers.start])
    came, left, broken, ended = 0, [], [], []
    for number in numbers:
        prepared = machines[number % len(machines)]
        fault = faults[number // len(machines) % len(faults)]
        healthy = drawn_machine.play_healthy(prepared)
        at = FaultInstant(None, sound_machine.find_time_s(healthy, AIRWAY, draws.random()))
        wrong = Injection(fault, at, strength_of(fault, draws.random()))
        run = injection.run(prepared.loop, prepared.start, [wrong], after_s=WATCHED_S)
        came += not np.isnan(run.faults[0].at_s)
        found = exposure.measure(prepared.rig.machine, run.columns)
        if found.inside_at_end:
            left.append((number, wrong, found.end_mm))
        if found.force_peak_n > FORCE_N:
            broken.append((number, wrong, found.force_peak_n))
        if run.columns["verdict.trips"][-1] != 0.0:
            ended.append((number, wrong))
    assert left == broken == []
    assert ends or ended == []
    assert came == len(numbers)


@pytest.mark.requirement("OS-R45")
@pytest.mark.parametrize(
    "numbers",
    [
        # Each of the sensors at a machine of its own.
        pytest.param(range(0, 48, 9), marks=pytest.mark.sweep, id="each"),
        pytest.param(range(48), marks=pytest.mark.soak, id="all"),
    ],
)
def test_one_sample_of_one_sensor_ends_no_cycle(machines: list[Prepared], numbers: range) -> None:
    assert_nobody_left_inside(machines, GLITCHES, numbers, ends=False)


@pytest.mark.requirement("OS-R45")
@pytest.mark.parametrize(
    "numbers",
    [
        # Each of the faults, the machines in turn.
        pytest.param(range(0, 96, 7), marks=pytest.mark.sweep, id="each"),
        pytest.param(range(32), marks=pytest.mark.soak, id="some at all"),
    ],
)
def test_a_sensor_or_a_motor_that_is_wrong_for_good_leaves_nobody_behind(
    machines: list[Prepared], numbers: range
) -> None:
    assert_nobody_left_inside(machines, LASTING, numbers, ends=True)


@pytest.mark.soak
def test_a_thousand_samples_end_no_cycle(machines: list[Prepared]) -> None:
    assert_nobody_left_inside(machines, GLITCHES, range(1000, 2000), ends=False)


@pytest.mark.soak
def test_a_thousand_lasting_faults_leave_nobody_behind(machines: list[Prepared]) -> None:
    assert_nobody_left_inside(machines, LASTING, range(1000, 2000), ends=True)


@pytest.mark.requirement("OS-R45")
@pytest.mark.parametrize("delay_s", [0.001, 0.01, 0.02])
def test_readings_that_begin_to_come_late_change_nothing(
    machines: list[Prepared], delay_s: float
) -> None:
    draws = np.random.default_rng([13, 3, round(1000 * delay_s)])
    for prepared in machines[::3]:
        healthy = drawn_machine.play_healthy(prepared)
        at = FaultInstant(None, sound_machine.find_time_s(healthy, AIRWAY, draws.random()))
        late = Injection(Fault.READING_LATE, at, delay_s)
        run = injection.run(prepared.loop, prepared.start, [late], after_s=WATCHED_S)
        assert not exposure.measure(prepared.rig.machine, run.columns).inside_at_end
        assert run.columns["verdict.trips"][-1] == 0.0, at
