"""Each fault of the valve does to the machine what its row says."""

import pytest

from opensuction.twin.fault.fault import Fault
from opensuction.twin.machine import dc_axis
from opensuction.twin.machine.machine import Machine, MachineState
from tests.twin.fault.broken_machine import HEALTHY, IDLE, OPENING, faulty, parked, run
from tests.twin.holding import hold_machine


def opened(twin: Machine, state: MachineState) -> float:
    return float(dc_axis.open_ratio(twin.valve, state.valve.position))


def test_a_slide_that_sticks_does_not_answer_to_the_cam() -> None:
    full = run(HEALTHY, parked(), OPENING, 3.0)
    assert opened(HEALTHY, full) == 1.0
    for ratio in (0.3, 1.0):
        stuck = faulty(Fault.VALVE_STUCK_OPEN, ratio)
        shut = run(stuck, full, IDLE, 3.0)
        assert shut.valve.position <= 0.0  # the cam is back, and its encoder says so
        assert opened(stuck, shut) == ratio
    parted = faulty(Fault.VALVE_STUCK_CLOSED, 0.0)
    assert opened(parted, run(parted, parked(), OPENING, 3.0)) == 0.0


def test_a_slow_valve_takes_as_much_longer_as_it_has_lost_speed() -> None:
    slow = faulty(Fault.VALVE_SLOW, 0.75)
    brief = 0.3
    quick = run(HEALTHY, parked(), OPENING, brief).valve
    # Slowed fourfold in speed and in time to reach it, it gets there in four times the time... of
    # steady motion; its way is a quarter but for what the start takes.
    tau_s = HEALTHY.valve_axis.time_constant_s
    late = run(slow, parked(), OPENING, brief).valve
    assert late.position / quick.position == pytest.approx(0.25, rel=2.0 * tau_s / brief)


def test_a_seized_cam_stays_where_it_is() -> None:
    half = run(HEALTHY, parked(), OPENING, 0.2)
    jammed = faulty(Fault.VALVE_JAMMED)
    at_once = hold_machine(jammed, half, OPENING, 1)
    later = run(jammed, at_once, IDLE, 2.0)
    assert later.valve.position == at_once.valve.position > 0.0


def test_a_valve_motor_without_current_leaves_the_valve_to_its_spring() -> None:
    full = run(HEALTHY, parked(), OPENING, 3.0)
    shut = run(faulty(Fault.VALVE_MOTOR_LOST), full, OPENING, 3.0)
    assert opened(HEALTHY, shut) == 0.0


def test_without_its_spring_the_valve_stays_open_when_its_torque_is_off() -> None:
    full = run(HEALTHY, parked(), OPENING, 3.0)
    assert opened(HEALTHY, run(HEALTHY, full, IDLE, 3.0)) == 0.0
    broken = faulty(Fault.VALVE_SPRING_BROKEN)
    assert opened(broken, run(broken, full, IDLE, 3.0)) == 1.0
