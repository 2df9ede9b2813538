import itertools

import numpy as np
import pytest
from scipy.signal import hilbert

from docs.generator.alarm_table import VALUES
from opensuction.kernel.errors import InputError
from opensuction.safety.alarm import alarm_signal, alarm_state
from opensuction.safety.alarm.alarm_signal import Samples
from opensuction.safety.handling import Priority

RATE_HZ = 48_000.0
SOUNDING = [Priority.HIGH, Priority.MEDIUM, Priority.LOW]


def loudness(samples: Samples) -> Samples:
    """Envelope as heard, 0 to 1: magnitude of the analytic signal, its peaks joined.

    Beating of the harmonics is bridged by the largest value within a period of the lowest tone.
    """
    magnitude = np.abs(hilbert(samples))
    window = round(RATE_HZ / 300.0)
    padded = np.pad(magnitude, window // 2, mode="edge")
    joined = np.lib.stride_tricks.sliding_window_view(padded, window).max(axis=1)
    return np.asarray(joined / joined.max())


def edges_s(samples: Samples, level: float) -> tuple[Samples, Samples]:
    """Times at which the loudness rises and falls through a level, s."""
    above = loudness(samples) > level
    steps = np.diff(above.astype(np.int8), prepend=0, append=0)
    return np.flatnonzero(steps == 1) / RATE_HZ, np.flatnonzero(steps == -1) / RATE_HZ


TOLERANCE_S = 0.005
"""The bridging above widens a pulse by up to a window, 3.3 ms."""


def measured(priority: Priority) -> tuple[Samples, Samples]:
    """Lengths of the pulses of a burst and the pauses between them, from its samples, s."""
    rises, falls = edges_s(alarm_signal.burst(priority, RATE_HZ), 0.9)
    return falls - rises, rises[1:] - falls[:-1]


def test_high_is_ten_pulses_in_threes_and_twos_twice() -> None:
    lengths_s, pauses_s = measured(Priority.HIGH)
    assert lengths_s.size == 10
    assert ((lengths_s > 0.075) & (lengths_s < 0.200)).all()
    short = pauses_s[[0, 1, 3, 5, 6, 8]]
    assert ((short > 0.050) & (short < 0.125)).all()
    between_groups = 2.0 * short.mean() + lengths_s.mean()
    assert pauses_s[[2, 7]] == pytest.approx([between_groups] * 2, abs=2 * TOLERANCE_S)
    assert 0.35 < pauses_s[4] < 1.3
    assert pauses_s[4] > pauses_s[2]


def test_medium_is_three_equal_pulses_slower_than_high() -> None:
    lengths_s, pauses_s = measured(Priority.MEDIUM)
    assert lengths_s.size == 3
    assert ((lengths_s > 0.125) & (lengths_s < 0.250)).all()
    assert ((pauses_s > 0.125) & (pauses_s < 0.250)).all()
    assert np.ptp(pauses_s) < TOLERANCE_S
    assert pauses_s.min() > measured(Priority.HIGH)[1][0]


@pytest.mark.parametrize(("priority", "count"), [(Priority.LOW, 2), (Priority.NONE, 1)])
def test_low_is_two_pulses_and_the_reminder_one(priority: Priority, count: int) -> None:
    lengths_s, pauses_s = measured(priority)
    assert lengths_s.size == count
    assert ((lengths_s > 0.125) & (lengths_s < 0.250)).all()
    assert ((pauses_s > 0.125) & (pauses_s < 0.250)).all()


@pytest.mark.parametrize("priority", SOUNDING)
def test_the_samples_have_the_timing_of_the_table(priority: Priority) -> None:
    rises, falls = edges_s(alarm_signal.burst(priority, RATE_HZ), 0.9)
    table = alarm_signal.pulses(priority)
    first = rises[0]
    np.testing.assert_allclose(rises - first, [p.start_s for p in table], atol=TOLERANCE_S)
    np.testing.assert_allclose(falls - first, [p.end_s for p in table], atol=TOLERANCE_S)


@pytest.mark.parametrize("priority", SOUNDING)
def test_a_pulse_rises_and_falls_in_ten_to_twenty_percent_of_its_length(
    priority: Priority,
) -> None:
    samples = alarm_signal.burst(priority, RATE_HZ)
    (low_rises, low_falls), (rises, falls) = edges_s(samples, 0.1), edges_s(samples, 0.9)
    pulse_s = (falls - rises).mean()
    for share in (*((rises - low_rises) / pulse_s), *((low_falls - falls) / pulse_s)):
        assert 0.10 < share < 0.20


@pytest.mark.parametrize("priority", [*SOUNDING, Priority.NONE])
def test_a_burst_begins_and_ends_in_silence_and_is_never_clipped(priority: Priority) -> None:
    samples = alarm_signal.burst(priority, RATE_HZ)
    assert np.abs(samples).max() <= 1.0
    assert np.abs(samples).max() > 0.5
    assert abs(samples[0]) < 1e-6
    assert abs(samples[-1]) < 1e-3
    steps = np.abs(np.diff(samples))
    assert steps.max() < 0.35, "no clicks: slope of the highest harmonic at most"
    assert samples.size / RATE_HZ == pytest.approx(
        alarm_signal.burst_s(priority), abs=1.0 / RATE_HZ
    )


@pytest.mark.parametrize("priority", SOUNDING)
def test_the_spectrum_has_a_low_fundamental_and_four_harmonics_of_like_level(
    priority: Priority,
) -> None:
    samples = alarm_signal.burst(priority, RATE_HZ)
    pulse = alarm_signal.pulses(priority)[0]
    edge = alarm_signal.edge_s(priority)
    steady = samples[round(edge * RATE_HZ) : round((pulse.end_s + 0.5 * edge) * RATE_HZ)]
    windowed = steady * np.blackman(steady.size)
    level = np.abs(np.fft.rfft(windowed, n=2**18))
    hz = np.fft.rfftfreq(2**18, 1.0 / RATE_HZ)
    peaks = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])) + 1
    strong = peaks[level[peaks] > level.max() * 10.0 ** (-15.0 / 20.0)]
    fundamental_hz = hz[strong[0]]
    assert 150.0 < fundamental_hz < 1000.0
    assert fundamental_hz == pytest.approx(
        alarm_signal.TONES[priority].fundamental_hz.value, rel=0.01
    )
    # Each of the strong lines is a whole multiple of the fundamental.
    assert hz[strong] / fundamental_hz == pytest.approx(np.arange(1, strong.size + 1), rel=0.01)
    assert ((hz[strong] > 300.0) & (hz[strong] < 4000.0)).sum() >= 4
    fundamental_db = 20.0 * np.log10(level[strong] / level[strong[0]])
    assert (np.abs(fundamental_db) <= 15.0).all()
    assert fundamental_db == pytest.approx(-3.0 * np.arange(strong.size), abs=0.5)
    # Nothing else is heard.
    rest = level.copy()
    for peak in strong:
        rest[np.abs(hz - hz[peak]) < 50.0] = 0.0
    assert rest.max() < 0.02 * level.max()


