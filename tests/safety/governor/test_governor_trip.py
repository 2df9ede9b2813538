"""Each limit, a fault that attacks it, and what the governor does about it in what time."""

import math
from typing import Any

import pytest

from opensuction.kernel.interface import Readings, Setpoints
from opensuction.safety.condition import Condition
from opensuction.safety.governor import governor
from opensuction.safety.handling import Reaction
from opensuction.safety.watch import vacuum_signature
from tests.safety.watchdog import (
    DT_S,
    HEAD_CAP_MM,
    INF,
    LIMITS,
    NAN,
    PARK_MM,
    Tick,
    at,
    first,
    run,
    sound,
    staying,
    tripped,
    turning,
)

AFTER_S = 0.05
"""Faults begin here."""
ABSURD = 1e306
"""A number, but a tick's difference of it over the tick is none."""


def stay(head_mm: float = PARK_MM) -> Setpoints:
    return staying(head_mm)


def faulty(**wrong: Any) -> list[Tick]:
    """A head at rest at 50 mm whose readings go wrong after 50 ms."""

    def report(time_s: float, _head_mm: float) -> Readings:
        return sound(50.0)._replace(**wrong) if time_s >= AFTER_S else sound(50.0)

    return run(0.15, lambda _: stay(50.0), report, at(50.0))


def expect(ticks: list[Tick], code: Condition, time_s: float, reaction: Reaction) -> None:
    """The trip comes at that time (to a tick) and not before, and is answered at once."""
    tick = first(ticks, code)
    assert tick.time_s == pytest.approx(time_s, abs=1.5 * DT_S)
    assert tick.verdict.reaction == reaction
    assert all(earlier.verdict.trips == 0 for earlier in ticks if earlier.time_s < tick.time_s)


@pytest.mark.parametrize(
    "wrong",
    [
        {"head_mm": NAN},
        {"head_mm": INF},
        {"head_mm_per_s": NAN},
        {"head_mm_per_s": -INF},
        {"vacuum_mmhg": NAN},
        {"vacuum_mmhg": -1.0},
    ],
    ids=str,
)
def test_an_impossible_proposal_withdraws_at_once(wrong: dict[str, Any]) -> None:
    def propose(time_s: float) -> Setpoints:
        return stay(50.0)._replace(**wrong) if time_s >= AFTER_S else stay(50.0)

    expect(
        run(0.1, propose, state=at(50.0)), Condition.PROPOSAL_INVALID, AFTER_S, Reaction.WITHDRAW
    )


@pytest.mark.requirement("OS-R11")
@pytest.mark.parametrize(
    ("wrong", "code", "reaction"),
    [
        ({"head_mm": NAN}, Condition.HEAD_READING_INVALID, Reaction.WITHDRAW),
        ({"head_mm": -INF}, Condition.HEAD_READING_INVALID, Reaction.WITHDRAW),
        ({"head_mm": ABSURD}, Condition.HEAD_READING_INVALID, Reaction.WITHDRAW),
        ({"head_valid": False, "head_mm": 0.0}, Condition.HEAD_READING_INVALID, Reaction.WITHDRAW),
        ({"carriage_mm": NAN}, Condition.CARRIAGE_READING_INVALID, Reaction.WITHDRAW),
        ({"carriage_valid": False}, Condition.CARRIAGE_READING_INVALID, Reaction.WITHDRAW),
        ({"cam_rad": -ABSURD}, Condition.CAM_READING_INVALID, Reaction.WITHDRAW),
        ({"cam_rad": NAN}, Condition.CAM_READING_INVALID, Reaction.WITHDRAW),
        ({"cam_valid": False}, Condition.CAM_READING_INVALID, Reaction.WITHDRAW),
        ({"line_vacuum_mmhg": ABSURD}, Condition.VACUUM_READING_INVALID, Reaction.WITHDRAW),
        ({"line_vacuum_mmhg": NAN}, Condition.VACUUM_READING_INVALID, Reaction.WITHDRAW),
        ({"vacuum_valid": False}, Condition.VACUUM_READING_INVALID, Reaction.WITHDRAW),
        ({"contact_valid": False}, Condition.CONTACT_READING_INVALID, Reaction.WITHDRAW),
    ],
    ids=str,
)
def test_five_ticks_without_a_reading_are_a_fault(
    wrong: dict[str, Any], code: Condition, reaction: Reaction
) -> None:
    expect(faulty(**wrong), code, AFTER_S + 4 * DT_S, reaction)


