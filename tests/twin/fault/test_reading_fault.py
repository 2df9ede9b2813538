"""Faults of sensors: each changes its reading as its row says, and no other."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.readings import NO_MONITOR, Readings
from opensuction.twin.fault import reading_fault
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import ReadingEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.fault.reading_fault import HEALTHY, JUMP_TICKS, Channel, Mode

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
    insertion_current_a=0.02,
    monitor=NO_MONITOR,
)
LATER = AT_INSTANT._replace(head_mm=50.0, carriage_mm=50.0, cam_rad=0.1, line_vacuum_mmhg=80.0)
VALUES = {
    Channel.HEAD: "head_mm",
    Channel.CARRIAGE: "carriage_mm",
    Channel.CAM: "cam_rad",
    Channel.VACUUM: "line_vacuum_mmhg",
    Channel.CONTACT: "contact_closed",
    Channel.CURRENT: "insertion_current_a",
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


def seen(fault: Fault, strength: float = 0.0, tick: int = 7, true: Readings = LATER) -> Readings:
    """What is read later, under a fault that began at the instant."""
    broken = ROWS[fault].change_reading(strength, AT_INSTANT, seed=1)
    return reading_fault.apply(broken, true, tick)


def test_healthy_sensors_report_what_is() -> None:
    assert reading_fault.apply(HEALTHY, LATER, 7) == LATER


@pytest.mark.parametrize("fault", EFFECTS, ids=lambda fault: fault.title)
def test_a_fault_leaves_all_other_readings_alone(fault: Fault) -> None:
    channel = EFFECTS[fault].channel
    read = seen(fault, ROWS[fault].default_strength)._asdict()
    touched = {VALUES[channel], VALID.get(channel)}
    assert {name for name, value in read.items() if value != getattr(LATER, name)} <= touched
    assert read != LATER._asdict()


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
    [fault for fault, effect in EFFECTS.items() if effect.mode == Mode.INVALID],
    ids=lambda fault: fault.title,
)
def test_an_invalid_reading_says_so(fault: Fault) -> None:
    channel = EFFECTS[fault].channel
    read = seen(fault)
    assert not getattr(read, VALID[channel])
    if channel != Channel.CONTACT:
        assert math.isnan(getattr(read, VALUES[channel]))


def test_a_dead_current_sensor_reads_nothing() -> None:
    assert seen(Fault.CURRENT_SENSOR_DEAD).insertion_current_a == 0.0


def test_the_same_seed_gives_the_same_chance() -> None:
    first, other = (
        [
            reading_fault.apply(
                ROWS[Fault.ENCODER_NOISY].change_reading(1.0, AT_INSTANT, seed), LATER, tick
            ).head_mm
            for tick in range(5)
        ]
        for seed in (1, 2)
    )
    assert first != other
    assert first[3] == seen(Fault.ENCODER_NOISY, 1.0, tick=3).head_mm
