"""Power state machine of a drive by CiA 402 (IEC 61800-7-201), of both ends of the bus.

The controller's end decides the next control word from the newest status word; the drive's end
follows control words. Both are functions of what they are given: no clock, no bus.

Users of other stacks report what goes wrong here, so each of these holds:

- The state is taken from the newest status word alone. Nobody waits to see a state that may pass
  between two frames, as `QUICK_STOP_ACTIVE` does.
- Transition 16 (back from quick stop) is optional in a drive, so it is never asked for: the way
  leads by `SWITCH_ON_DISABLED`.
- A fault is reset by an edge. Bit 7 is low for a time and then high for a time, for a drive that
  looks at its control word less often than it comes takes two words for one.
- A drive that leaves `OPERATION_ENABLED` without being told is noticed: `PowerControl.lost`.
"""

from enum import IntEnum
from typing import Final, NamedTuple


class PowerState(IntEnum):
    """State of a drive's power stage."""

    NOT_READY = 0
    """It starts; it says nothing yet and obeys nothing."""
    SWITCH_ON_DISABLED = 1
    READY_TO_SWITCH_ON = 2
    SWITCHED_ON = 3
    OPERATION_ENABLED = 4
    """It follows its set point. In every other state the set point is ignored."""
    QUICK_STOP_ACTIVE = 5
    FAULT_REACTION_ACTIVE = 6
    FAULT = 7


_STATUS: Final = (
    (PowerState.NOT_READY, 0x4F, 0x00),
    (PowerState.SWITCH_ON_DISABLED, 0x4F, 0x40),
    (PowerState.READY_TO_SWITCH_ON, 0x6F, 0x21),
    (PowerState.SWITCHED_ON, 0x6F, 0x23),
    (PowerState.OPERATION_ENABLED, 0x6F, 0x27),
    (PowerState.QUICK_STOP_ACTIVE, 0x6F, 0x07),
    (PowerState.FAULT_REACTION_ACTIVE, 0x4F, 0x0F),
    (PowerState.FAULT, 0x4F, 0x08),
)
"""Bits of the status word that tell each state, and their values (CiA 402-2, table of states)."""

VOLTAGE_ENABLED: Final = 1 << 4
WARNING: Final = 1 << 7
REMOTE: Final = 1 << 9
"""It obeys control words; a drive that is served by hand or by another program does not."""
INTERNAL_LIMIT: Final = 1 << 11
FOLLOWS_TARGET: Final = 1 << 12
"""In the cyclic modes: the set point is taken into account."""
FOLLOWING_ERROR: Final = 1 << 13
HOMED: Final = 1 << 12 | 1 << 10
"""In homing mode, both: the home was found, and the axis stands there."""
HOMING_ERROR: Final = 1 << 13

SHUTDOWN: Final = 0x06
SWITCH_ON: Final = 0x07
ENABLE_OPERATION: Final = 0x0F
DISABLE_VOLTAGE: Final = 0x00
QUICK_STOP: Final = 0x02
FAULT_RESET: Final = 0x80
START_HOMING: Final = 1 << 4
"""Beside `ENABLE_OPERATION`, in homing mode."""

_UNKNOWN: Final = "the status word {:#06x} is no state of CiA 402"


def read_state(statusword: int) -> PowerState:
    """State that a status word tells. Raises ValueError for one that tells none."""
    for state, mask, value in _STATUS:
        if statusword & mask == value:
            return state
    raise ValueError(_UNKNOWN.format(statusword))


def write_status(state: PowerState, flags: int = 0) -> int:
    """Status word of a drive in a state, with further bits. As `read_state` reads it."""
    told = next(value for one, _, value in _STATUS if one == state)
    powered = state in (
        PowerState.SWITCHED_ON,
        PowerState.OPERATION_ENABLED,
        PowerState.QUICK_STOP_ACTIVE,
        PowerState.FAULT_REACTION_ACTIVE,
    )
    return told | flags | (VOLTAGE_ENABLED if powered else 0)


_UPWARD: Final = {
    PowerState.SWITCH_ON_DISABLED: SHUTDOWN,
    PowerState.READY_TO_SWITCH_ON: SWITCH_ON,
    PowerState.SWITCHED_ON: ENABLE_OPERATION,
    PowerState.OPERATION_ENABLED: ENABLE_OPERATION,
    PowerState.QUICK_STOP_ACTIVE: DISABLE_VOLTAGE,
}
"""Control word that leads from each state one step towards operation."""


class PowerControl(NamedTuple):
    """Memory of the controller's end of one drive."""

    word: int
    """Control word that is being sent."""
    sent_cycles: int
    """For how many cycles it has been."""
    was_enabled: bool
    """It has been in operation since it was last wanted there."""
    lost: bool
    """It left operation without being told. Stays until the drive is no longer wanted there."""