@pytest.mark.requirement("OS-R11")
@pytest.mark.parametrize("wrong", [{"head_mm": ABSURD}, {"insertion_current_a": -ABSURD}], ids=str)
def test_an_absurd_reading_blinds_no_limit_for_good(wrong: dict[str, Any]) -> None:
    """Averages of it would be no number, after a reset too, and exceed no limit ever again."""

    def report(time_s: float, head_mm: float) -> Readings:
        return sound(head_mm)._replace(**wrong) if time_s < 0.02 else sound(head_mm)

    ended = run(0.04, lambda _: stay(50.0), report, at(50.0))[-1].state
    reset = governor.reset(LIMITS, ended)
    assert math.isfinite(reset.watch.speed_mm_per_s)
    assert math.isfinite(ended.watch.drive.force_n)
    assert math.isfinite(ended.watch.drive.resistance_n)

    def pushed(time_s: float, _head_mm: float) -> Readings:
        return sound(50.0 + 40.0 * time_s)

    seen = tripped(run(0.1, lambda _: stay(50.0), pushed, reset))
    assert Condition.HEAD_OVERSPEED in seen


@pytest.mark.requirement("OS-R11")
@pytest.mark.parametrize(
    "wrong",
    [
        {"head_mm": NAN},
        {"head_valid": False, "head_mm": 1e9},
        {"carriage_mm": 1e9, "carriage_valid": False},
        {"cam_rad": 99.0, "cam_valid": False},
        {"line_vacuum_mmhg": INF},
        {"contact_valid": False},
    ],
    ids=str,
)
def test_four_ticks_without_a_reading_are_ridden_out_and_change_nothing(
    wrong: dict[str, Any],
) -> None:
    def report(time_s: float, head_mm: float) -> Readings:
        lost = round(time_s / DT_S) % 50 in (20, 21, 22, 23)
        return sound(head_mm)._replace(**wrong) if lost else sound(head_mm)

    def advance(time_s: float) -> Setpoints:
        return stay(PARK_MM + 9.0 * time_s)

    assert tripped(run(0.3, advance, report)) == set()
    assert [tick.allowed.head_mm for tick in run(0.3, advance, report)] == [
        tick.allowed.head_mm for tick in run(0.3, advance)
    ]


@pytest.mark.requirement("OS-R08")
def test_a_head_faster_than_half_again_its_limit_loses_its_torque() -> None:
    def report(time_s: float, _head_mm: float) -> Readings:
        return sound(50.0 - 45.0 * max(time_s - AFTER_S, 0.0))

    tick = first(run(0.15, lambda _: stay(50.0), report, at(50.0)), Condition.HEAD_OVERSPEED)
    assert tick.verdict.reaction == Reaction.TORQUE_OFF
    # The average over 10 ms reaches 25 of 45 mm/s after 8 ms, and stays above for twenty ticks.
    assert tick.time_s == pytest.approx(AFTER_S + 0.008 + 19 * DT_S, abs=0.002)


@pytest.mark.requirement("OS-R09")
@pytest.mark.parametrize("slip", [0.05, 0.2, 1.0, 2.0, -0.2], ids=str)
def test_a_catheter_head_that_is_not_where_the_motor_is_brings_the_catheter_out(
    slip: float,
) -> None:
    def report(_time_s: float, head_mm: float) -> Readings:
        return sound(head_mm)._replace(carriage_mm=50.0 + (1.0 - slip) * (head_mm - 50.0))

    speed = 15.0
    patient = LIMITS._replace(in_airway_s=INF)
    ticks = run(1.5, lambda t: stay(50.0 + speed * t), report, at(50.0), limits=patient)
    tick = first(ticks, Condition.HEAD_SENSORS_DISAGREE)
    assert tick.time_s == pytest.approx(1.0 / (abs(slip) * speed) + 0.05, abs=0.003)
    assert tick.verdict.reaction == Reaction.WITHDRAW


