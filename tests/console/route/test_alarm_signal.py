"""Sounds and lights of alarms as sent to the page are the machine's own."""

import pytest

from opensuction.console.route.machine import list_alarm_signals
from opensuction.safety.alarm import alarm_signal
from opensuction.safety.handling import Priority


@pytest.mark.parametrize("priority", Priority)
def test_figures_are_those_of_the_machine(priority: Priority) -> None:
    told = next(one for one in list_alarm_signals() if one.priority == priority.name.lower())
    pulses = alarm_signal.pulses(priority)
    assert [(one.start_s, one.end_s) for one in told.pulses] == [tuple(one) for one in pulses]
    length_s = told.pulses[-1].end_s + 2.0 * told.foot_s
    assert length_s == pytest.approx(alarm_signal.burst_s(priority))
    tone = alarm_signal.TONES[priority]
    assert told.period_s == pulses[-1].end_s + tone.interval_s.value
    assert sum(told.harmonics) == pytest.approx(1.0)
    light = alarm_signal.LIGHTS[priority]
    assert (told.colour, told.flash_hz) == (light.colour, light.flash_hz.value)
