"""Encoder, second sensor and motor vote on where the head is: no single sample decides."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from opensuction.kernel.interface import Readings
from opensuction.safety.head import head_vote
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.invalid_ticks import INVALID_TICKS
from tests.safety.watchdog import DT_S, LIMITS, NAN, changed, sound
from tests.settled import settled

DRIVE = LIMITS.drive
SPEED_MM_PER_S = -15.0
"""On the way out."""
START_MM = 50.0
STEP_MM = 0.1
"""Of the second sensor."""
PLAY_MM = 0.1


def true_mm(tick: int) -> float:
    return START_MM + SPEED_MM_PER_S * DT_S * tick


def told(tick: int) -> Readings:
    """A sound machine in that tick: motor a play ahead of the head, which is read in steps."""
    head_mm = true_mm(tick)
    carriage_mm = math.floor((head_mm + PLAY_MM) / STEP_MM + 0.5) * STEP_MM
    return sound(head_mm)._replace(carriage_mm=carriage_mm)


step_vote = settled(head_vote.step)


def step(
    vote: HeadVote,
    readings: Readings,
    *,
    speed: float = SPEED_MM_PER_S,
    apart: bool = False,
    driven: bool = True,
) -> HeadVote:
    """A tick in which the motor turns as fast as it has done."""
    volts = SPEED_MM_PER_S / DRIVE.mm_per_s_per_v
    return step_vote(DRIVE, vote, readings, driven, volts, speed, apart, DT_S)


def going(ticks: int = 200) -> HeadVote:
    """On its way with nothing wrong."""
    vote = head_vote.start(START_MM, read=True)._replace(motor_mm_per_s=SPEED_MM_PER_S)
    for tick in range(1, ticks + 1):
        vote = step(vote, told(tick))
    return vote


def test_a_sound_machine_is_where_its_encoder_has_it() -> None:
    vote = going()
    assert vote.head_mm == vote.least_mm == vote.most_mm == true_mm(200)
    assert vote.jumped_mm == 0.0
    assert vote.encoder_odd == vote.surprised_ticks == vote.unseen_ticks == 0
    assert not vote.encoder_out
    assert not vote.carriage_out
    assert not vote.switched
    # By volts alone, and both sensors with it but for play and steps.
    assert vote.motor_mm_per_s == pytest.approx(SPEED_MM_PER_S)
    assert abs(vote.encoder_lead_mm) < 1e-9
    assert abs(vote.carriage_lead_mm) <= PLAY_MM + STEP_MM


@pytest.mark.requirement("OS-R09")
@given(off_mm=st.floats(-1e6, 1e6), sensor=st.sampled_from(["head_mm", "carriage_mm"]))
def test_one_sample_of_one_sensor_moves_the_head_nowhere(off_mm: float, sensor: str) -> None:
    before = going()
    wrong = told(201)._replace(**{sensor: getattr(told(201), sensor) + off_mm})
    vote = step(before, wrong)
    assert vote.head_mm == pytest.approx(true_mm(201), abs=head_vote.JUMP_MM + 1e-9)
    for tick in range(202, 240):
        vote = step(vote, told(tick))
        assert vote.head_mm == pytest.approx(true_mm(tick), abs=1e-6)
    assert not vote.encoder_out
    assert not vote.carriage_out
    assert vote.encoder_odd == 0


@pytest.mark.parametrize("off_mm", [-40.0, -5.0, -0.5, 0.5, 5.0, 40.0])
def test_an_encoder_that_stays_off_is_voted_out_after_ten_ticks(off_mm: float) -> None:
    vote = going()
    for tick in range(201, 211):
        assert not vote.encoder_out
        vote = step(vote, told(tick)._replace(head_mm=true_mm(tick) + off_mm))
        assert vote.head_mm == pytest.approx(true_mm(tick), abs=1e-6)
    assert vote.encoder_odd == head_vote.OUT_TICKS
    vote = step(vote, told(211)._replace(head_mm=true_mm(211) + off_mm))
    assert vote.encoder_out
    assert vote.switched
    # From here on the second sensor and the motor have the head.
    for tick in range(212, 1200):
        vote = step(vote, told(tick)._replace(head_mm=true_mm(tick) + off_mm))
        assert not vote.switched
        assert vote.head_mm == pytest.approx(true_mm(tick), abs=head_vote.CARRIAGE_MM + PLAY_MM)
    assert vote.encoder_out


def test_a_smaller_jump_than_the_sensors_step_and_play_is_taken_over_and_not_travelled() -> None:
    vote = going()
    for tick in (201, 202):
        vote = step(vote, told(tick)._replace(head_mm=true_mm(tick) + 0.2))
        assert vote.head_mm == pytest.approx(true_mm(tick))
    vote = step(vote, told(203)._replace(head_mm=true_mm(203) + 0.2))
    assert vote.head_mm == true_mm(203) + 0.2
    assert vote.jumped_mm == pytest.approx(0.2)
    for tick in range(204, 260):
        vote = step(vote, told(tick)._replace(head_mm=true_mm(tick) + 0.2))
        assert vote.head_mm == pytest.approx(true_mm(tick) + 0.2)
    assert vote.encoder_odd == 0


@pytest.mark.parametrize("late_ticks", [12, 20, -20])
def test_what_both_sensors_say_is_believed_in_the_third_tick_and_not_travelled(
    late_ticks: int,
) -> None:
    """Readings that begin to come late, or are late no more."""
    vote = going()
    for tick in range(201, 203):
        vote = step(vote, told(tick - late_ticks))
        assert vote.head_mm == pytest.approx(true_mm(tick))
        assert vote.jumped_mm == pytest.approx(0.0, abs=1e-9)
    vote = step(vote, told(203 - late_ticks))
    assert vote.head_mm == true_mm(203 - late_ticks)
    assert vote.jumped_mm == pytest.approx(-SPEED_MM_PER_S * DT_S * late_ticks)
    for tick in range(204, 230):
        vote = step(vote, told(tick - late_ticks))
        assert vote.head_mm == pytest.approx(true_mm(tick - late_ticks))
        assert vote.jumped_mm == pytest.approx(0.0, abs=1e-9)
    assert vote.encoder_odd == vote.surprised_ticks == 0
    assert not vote.encoder_out


@settings(max_examples=20)
@given(noise=st.lists(st.floats(-0.34, 0.34), min_size=400, max_size=400))
def test_a_noisy_encoder_gives_the_head_no_other_speed(noise: list[float]) -> None:
    """Within what the second sensor can tell, as a wheel that jitters: ridden out or voted out."""
    vote, speed = going(), SPEED_MM_PER_S
    for tick, off_mm in enumerate(noise, 201):
        before = vote.head_mm
        read = told(tick)
        apart = vote.encoder_odd > 0
        vote = step(vote, read._replace(head_mm=read.head_mm + off_mm), speed=speed, apart=apart)
        moved = vote.head_mm - before - vote.jumped_mm
        speed += (moved / DT_S - speed) * DT_S / 0.011
        assert abs(vote.head_mm - true_mm(tick)) <= head_vote.CARRIAGE_MM + PLAY_MM + STEP_MM
    assert abs(speed - SPEED_MM_PER_S) < 40.0


def test_an_encoder_that_is_missing_leaves_the_head_to_the_other_sensor() -> None:
    vote = going()
    for tick in range(201, 1200):
        vote = step(vote, told(tick)._replace(head_mm=NAN, head_valid=False))
        assert vote.unseen_ticks == 0
        assert vote.head_mm == pytest.approx(true_mm(tick), abs=head_vote.CARRIAGE_MM + PLAY_MM)
        assert vote.surprised_ticks == 0
    assert not vote.encoder_out


@pytest.mark.parametrize("off_mm", [-5.0, -0.9, 0.9, 5.0])
def test_one_sample_of_the_only_sensor_left_moves_the_head_nowhere(off_mm: float) -> None:
    vote = going()
    for tick in range(201, 400):
        wrong = off_mm if tick == 300 else 0.0
        read = told(tick)._replace(head_valid=False, carriage_mm=told(tick).carriage_mm + wrong)
        vote = step(vote, read)
        assert vote.head_mm == pytest.approx(true_mm(tick), abs=head_vote.CARRIAGE_MM + PLAY_MM)
        assert vote.surprised_ticks == (tick == 300)


@pytest.mark.parametrize(
    ("off_mm", "least_mm", "most_mm"),
    [
        (0.3, 0.0, 0.0),
        (1.0, 0.0, 1.0 - head_vote.CARRIAGE_MM),
        (-1.0, head_vote.CARRIAGE_MM - 1.0, 0.0),
    ],
)
def test_the_head_is_between_what_either_sensor_has_it_at_least(
    off_mm: float, least_mm: float, most_mm: float
) -> None:
    here = true_mm(201)
    vote = step(going(), told(201)._replace(carriage_mm=here + off_mm))
    assert vote.head_mm == here
    assert vote.least_mm == pytest.approx(here + least_mm)
    assert vote.most_mm == pytest.approx(here + most_mm)
    alone = step(going(), told(201)._replace(carriage_mm=here + off_mm, carriage_valid=False))
    assert alone.least_mm == alone.most_mm == here


def test_what_an_odd_encoder_has_gone_meanwhile_is_taken_over_and_not_travelled() -> None:
    vote = step(going(), told(201)._replace(head_mm=true_mm(201) + 5.0))
    assert vote.encoder_odd == head_vote.BAD_TICKS
    for tick in range(202, 201 + head_vote.BAD_TICKS):
        vote = step(vote, told(tick)._replace(head_mm=true_mm(tick) + 0.1))
        assert vote.head_mm == pytest.approx(true_mm(tick))
        assert vote.jumped_mm == 0.0
    vote = step(vote, told(205)._replace(head_mm=true_mm(205) + 0.1))
    assert (vote.head_mm, vote.encoder_odd) == (true_mm(205) + 0.1, 0)
    assert vote.jumped_mm == pytest.approx(0.1)
    vote = step(vote, told(206)._replace(head_mm=true_mm(206) + 0.1))
    assert vote.jumped_mm == 0.0


def test_with_neither_sensor_the_head_stays_where_it_was_seen_and_is_found_again() -> None:
    vote = going()
    blind = told(201)._replace(head_valid=False, carriage_valid=False)
    for ticks in range(1, 40):
        vote = step(vote, blind)
        assert (vote.head_mm, vote.unseen_ticks, vote.jumped_mm) == (true_mm(200), ticks, 0.0)
    found = step(vote, told(2000))
    assert found.head_mm == true_mm(2000)
    # It has travelled there.
    assert (found.unseen_ticks, found.jumped_mm) == (0, 0.0)
    apart = step(vote, told(2000)._replace(carriage_mm=45.0))
    assert apart.head_mm == 45.0  # the deeper of two that differ


def test_fewer_than_five_ticks_without_a_reading_are_a_pause_in_a_motion() -> None:
    vote = going()
    for _ in range(INVALID_TICKS - 1):
        vote = step(vote, told(201)._replace(head_valid=False, carriage_valid=False))
    found = step(vote, told(205))
    assert found.head_mm == true_mm(205)
    assert found.jumped_mm == 0.0
    wrong = step(vote, told(205)._replace(head_mm=true_mm(205) + 3.0))
    assert wrong.head_mm == pytest.approx(true_mm(205))


@pytest.mark.parametrize(
    ("encoder", "carriage", "odd"),
    [
        (0.0, 1.0, "encoder"),  # frozen
        (-1.0, 1.0, "encoder"),  # counts the wrong way
        (0.6, 1.0, "encoder"),  # slips
        (1.0, 0.0, "carriage"),  # frozen, or the gear has parted
        (1.0, 0.5, "carriage"),
        (0.0, 0.0, None),  # the head is held: both say so
        (1.0, 1.0, None),
    ],
)
def test_of_two_that_part_the_one_is_out_that_the_motor_does_not_bear_out(
    encoder: float, carriage: float, odd: str | None
) -> None:
    vote = going()
    here = true_mm(200)
    for tick in range(201, 400):
        moved = true_mm(tick) - here
        read = sound(here + encoder * moved)._replace(carriage_mm=here + carriage * moved)
        vote = step(vote, read, speed=encoder * SPEED_MM_PER_S, apart=tick > 390)
    assert vote.encoder_out == (odd == "encoder")
    assert vote.carriage_out == (odd == "carriage")
    expected = carriage if odd == "encoder" else encoder
    assert vote.head_mm == pytest.approx(here + expected * moved, abs=1e-6)


def test_without_torque_the_motor_tells_nothing() -> None:
    vote = going()
    for tick in range(201, 260):
        vote = step(vote, told(tick)._replace(carriage_mm=true_mm(200)), driven=False, apart=True)
    assert vote.motor_mm_per_s == vote.encoder_lead_mm == vote.carriage_lead_mm == 0.0
    assert not vote.encoder_out
    assert not vote.carriage_out


@pytest.mark.parametrize("silent", [{"carriage_valid": False}, {"carriage_mm": NAN}])
def test_nobody_is_voted_out_whose_other_does_not_speak(silent: dict[str, object]) -> None:
    vote = going()
    for tick in range(201, 260):
        read = changed(told(tick)._replace(head_mm=true_mm(tick) + 5.0), silent)
        vote = step(vote, read, apart=True)
    assert not vote.encoder_out
    # The only one left is believed, after three ticks.
    assert vote.head_mm == true_mm(259) + 5.0


def test_a_reset_hears_both_again() -> None:
    out = going()._replace(encoder_out=True, carriage_out=True, encoder_odd=12, surprised_ticks=2)
    again = head_vote.reset(out)
    assert not again.encoder_out
    assert not again.carriage_out
    assert again.encoder_odd == again.surprised_ticks == 0
    assert again.encoder_lead_mm == again.carriage_lead_mm == 0.0
    assert step(again, told(900)).head_mm == true_mm(900)


@pytest.mark.parametrize(
    ("encoder_mm", "carriage_mm", "first_mm"),
    [
        (30.0, 30.1, 30.0),
        (30.0, 30.3, 30.0),
        (30.0, 30.4, 30.4),
        (31.0, 30.0, 31.0),
        (NAN, 30.0, 30.0),
        (30.0, NAN, 30.0),
        (NAN, NAN, NAN),
    ],
)
def test_at_power_up_the_deeper_of_two_that_differ_counts(
    encoder_mm: float, carriage_mm: float, first_mm: float
) -> None:
    read = sound(encoder_mm)._replace(carriage_mm=carriage_mm)
    assert head_vote.first_mm(read) == pytest.approx(first_mm, nan_ok=True)
    lost = read._replace(head_valid=False)
    assert head_vote.first_mm(lost) == pytest.approx(carriage_mm, nan_ok=True)


def test_the_current_limit_rules_the_motor_where_it_is_reached() -> None:
    vote = going()
    limited = told(201)._replace(insertion_current_a=-5.0 / DRIVE.newton_per_a)
    # It slows by as much as such a drive does at least and at most, and as was measured between.
    least_mm_per_s, most_mm_per_s = 0.1, 0.6
    for measured, slower in ((0.05, least_mm_per_s), (0.3, 0.3), (2.0, most_mm_per_s)):
        speed = vote.motor_mm_per_s - measured
        after = step_vote(DRIVE, vote, limited, True, -24.0, speed, False, DT_S)
        assert after.motor_mm_per_s == pytest.approx(vote.motor_mm_per_s - slower)
    # Below it the back-EMF does.
    current_a = -1.0 / DRIVE.newton_per_a
    free = told(201)._replace(insertion_current_a=current_a)
    after = step_vote(DRIVE, vote, free, True, -20.0, SPEED_MM_PER_S, False, DT_S)
    back_v = -20.0 - DRIVE.volts_per_a * current_a
    assert after.motor_mm_per_s == pytest.approx(DRIVE.mm_per_s_per_v * back_v)
    # No faster than a drive can change its speed.
    slowed = step_vote(DRIVE, vote, free, True, 0.0, SPEED_MM_PER_S, False, DT_S)
    assert slowed.motor_mm_per_s == pytest.approx(vote.motor_mm_per_s + most_mm_per_s)
    for _ in range(500):
        after = step_vote(DRIVE, after, limited, True, -24.0, -99.0, False, DT_S)
    assert after.motor_mm_per_s == pytest.approx(-DRIVE.mm_per_s_per_v * DRIVE.supply_v)


@pytest.mark.requirement("OS-R09")
@pytest.mark.parametrize("drift_mm_per_s", [-18.0, -9.0, 9.0, 18.0])
@pytest.mark.parametrize("sensor", ["head_mm", "carriage_mm"])
def test_a_drift_while_the_drive_is_at_its_limit_does_not_make_the_other_one_odd(
    sensor: str, drift_mm_per_s: float
) -> None:
    """A reversal on contact: the motor's volts say nothing, and its speed is the measured one."""
    gain_mm_per_s2, limited_s = -150.0, 0.1
    limited_a = -0.9 * DRIVE.force_n / DRIVE.newton_per_a
    vote, head_mm = head_vote.start(START_MM, read=True), START_MM
    for tick in range(1, 500):
        time_s = tick * DT_S
        limited = time_s <= limited_s
        speed = gain_mm_per_s2 * time_s if limited else SPEED_MM_PER_S
        head_mm += speed * DT_S
        read = sound(head_mm)._replace(insertion_current_a=limited_a if limited else 0.0)
        read = changed(read, {sensor: head_mm + drift_mm_per_s * time_s})
        led = sensor == "head_mm" and not vote.encoder_out
        apart = abs(drift_mm_per_s) * time_s > head_vote.CARRIAGE_MM and time_s > 0.08
        vote = step(vote, read, speed=speed + drift_mm_per_s * led, apart=apart)
    assert vote.encoder_out == (sensor == "head_mm")
    assert vote.carriage_out == (sensor == "carriage_mm")
    assert vote.head_mm == pytest.approx(head_mm, abs=head_vote.CARRIAGE_MM + PLAY_MM)