@pytest.mark.requirement("OS-R09")
def test_a_catheter_that_its_motor_cannot_bring_home_is_left_to_a_hand() -> None:
    """The motor is home, the catheter head is not: the drive lets go of what it cannot move."""

    def report(_time_s: float, head_mm: float) -> Readings:
        return sound(head_mm)._replace(carriage_mm=head_mm + 30.0, line_vacuum_mmhg=0.0)

    limits = LIMITS._replace(in_airway_s=INF, withdrawal_s=5.0)
    ticks = run(5.5, lambda _: stay(PARK_MM), report, at(PARK_MM), limits=limits)
    assert first(ticks, Condition.HEAD_SENSORS_DISAGREE).verdict.insertion_on
    given_up = first(ticks, Condition.WITHDRAWAL_TIME)
    assert given_up.time_s == pytest.approx(0.05 + 5.0, abs=0.005)
    assert given_up.verdict.reaction == Reaction.TORQUE_OFF
    assert not ticks[-1].verdict.insertion_on


@pytest.mark.requirement("OS-R09")
@pytest.mark.parametrize("apart_mm", [-0.9, 0.9])
def test_play_and_steps_of_the_sensors_are_no_fault(apart_mm: float) -> None:
    def report(time_s: float, head_mm: float) -> Readings:
        jumps = 5.0 if round(time_s / DT_S) % 60 < 45 else 0.0  # never for 50 ms at a time
        return sound(head_mm)._replace(carriage_mm=head_mm + (apart_mm if time_s < 0.3 else jumps))

    assert tripped(run(0.6, lambda _: stay(50.0), report, at(50.0))) == set()


@pytest.mark.requirement("OS-R09")
def test_a_head_that_lags_too_far_for_too_long_is_withdrawn() -> None:
    ticks = run(0.85, lambda t: stay(50.0 + 15.0 * t), lambda t, _: sound(50.0 + t), at(50.0))
    # 8 mm of distance at 14 mm/s, then 0.2 s.
    expect(ticks, Condition.HEAD_NOT_FOLLOWING, 8.0 / 14.0 + 0.2, Reaction.WITHDRAW)


@pytest.mark.requirement("OS-R09")
def test_a_frozen_encoder_or_a_jam_is_noticed_within_a_tenth_of_a_second() -> None:
    def advance(time_s: float) -> Setpoints:
        return stay(50.0 + 9.0 * time_s)

    def report(time_s: float, head_mm: float) -> Readings:
        return sound(head_mm if time_s < AFTER_S else 50.45)

    ticks = run(0.4, advance, report, at(50.0))
    # 0.11 mm of distance at 9 mm/s, then 0.1 s.
    expect(ticks, Condition.HEAD_STALLED, AFTER_S + 0.11 / 9.0 + 0.1, Reaction.WITHDRAW)


def test_friction_alone_is_no_stall() -> None:
    assert tripped(run(0.5, lambda _: stay(50.1), lambda *_: sound(50.0), at(50.0))) == set()


@pytest.mark.requirement("OS-R10")
def test_a_head_that_advances_against_its_command_loses_its_torque() -> None:
    def report(time_s: float, _head_mm: float) -> Readings:
        return sound(50.0 + 15.0 * max(time_s - AFTER_S, 0.0))

    ticks = run(0.3, lambda _: stay(50.0), report, at(50.0))
    # Beyond a millimetre, and for five ticks.
    expect(ticks, Condition.HEAD_RUNAWAY, AFTER_S + 1.0 / 15.0 + 4 * DT_S, Reaction.TORQUE_OFF)


def test_a_head_left_on_its_way_in_may_brake_at_power_up_and_no_longer() -> None:
    """17 mm/s and 200 mm/s2: .72 mm in .085 s; with 1 mm more it runs away."""

    def brake(time_s: float, _head_mm: float) -> Readings:
        left_s = min(time_s, 0.085)
        return sound(50.0 + 17.0 * left_s - 100.0 * left_s * left_s)

    started = governor.start(LIMITS, 50.0)
    assert Condition.HEAD_RUNAWAY not in tripped(run(0.3, lambda _: stay(50.0), brake, started))
    ticks = run(0.3, lambda _: stay(50.0), lambda t, _: sound(50.0 + 17.0 * t), started)
    at_s = (0.7225 + 1.0) / 17.0 + 4 * DT_S
    expect(ticks, Condition.HEAD_RUNAWAY, at_s, Reaction.TORQUE_OFF)