AT_START: Final = PowerControl(DISABLE_VOLTAGE, 0, was_enabled=False, lost=False)


def step_control(
    control: PowerControl, state: PowerState, *, wanted: bool, reset: bool, hold_cycles: int
) -> PowerControl:
    """Control word of the next cycle.

    state: by the newest status word. wanted: the drive shall be in operation; false takes its
    torque off. reset: a fault shall be reset; without it a drive with a fault stays there.
    hold_cycles: how many cycles each word stands at least, so that a drive that looks less often
    sees every one; taking the torque off does not wait for it.
    """
    lost = wanted and (
        control.lost or (control.was_enabled and state != PowerState.OPERATION_ENABLED)
    )
    follows = state == PowerState.OPERATION_ENABLED and control.word == ENABLE_OPERATION
    enabled = wanted and (control.was_enabled or follows)
    word = _next_word(control, state, wanted=wanted and not lost, reset=reset)
    waits = word != DISABLE_VOLTAGE or state == PowerState.FAULT
    held = waits and control.sent_cycles < hold_cycles
    if word == control.word or held:
        return PowerControl(control.word, control.sent_cycles + 1, enabled, lost)
    return PowerControl(word, 1, enabled, lost)


def _next_word(control: PowerControl, state: PowerState, *, wanted: bool, reset: bool) -> int:
    """Control word that the state asks for, before it is held."""
    if state == PowerState.FAULT and reset:
        # The edge: low first, if it was high before.
        return DISABLE_VOLTAGE if control.word & FAULT_RESET else FAULT_RESET
    if not wanted:
        return DISABLE_VOLTAGE
    return _UPWARD.get(state, DISABLE_VOLTAGE)


class DrivePower(NamedTuple):
    """Power stage at the drive's end."""

    state: PowerState
    word: int
    """Control word before, for edges."""


POWERED_UP: Final = DrivePower(PowerState.SWITCH_ON_DISABLED, 0)


def step_drive(drive: DrivePower, word: int, *, back_from_quick_stop: bool = False) -> DrivePower:
    """State after a control word (transitions 2 to 12, 15 and 16).

    A word moves on by one transition, as drives do; two words are needed for two.
    back_from_quick_stop: the drive has the optional transition 16.
    """
    state = drive.state
    rises = bool(word & FAULT_RESET & ~drive.word)
    after: PowerState
    if state == PowerState.FAULT:
        after = PowerState.SWITCH_ON_DISABLED if rises else state
    elif state in (PowerState.NOT_READY, PowerState.FAULT_REACTION_ACTIVE):
        after = state
    elif not word & 0x02:  # disable voltage: transitions 7, 9, 10, 12
        after = PowerState.SWITCH_ON_DISABLED
    elif not word & 0x04:  # quick stop: transitions 7, 10, 11
        after = _after_quick_stop(state)
    else:
        after = _after_command(state, word, back_from_quick_stop)
    return DrivePower(after, word)


def _after_quick_stop(state: PowerState) -> PowerState:
    """State that the command 'quick stop' leads to."""
    if state in (PowerState.OPERATION_ENABLED, PowerState.QUICK_STOP_ACTIVE):
        return PowerState.QUICK_STOP_ACTIVE
    return PowerState.SWITCH_ON_DISABLED


def _after_command(state: PowerState, word: int, back_from_quick_stop: bool) -> PowerState:
    """State that shutdown, switch on, disable and enable operation lead to."""
    shutdown, enable = word & 0x07 == SHUTDOWN, word & 0x0F == ENABLE_OPERATION
    switched_on = word & 0x0F == SWITCH_ON
    if state == PowerState.QUICK_STOP_ACTIVE:
        return PowerState.OPERATION_ENABLED if enable and back_from_quick_stop else state
    if state == PowerState.SWITCH_ON_DISABLED:
        return PowerState.READY_TO_SWITCH_ON if shutdown else state
    if shutdown:  # transitions 6 and 8
        return PowerState.READY_TO_SWITCH_ON
    if state == PowerState.READY_TO_SWITCH_ON:
        return PowerState.SWITCHED_ON if switched_on or enable else state
    if switched_on:  # transition 5 of a drive in operation
        return PowerState.SWITCHED_ON
    return PowerState.OPERATION_ENABLED if enable else state


def fail_drive(drive: DrivePower) -> DrivePower:
    """A fault has been detected: transition 13, whatever the state."""
    return drive._replace(state=PowerState.FAULT_REACTION_ACTIVE)


def end_reaction(drive: DrivePower) -> DrivePower:
    """The reaction to a fault is over: transition 14."""
    if drive.state != PowerState.FAULT_REACTION_ACTIVE:
        return drive
    return drive._replace(state=PowerState.FAULT)
