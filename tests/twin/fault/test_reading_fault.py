"""Faults of sensors: each changes its reading as its row says, and no other."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import NO_MONITOR, Readings
from opensuction.twin.fault import reading_fault
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import FaultOnset, ReadingEffect, for_good
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.fault.reading_fault import HEALTHY, JUMP_TICKS, Channel, Mode, ReadingFault

AT_INSTANT = Readings(
    head_mm=40.0,
    head_valid=True,
    carriage_mm=40.0,
    carriage_valid=True,
    cam_rad=0.3,
    cam_valid=True,
    line_vacuum_mmhg=100.0,
    vacuum_valid=True,
    contact_closed=False,
    contact_valid=True,
    mouth_clear=True,
    insertion_current_a=0.02,
    monitor=NO_MONITOR,
)
LATER = AT_INSTANT._replace(head_mm=50.0, carriage_mm=50.0, cam_rad=0.1, line_vacuum_mmhg=80.0)
PRESSED = LATER._replace(contact_closed=True)
VALUES = {
    Channel.HEAD: {"head_mm"},
    Channel.CARRIAGE: {"carriage_mm"},
    Channel.CAM: {"cam_rad"},
    Channel.VACUUM: {"line_vacuum_mmhg"},
    Channel.CONTACT: {"contact_closed"},
    Channel.CURRENT: {"insertion_current_a"},
    Channel.HEADS: {"head_mm", "carriage_mm"},
}
VALID = {
    Channel.HEAD: "head_valid",
    Channel.CARRIAGE: "carriage_valid",
    Channel.CAM: "cam_valid",
    Channel.VACUUM: "vacuum_valid",
    Channel.CONTACT: "contact_valid",
}
EFFECTS = {
    fault: row.effect for fault, row in ROWS.items() if isinstance(row.effect, ReadingEffect)
}


INSTANT = 5
"""Tick in which faults begin."""
DT_S = 0.001


def begun(fault: Fault, strength: float = 0.0, seed: int = 1) -> ReadingFault:
    return ROWS[fault].change_reading(FaultOnset(strength, INSTANT, DT_S), AT_INSTANT, seed)


def seen(fault: Fault, strength: float = 0.0, tick: int = 7, true: Readings = LATER) -> Readings:
    """What is read later, under a fault that began at the instant."""
    return reading_fault.apply(begun(fault, strength), true, tick)


def acting_ticks(fault: Fault, strength: float, true: Readings = PRESSED) -> list[int]:
    """Ticks after the instant in which something else is read than what is."""
    broken = begun(fault, strength)
    return [
        tick - INSTANT
        for tick in range(INSTANT, INSTANT + 1000)
        if reading_fault.apply(broken, true, tick) != true
    ]


def test_healthy_sensors_report_what_is() -> None:
    assert reading_fault.apply(HEALTHY, LATER, 7) == LATER


@pytest.mark.parametrize("fault", EFFECTS, ids=lambda fault: fault.title)
def test_a_fault_leaves_all_other_readings_alone(fault: Fault) -> None:
    channel = EFFECTS[fault].channel
    may = {*VALUES[channel], VALID.get(channel)}
    broken = begun(fault, ROWS[fault].default_strength)
    touched = set()
    for tick in range(INSTANT, INSTANT + 100):
        read = reading_fault.apply(broken, PRESSED, tick)._asdict()
        touched |= {name for name, value in read.items() if value != getattr(PRESSED, name)}
    assert touched
    assert touched <= may


@pytest.mark.parametrize(
    ("fault", "name"),
    [
        (Fault.ENCODER_FROZEN, "head_mm"),
        (Fault.CARRIAGE_SENSOR_FROZEN, "carriage_mm"),
        (Fault.CAM_ENCODER_FROZEN, "cam_rad"),
        (Fault.VACUUM_SENSOR_FROZEN, "line_vacuum_mmhg"),
    ],
)
def test_a_frozen_reading_stays_where_it_was(fault: Fault, name: str) -> None:
    assert getattr(seen(fault), name) == getattr(AT_INSTANT, name)


@given(share=st.floats(0.01, 1.0), head_mm=st.floats(-100.0, 100.0))
def test_a_slipping_encoder_misses_its_share_of_the_motion(share: float, head_mm: float) -> None:
    read = seen(Fault.ENCODER_SLIPPING, share, true=LATER._replace(head_mm=head_mm)).head_mm
    moved = head_mm - AT_INSTANT.head_mm
    assert read - AT_INSTANT.head_mm == pytest.approx((1.0 - share) * moved, abs=1e-9)


def test_a_reversed_encoder_counts_backwards_from_where_it_was() -> None:
    assert seen(Fault.ENCODER_REVERSED).head_mm == 30.0


def test_an_offset_is_added() -> None:
    assert seen(Fault.VACUUM_SENSOR_OFFSET, -50.0).line_vacuum_mmhg == 30.0
    assert seen(Fault.ENCODER_OFFSET, -5.0).head_mm == 45.0


def test_noise_has_its_deviation_and_no_mean() -> None:
    noise = [seen(Fault.VACUUM_SENSOR_NOISY, 20.0, tick).line_vacuum_mmhg for tick in range(4000)]
    error = np.array(noise) - LATER.line_vacuum_mmhg
    # Four standard deviations of the mean, and of the deviation, of 4,000 normal draws.
    assert abs(float(np.mean(error))) < 4.0 * 20.0 / math.sqrt(4000)
    assert float(np.std(error)) == pytest.approx(20.0, rel=4.0 / math.sqrt(2 * 4000))


def test_a_jumping_encoder_jumps_within_bounds_and_holds_in_between() -> None:
    read = [seen(Fault.ENCODER_JUMPING, 5.0, tick).head_mm for tick in range(20 * JUMP_TICKS)]
    off = np.array(read).reshape(20, JUMP_TICKS) - LATER.head_mm
    assert np.all(off == off[:, :1])
    assert np.all(np.abs(off) <= 5.0)
    assert len(set(off[:, 0])) == 20


@pytest.mark.parametrize(
    "fault",
    [
        fault
        for fault, effect in EFFECTS.items()
        if effect.mode == Mode.INVALID and effect.spell == for_good
    ],
    ids=lambda fault: fault.title,
)
def test_an_invalid_reading_says_so(fault: Fault) -> None:
    channel = EFFECTS[fault].channel
    read = seen(fault)
    assert not getattr(read, VALID[channel])
    if channel != Channel.CONTACT:
        assert all(math.isnan(getattr(read, name)) for name in VALUES[channel])


def test_a_dead_current_sensor_reads_nothing() -> None:
    assert seen(Fault.CURRENT_SENSOR_DEAD).insertion_current_a == 0.0


def test_the_same_seed_gives_the_same_chance() -> None:
    first, other = (
        [
            reading_fault.apply(begun(Fault.ENCODER_NOISY, 1.0, seed), LATER, tick).head_mm
            for tick in range(INSTANT, INSTANT + 5)
        ]
        for seed in (1, 2)
    )
    assert first != other
    assert first[3] == seen(Fault.ENCODER_NOISY, 1.0, tick=INSTANT + 3).head_mm


GLITCHES = {
    Fault.ENCODER_GLITCH: "head_mm",
    Fault.CARRIAGE_GLITCH: "carriage_mm",
    Fault.CAM_GLITCH: "cam_rad",
    Fault.VACUUM_GLITCH: "line_vacuum_mmhg",
    Fault.CURRENT_GLITCH: "insertion_current_a",
}


@pytest.mark.parametrize("fault", GLITCHES, ids=lambda fault: fault.title)
def test_a_glitch_is_one_wrong_sample(fault: Fault) -> None:
    strength, name = ROWS[fault].default_strength, GLITCHES[fault]
    assert acting_ticks(fault, strength) == [0]
    wrong = getattr(seen(fault, strength, INSTANT), name)
    assert wrong == pytest.approx(getattr(LATER, name) + strength)


@pytest.mark.parametrize("closed", [True, False])
def test_a_glitch_of_the_contact_reads_the_opposite(closed: bool) -> None:
    true = LATER._replace(contact_closed=closed)
    assert acting_ticks(Fault.CONTACT_GLITCH, 0.0, true) == [0]
    assert seen(Fault.CONTACT_GLITCH, tick=INSTANT, true=true).contact_closed != closed


@pytest.mark.parametrize(
    "fault",
    [Fault.ENCODER_INTERMITTENT, Fault.CARRIAGE_INTERMITTENT, Fault.CONTACT_INTERMITTENT],
    ids=lambda fault: fault.title,
)
@pytest.mark.parametrize("turn", [1, 4, 50])
def test_what_comes_and_goes_is_there_every_other_turn(fault: Fault, turn: int) -> None:
    expected = [tick for tick in range(1000) if tick // turn % 2 == 0]
    assert acting_ticks(fault, turn * DT_S) == expected


@pytest.mark.parametrize("fault", [Fault.ENCODER_ALTERNATING, Fault.CARRIAGE_ALTERNATING])
def test_an_alternating_reading_is_off_for_a_tenth_of_a_second_at_a_time(fault: Fault) -> None:
    assert acting_ticks(fault, 3.0) == [tick for tick in range(1000) if tick // 100 % 2 == 0]


def test_a_wire_that_opens_by_turns_never_closes_the_contact() -> None:
    assert acting_ticks(Fault.CONTACT_INTERMITTENT, 0.05, LATER) == []


def test_a_pulse_of_the_current_lasts_sixty_milliseconds() -> None:
    assert acting_ticks(Fault.CURRENT_PULSE, 0.02) == list(range(60))
    assert seen(Fault.CURRENT_PULSE, 0.02).insertion_current_a == pytest.approx(0.04)


@pytest.mark.parametrize(
    ("fault", "name"),
    [
        (Fault.ENCODER_DRIFTING, "head_mm"),
        (Fault.CARRIAGE_DRIFTING, "carriage_mm"),
        (Fault.VACUUM_SENSOR_DRIFTING, "line_vacuum_mmhg"),
        (Fault.HEAD_SENSORS_DRIFTING, "head_mm"),
        (Fault.HEAD_SENSORS_DRIFTING, "carriage_mm"),
    ],
)
def test_a_drift_grows_by_its_rate(fault: Fault, name: str) -> None:
    for tick in (0, 1, 500, 30_000):
        off = getattr(seen(fault, -0.5, INSTANT + tick), name) - getattr(LATER, name)
        assert off == pytest.approx(-0.5 * tick * DT_S, abs=1e-9)


def test_two_sensors_that_drift_together_agree() -> None:
    read = seen(Fault.HEAD_SENSORS_DRIFTING, -0.2, 10_000)
    assert read.head_mm == read.carriage_mm