@pytest.mark.requirement("OS-R03")
def test_with_the_valve_open_it_does_so_sooner() -> None:
    def report(time_s: float, _head_mm: float) -> Readings:
        moved = 15.0 * max(time_s - AFTER_S, 0.0)
        return sound(50.0 + moved)._replace(cam_rad=LIMITS.valve.open_rad)

    suck = stay(50.0)._replace(valve_open=True)
    ticks = run(0.3, lambda _: suck, report, at(50.0))
    tick = first(ticks, Condition.HEAD_RUNAWAY)
    assert tick.time_s == pytest.approx(AFTER_S + 0.3 / 15.0 + 4 * DT_S, abs=3 * DT_S)
    assert tick.verdict.reaction == Reaction.TORQUE_OFF


@pytest.mark.requirement("OS-R10")
def test_a_runaway_in_the_middle_of_a_withdrawal_is_one_too() -> None:
    def back(time_s: float) -> Setpoints:
        return stay(90.0 - 15.0 * time_s)

    def report(time_s: float, head_mm: float) -> Readings:
        turned = max(time_s - 1.0, 0.0)
        return sound(head_mm if turned == 0.0 else 75.0 + 15.0 * turned)

    ticks = run(1.3, back, report, at(90.0), limits=LIMITS._replace(in_airway_s=5.0))
    tick = first(ticks, Condition.HEAD_RUNAWAY)
    assert tick.time_s == pytest.approx(1.0 + 1.0 / 15.0 + 4 * DT_S, abs=3 * DT_S)
    assert tick.readings.head_mm < 76.1


def test_a_stop_from_full_speed_is_no_runaway() -> None:
    def report(time_s: float, head_mm: float) -> Readings:
        # 17 mm/s braked at 260 mm/s2 overshoots by 0.56 mm; then it is drawn out.
        late = max(time_s - 0.1, 0.0)
        coasting = 17.0 * late - 130.0 * late * late if late < 0.065 else 0.556
        drawn = 20.0 * max(late - 0.065, 0.0)
        return sound(head_mm if late == 0.0 else 51.7 + coasting - drawn)

    def propose(time_s: float) -> Setpoints:
        return stay(50.0 + 17.0 * time_s) if time_s < 0.1 else stay(51.7)._replace(head_mm=NAN)

    assert Condition.HEAD_RUNAWAY not in tripped(run(0.3, propose, report, at(50.0)))


@pytest.mark.requirement("OS-R02")
def test_a_head_carried_past_its_cap_is_withdrawn() -> None:
    start_mm = HEAD_CAP_MM + 0.9

    def report(time_s: float, _head_mm: float) -> Readings:
        return sound(start_mm + 2.0 * time_s)

    ticks = run(0.1, lambda _: stay(start_mm), report, at(start_mm))
    expect(ticks, Condition.TIP_BEYOND_CAP, 0.05, Reaction.WITHDRAW)


@pytest.mark.requirement("OS-R07")
def test_line_vacuum_over_its_limit_is_cut_after_a_fifth_of_a_second() -> None:
    def report(time_s: float, head_mm: float) -> Readings:
        high = 151.0 if time_s >= AFTER_S else 149.0
        return sound(head_mm)._replace(line_vacuum_mmhg=high)

    ticks = run(0.4, lambda _: stay(50.0), report, at(50.0))
    # The filter has gone half of the way from 149 to 151 mmHg.
    seen_s = AFTER_S + vacuum_signature.FILTER_S * math.log(2.0)
    expect(ticks, Condition.VACUUM_EXCEEDED, seen_s + 0.2, Reaction.WITHDRAW)
    assert not ticks[-1].allowed.pump_on