@pytest.mark.parametrize(
    ("priority", "least_s", "most_s"),
    [(Priority.HIGH, 2.5, 15.0), (Priority.MEDIUM, 2.5, 30.0), (Priority.LOW, 15.0, 60.0)],
)
def test_bursts_repeat_after_their_interval(
    priority: Priority, least_s: float, most_s: float
) -> None:
    samples = alarm_signal.repeat(priority, 40.0, RATE_HZ)
    assert samples.size == round(40.0 * RATE_HZ)
    one = alarm_signal.burst(priority, RATE_HZ)
    np.testing.assert_array_equal(samples[: one.size], one)
    rises, falls = edges_s(samples, 0.9)
    count = len(alarm_signal.pulses(priority))
    bursts = rises.size // count
    assert bursts >= 2
    pauses_s = rises[count::count] - falls[count - 1 :: count][: rises[count::count].size]
    assert ((pauses_s > least_s) & (pauses_s < most_s)).all()
    assert np.ptp(pauses_s) < TOLERANCE_S


def test_more_urgent_sounds_denser_higher_and_with_more_pulses() -> None:
    tones = [alarm_signal.TONES[priority] for priority in SOUNDING]
    for urgent, calm in itertools.pairwise(tones):
        assert urgent.interval_s.value < calm.interval_s.value
        assert urgent.pause_s.value <= calm.pause_s.value
        # A whole tone or more apart.
        assert urgent.fundamental_hz.value / calm.fundamental_hz.value > 1.12
    counts = [len(alarm_signal.pulses(priority)) for priority in SOUNDING]
    assert counts == [10, 3, 2]
    shares = [
        float((np.abs(alarm_signal.repeat(priority, 60.0, RATE_HZ)) > 0.0).mean())
        for priority in SOUNDING
    ]
    assert shares[0] > 2.0 * shares[1] > 4.0 * shares[2]


