"""Records of the alarms: settings, state, buttons, and the signals that are shown and sounded."""

from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.kernel.record import make_zero
from opensuction.safety.alarm import alarm_clock
from opensuction.safety.alarm.alarm_clock import Clocks

LONGEST_PAUSE_S = 120.0
"""Longest audio pause: as much as ventilators have, [ISO-80601-2-12] [K]."""
AUDIBLE_S = 4.0
"""After a pause the alarm sounds for so long, a whole high burst, before the next is granted:
pressing again and again cannot keep it silent."""
NOTHING = -1
"""In place of a condition: none."""


class AlarmSettings(NamedTuple):
    """Alarm settings of the organisation that uses the machine."""

    pause_s: float
    """Length of an audio pause, at most `LONGEST_PAUSE_S`."""
    reminder_s: float
    """Interval of the reminder that something is shown and makes no sound."""


class Buttons(NamedTuple):
    """Buttons for alarms, true as long as they are pressed; the press counts, not the holding."""

    acknowledge: bool
    """Silence what is shown now."""
    audio_pause: bool
    """Begin an audio pause, or end the one that runs."""
    reset: bool
    """Clear what is latched and has ended."""


class AlarmState(NamedTuple):
    """State of the alarms."""

    present: int
    latched: int
    """Ended, and waiting for a reset."""
    acknowledged: int
    escalated: int
    """Raised by one priority for want of an answer."""
    waiting: int
    """Holding, not yet for its delay."""
    clocks: Clocks
    pause_left_s: float
    paused_priority: int
    """Most urgent of what the pause silenced."""
    owed_s: float
    """How long it must still sound before another pause."""
    silent_s: float
    """How long something shown has made no sound, since the last reminder."""
    pressed: Buttons
    """Buttons of the last tick."""


class Signals(NamedTuple):
    """Alarm signals in a tick; everything a display or a loudspeaker needs."""

    priority: int
    """Most urgent priority that is shown."""
    audible: int
    """Priority of the sound, `Priority.NONE` for silence."""
    first: int
    """Condition to show first, or `NOTHING`."""
    present: int
    latched: int
    acknowledged: int
    escalated: int
    pause_left_s: float
    """What is left of the audio pause, 0 without one."""
    reminder: bool
    """Sound the reminder once."""


RELEASED = make_zero(Buttons)
SILENT = make_zero(Signals, first=NOTHING)
"""Nothing to tell; 0 is also the number of no priority."""
START = make_zero(AlarmState, clocks=alarm_clock.START)
"""State at power-up: nothing is known yet; what holds is signalled after its delay."""


def check_settings(pause_s: float, reminder_s: float) -> AlarmSettings:
    """Settings, checked against their limits.

    Raises InputError for a pause that is not between 0 and `LONGEST_PAUSE_S`, or a reminder that
    is not positive or rarer than the longest pause.
    """
    for name, value in (("audio pause", pause_s), ("reminder interval", reminder_s)):
        if not 0.0 < value <= LONGEST_PAUSE_S:
            raise InputError(
                f"the {name} is {value:g} s; it must be above 0 and at most {LONGEST_PAUSE_S:g} s"
            )
    return AlarmSettings(pause_s, reminder_s)