def test_a_line_that_hides_its_vacuum_now_and_then_is_cut_as_soon() -> None:
    def report(time_s: float, head_mm: float) -> Readings:
        hidden = round(time_s / DT_S) % 100 < 3
        return sound(head_mm)._replace(line_vacuum_mmhg=NAN if hidden else 151.0)

    ticks = run(0.4, lambda _: stay(50.0), report, at(50.0))
    tick = first(ticks, Condition.VACUUM_EXCEEDED)
    assert tick.time_s == pytest.approx(0.2, abs=0.005)


@pytest.mark.requirement("OS-R04")
def test_negative_pressure_is_limited_from_the_valve_leaving_its_seat() -> None:
    def propose(time_s: float) -> Setpoints:
        return stay()._replace(valve_open=time_s >= AFTER_S)

    ticks = run(0.7, propose, lambda t, head: turning(t, head, 0.01))
    expect(ticks, Condition.NEGATIVE_PRESSURE_TIME, AFTER_S + 0.5, Reaction.WITHDRAW)
    assert not first(ticks, Condition.NEGATIVE_PRESSURE_TIME).allowed.valve_open


@pytest.mark.parametrize("cam_rad", [0.021, -0.031, 0.5])
def test_a_valve_that_does_not_close_counts_as_open(cam_rad: float) -> None:
    ticks = run(0.7, lambda _: stay(), lambda t, head: turning(t, head, cam_rad))
    expect(ticks, Condition.NEGATIVE_PRESSURE_TIME, 0.5, Reaction.WITHDRAW)


@pytest.mark.requirement("OS-R05")
def test_time_in_the_airway_is_limited() -> None:
    ticks = run(2.2, lambda t: stay(min(PARK_MM + 20.0 * t, PARK_MM + 40.0)))
    # Not before the narrowest gap is taken up: the deepest possible tip stands still until then.
    inside = next(tick for tick in ticks if tick.verdict.deepest_mm > LIMITS.outside_mm)
    assert inside.time_s > 1.0
    expect(ticks, Condition.IN_AIRWAY_TIME, inside.time_s + 0.8, Reaction.WITHDRAW)


@pytest.mark.requirement("OS-R06")
@pytest.mark.parametrize("bounce", [1, 2, 5, 9])
def test_contact_is_limited_even_if_the_switch_bounces(bounce: int) -> None:
    def report(time_s: float, head_mm: float) -> Readings:
        ticks = round(time_s / DT_S) - round(AFTER_S / DT_S)
        closed = ticks >= 0 and ticks % (bounce + 1) == 0
        return sound(head_mm)._replace(contact_closed=closed)

    ticks = run(0.5, lambda _: stay(), report)
    expect(ticks, Condition.CONTACT_TIME, AFTER_S + 0.3, Reaction.WITHDRAW)


def test_a_contact_that_opens_for_ten_milliseconds_is_over() -> None:
    def report(time_s: float, head_mm: float) -> Readings:
        return sound(head_mm)._replace(contact_closed=round(time_s / DT_S) % 100 < 90)

    assert Condition.CONTACT_TIME not in tripped(run(1.0, lambda _: stay(), report))


@pytest.mark.requirement("OS-R12")
def test_five_late_ticks_in_a_row_are_a_fault_four_are_not() -> None:
    ticks = run(0.2, lambda _: stay(), overrun=lambda t: t >= AFTER_S - 1e-9)
    expect(ticks, Condition.LATE_TICKS, AFTER_S + 4 * DT_S, Reaction.WITHDRAW)
    now_and_then = run(2.0, lambda _: stay(), overrun=lambda t: round(t / DT_S) % 20 < 4)
    assert tripped(now_and_then) == set()


@pytest.mark.requirement("OS-R12")
def test_four_late_ticks_of_five_are_a_fault_within_a_twentieth_of_a_second() -> None:
    ticks = run(0.3, lambda _: stay(), overrun=lambda t: t > AFTER_S and round(t / DT_S) % 5 > 0)
    # 1 - exp(-t / 0.1 s) of 0.8 is 0.25 after 37 ms.
    expect(ticks, Condition.LATE_TICKS, AFTER_S + 0.037, Reaction.WITHDRAW)
