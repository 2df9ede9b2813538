from itertools import pairwise

import pytest

from opensuction.twin.patient import patient_monitor
from opensuction.twin.patient.patient_monitor import OximeterState

DT_S = 0.01
METER = patient_monitor.of_delay(20.0, 8.0)


def show(saturations: list[float], start: float = 0.97) -> list[float]:
    """Shown percentages, one a step, for a second of each given saturation."""
    state: OximeterState = patient_monitor.at_rest(start)
    shown = []
    for saturation in saturations:
        for _ in range(100):
            state = patient_monitor.step(METER, state, saturation, DT_S)
            shown.append(state.shown_percent)
    return shown


def test_a_steady_saturation_is_shown() -> None:
    assert show([0.97] * 60) == pytest.approx([97.0] * 6000)


def test_a_fall_is_shown_late_and_smoothed() -> None:
    shown = show([0.90] * 40)
    assert shown[1999] == pytest.approx(97.0)  # nothing for 20 s
    assert shown[2400] == pytest.approx(93.5, abs=0.5)  # half of it after half of the window
    assert shown[2900] == pytest.approx(90.0)
    assert all(after <= before + 1e-9 for before, after in pairwise(shown))


def test_a_short_dip_is_shown_shallower_than_it_was() -> None:
    shown = show([0.80] * 2 + [0.97] * 48)
    assert min(shown) == pytest.approx(97.0 - 17.0 * 2.0 / 8.0)


def test_the_display_changes_twice_a_second() -> None:
    shown = show([0.97 - 0.001 * k for k in range(40)])
    changes = [i for i in range(1, len(shown)) if shown[i] != shown[i - 1]]
    assert changes
    assert all((i + 1) % 50 == 0 for i in changes)


def test_what_it_cannot_remember_is_cut() -> None:
    longest = patient_monitor.of_delay(500.0, 500.0)
    assert longest.delay_samples + longest.average_samples <= patient_monitor.MEMORY
    quickest = patient_monitor.of_delay(0.0, 0.0)
    assert (quickest.delay_samples, quickest.average_samples) == (0, 1)
