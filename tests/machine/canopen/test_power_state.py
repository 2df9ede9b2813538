"""Power state machine of a drive, of both ends, put together."""

from itertools import product

import pytest

from opensuction.machine.canopen import power_state
from opensuction.machine.canopen.power_state import (
    AT_START,
    DISABLE_VOLTAGE,
    ENABLE_OPERATION,
    FAULT_RESET,
    POWERED_UP,
    QUICK_STOP,
    SHUTDOWN,
    SWITCH_ON,
    DrivePower,
    PowerControl,
    PowerState,
    fail_drive,
    read_state,
    step_control,
    step_drive,
    write_status,
)

ENABLED = PowerState.OPERATION_ENABLED
HELD = 3


def play(
    control: PowerControl, drive: DrivePower, cycles: int, looks: int = 1, **asked: bool
) -> tuple[PowerControl, DrivePower, list[PowerState]]:
    """Both ends for some cycles; the drive looks at its control word in each `looks`-th."""
    seen = []
    for cycle in range(cycles):
        wanted, reset = asked.get("wanted", True), asked.get("reset", False)
        control = step_control(control, drive.state, wanted=wanted, reset=reset, hold_cycles=HELD)
        if cycle % looks == 0:
            drive = step_drive(drive, control.word)
        seen.append(drive.state)
    return control, drive, seen


@pytest.mark.parametrize("state", PowerState)
@pytest.mark.parametrize("flags", [0, power_state.WARNING | power_state.REMOTE, 0xFF80])
def test_each_state_is_read_as_it_is_written(state: PowerState, flags: int) -> None:
    assert read_state(write_status(state, flags)) == state


def test_every_status_word_tells_one_state_or_is_refused() -> None:
    told, refused = set(), 0
    for word in range(1 << 7):
        try:
            told.add(read_state(word))
        except ValueError as error:
            refused += 1
            assert "CiA 402" in str(error)
    assert told == set(PowerState)
    assert refused


@pytest.mark.parametrize("begun", [one for one in PowerState if one != PowerState.NOT_READY])
@pytest.mark.parametrize("looks", range(1, HELD + 1))
def test_a_drive_comes_into_operation_from_wherever_it_is(begun: PowerState, looks: int) -> None:
    drive = DrivePower(begun, 0)
    if begun == PowerState.FAULT_REACTION_ACTIVE:
        drive = power_state.end_reaction(drive)
    control, drive, _ = play(AT_START, drive, 20 * HELD, looks, reset=True)
    assert drive.state == ENABLED
    assert control.word == ENABLE_OPERATION
    assert not control.lost


@pytest.mark.parametrize("begun", PowerState)
def test_torque_is_taken_off_in_the_next_cycle(begun: PowerState) -> None:
    for before in (SHUTDOWN, SWITCH_ON, ENABLE_OPERATION, QUICK_STOP):
        control = PowerControl(before, 0, was_enabled=True, lost=False)
        after = step_control(control, begun, wanted=False, reset=False, hold_cycles=HELD)
        if begun != PowerState.FAULT:
            assert after.word == DISABLE_VOLTAGE


def test_a_fault_stays_until_a_person_resets_it() -> None:
    control, drive, _ = play(AT_START, POWERED_UP, 20 * HELD)
    drive = power_state.end_reaction(fail_drive(drive))
    control, drive, seen = play(control, drive, 100)
    assert set(seen) == {PowerState.FAULT}
    assert control.lost
    control, drive, _ = play(control, drive, 20 * HELD, wanted=False, reset=True)
    assert drive.state == PowerState.SWITCH_ON_DISABLED


def test_a_reset_is_an_edge_however_seldom_the_drive_looks() -> None:
    """A word that is high from the beginning resets nothing; one that falls and rises does."""
    high = DrivePower(PowerState.FAULT, FAULT_RESET)
    assert step_drive(high, FAULT_RESET).state == PowerState.FAULT
    for looks in range(1, HELD + 1):
        control = PowerControl(FAULT_RESET, HELD, was_enabled=False, lost=False)
        _, drive, _ = play(control, high, 4 * HELD * looks, looks, wanted=False, reset=True)
        assert drive.state == PowerState.SWITCH_ON_DISABLED


@pytest.mark.parametrize("to", [one for one in PowerState if one != ENABLED])
def test_a_drive_that_leaves_operation_without_a_word_is_noticed(to: PowerState) -> None:
    control, drive, _ = play(AT_START, POWERED_UP, 20 * HELD)
    assert drive.state == ENABLED
    control, _, _ = play(control, DrivePower(to, drive.word), 1)
    assert control.lost
    assert control.word == DISABLE_VOLTAGE or to == PowerState.FAULT
    # It stays so: nothing moves again until it has been wanted off.
    control, drive, seen = play(control, DrivePower(PowerState.SWITCH_ON_DISABLED, 0), 20 * HELD)
    assert ENABLED not in seen
    control, drive, _ = play(control, drive, 1, wanted=False)
    control, drive, _ = play(control, drive, 20 * HELD)
    assert drive.state == ENABLED


def test_transition_16_is_never_asked_for() -> None:
    for state, wanted, reset in product(PowerState, (True, False), (True, False)):
        for word in (DISABLE_VOLTAGE, SHUTDOWN, SWITCH_ON, ENABLE_OPERATION, QUICK_STOP):
            control = PowerControl(word, HELD, was_enabled=False, lost=False)
            after = step_control(control, state, wanted=wanted, reset=reset, hold_cycles=HELD)
            if state == PowerState.QUICK_STOP_ACTIVE:
                assert after.word == DISABLE_VOLTAGE


def test_a_drive_follows_one_transition_a_word() -> None:
    way = [SHUTDOWN, SWITCH_ON, ENABLE_OPERATION, SWITCH_ON, SHUTDOWN, DISABLE_VOLTAGE]
    drive, states = POWERED_UP, []
    for word in way:
        drive = step_drive(drive, word)
        states.append(drive.state)
    assert states == [
        PowerState.READY_TO_SWITCH_ON,
        PowerState.SWITCHED_ON,
        ENABLED,
        PowerState.SWITCHED_ON,
        PowerState.READY_TO_SWITCH_ON,
        PowerState.SWITCH_ON_DISABLED,
    ]
    assert step_drive(POWERED_UP, ENABLE_OPERATION).state == PowerState.SWITCH_ON_DISABLED


@pytest.mark.parametrize(
    ("back", "after"), [(True, ENABLED), (False, PowerState.QUICK_STOP_ACTIVE)]
)
def test_a_quick_stop_is_left_by_the_optional_transition_or_by_taking_voltage_off(
    back: bool, after: PowerState
) -> None:
    stopped = step_drive(DrivePower(ENABLED, ENABLE_OPERATION), QUICK_STOP)
    assert stopped.state == PowerState.QUICK_STOP_ACTIVE
    assert step_drive(stopped, ENABLE_OPERATION, back_from_quick_stop=back).state == after
    assert step_drive(stopped, DISABLE_VOLTAGE).state == PowerState.SWITCH_ON_DISABLED
