import numpy as np
import pytest

from opensuction.safety.alarm import alarm_signal
from opensuction.safety.handling import Priority

STEP_S = 0.001


@pytest.mark.parametrize(
    ("priority", "least_hz", "most_hz", "colour"),
    [(Priority.HIGH, 1.4, 2.8, "red"), (Priority.MEDIUM, 0.4, 0.8, "yellow")],
)
def test_urgent_lights_flash(
    priority: Priority, least_hz: float, most_hz: float, colour: str
) -> None:
    seconds = 100.0
    on = np.array(
        [alarm_signal.is_lit(priority, index * STEP_S) for index in range(round(seconds / STEP_S))]
    )
    flashes = int(np.count_nonzero(on[1:] & ~on[:-1])) + int(on[0])
    assert least_hz < flashes / seconds < most_hz
    assert 0.2 < on.mean() < 0.6
    assert on[0], "a new alarm is seen at once"
    assert alarm_signal.LIGHTS[priority].colour == colour


def test_the_low_light_is_steady_and_none_is_dark() -> None:
    times = [0.0, 0.3, 7.7, 1e6]
    assert all(alarm_signal.is_lit(Priority.LOW, time_s) for time_s in times)
    assert not any(alarm_signal.is_lit(Priority.NONE, time_s) for time_s in times)
    assert alarm_signal.LIGHTS[Priority.LOW].colour == "cyan"


def test_every_priority_has_a_light_of_its_own() -> None:
    assert set(alarm_signal.LIGHTS) == set(Priority)
    assert len({light.colour for light in alarm_signal.LIGHTS.values()}) == len(Priority)


def test_what_is_not_there_has_no_range_either() -> None:
    for nothing in (alarm_signal.DARK.duty_ratio, alarm_signal.NO_HALF):
        assert (nothing.value, nothing.least, nothing.most) == (0.0, 0.0, 0.0)
