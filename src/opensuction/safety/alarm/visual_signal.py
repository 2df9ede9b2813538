"""The light of an alarm as a function of time: colour and flashing of IEC 60601-1-8."""

from opensuction.safety.alarm.signal_value import DARK, HIGH_LIGHT, LOW_LIGHT, MEDIUM_LIGHT, Light
from opensuction.safety.priority import Priority

LIGHTS: dict[Priority, Light] = {
    Priority.HIGH: HIGH_LIGHT,
    Priority.MEDIUM: MEDIUM_LIGHT,
    Priority.LOW: LOW_LIGHT,
    Priority.NONE: DARK,
}
"""Of each priority; `Priority.NONE` is dark."""


def is_lit(priority: Priority, time_s: float) -> bool:
    """True while the light is on at a time since any fixed beginning.

    It flashes for as long as the alarm is shown, acknowledged or paused as it may be.
    """
    light = LIGHTS[priority]
    phase = (time_s * light.flash_hz.value) % 1.0
    return phase < light.duty_ratio.value