def test_a_piece_cut_short_ends_within_a_burst() -> None:
    whole = alarm_signal.burst(Priority.HIGH, RATE_HZ)
    piece = alarm_signal.repeat(Priority.HIGH, 1.0, RATE_HZ)
    np.testing.assert_array_equal(piece, whole[: piece.size])
    assert alarm_signal.repeat(Priority.HIGH, 0.0, RATE_HZ).size == 0


def test_a_rate_too_low_for_the_highest_harmonic_is_refused() -> None:
    with pytest.raises(InputError, match="6000 Hz; the high alarm needs more than 6600 Hz"):
        alarm_signal.burst(Priority.HIGH, 6000.0)
    with pytest.raises(InputError, match="nan Hz"):
        alarm_signal.burst(Priority.HIGH, float("nan"))
    assert alarm_signal.burst(Priority.HIGH, 8000.0).size > 0


def test_the_sound_owed_between_two_pauses_holds_a_whole_high_burst() -> None:
    assert alarm_signal.burst_s(Priority.HIGH) <= alarm_state.AUDIBLE_S


def test_every_value_lies_in_its_range_and_says_where_the_range_is_from() -> None:
    for value in VALUES.values():
        assert value.least <= value.value <= value.most
        assert value.source


@pytest.mark.parametrize("priority", SOUNDING)
def test_a_pulse_is_between_its_points_at_ninety_percent(priority: Priority) -> None:
    """The burst begins with the foot of the first rise and ends with that of the last fall."""
    foot_s = alarm_signal.NINETY_PERCENT * alarm_signal.edge_s(priority)
    pulses = alarm_signal.pulses(priority)
    marks_s = np.array([mark + foot_s for pulse in pulses for mark in pulse])
    levels = alarm_signal.envelope(priority, marks_s)
    assert levels == pytest.approx(0.9)
    end_s = alarm_signal.burst_s(priority)
    just_before_s = end_s - 0.1 * alarm_signal.edge_s(priority)
    ends = alarm_signal.envelope(priority, np.array([0.0, just_before_s, end_s, end_s + 0.1]))
    assert ends == pytest.approx([0.0, 0.5 * (1.0 - np.cos(0.1 * np.pi)), 0.0, 0.0])


@pytest.mark.parametrize("priority", SOUNDING)
def test_each_harmonic_has_its_share_of_the_sound(priority: Priority) -> None:
    """Over whole periods of a pulse's plateau the harmonics are found one by one."""
    fundamental_hz = alarm_signal.TONES[priority].fundamental_hz.value
    first = alarm_signal.pulses(priority)[0]
    edge_s = alarm_signal.edge_s(priority)
    periods = np.floor((first.end_s - edge_s) * fundamental_hz)
    samples = alarm_signal.burst(priority, RATE_HZ)
    time_s = np.arange(samples.size) / RATE_HZ
    plateau = (time_s >= edge_s) & (time_s < edge_s + periods / fundamental_hz)
    orders = np.arange(1, int(alarm_signal.HARMONICS.value) + 1)
    found = [
        2.0 * np.mean(samples[plateau] * np.sin(2.0 * np.pi * k * fundamental_hz * time_s[plateau]))
        for k in orders
    ]
    levels = 10.0 ** (alarm_signal.HARMONIC_DB.value * (orders - 1) / 20.0)
    assert found == pytest.approx(list(levels / levels.sum()), abs=0.02 * levels[0] / levels.sum())


@pytest.mark.parametrize("priority", SOUNDING)
def test_twice_the_highest_harmonic_is_not_rate_enough(priority: Priority) -> None:
    least_hz = 2.0 * alarm_signal.HARMONICS.value
    least_hz *= alarm_signal.TONES[priority].fundamental_hz.value
    with pytest.raises(InputError, match="needs more than"):
        alarm_signal.burst(priority, least_hz)
    assert alarm_signal.burst(priority, least_hz + 1.0).size > 0
