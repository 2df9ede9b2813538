"""Evaluation of cam and line: suction, a sealed line, its highest vacuum."""

import pytest

from opensuction.safety.watch.vacuum_signature import START
from opensuction.safety.watch.valve_axis import ValveAxis
from tests.safety.observer import HEAD_MM, observed, seen
from tests.safety.watchdog import DT_S, LIMITS, NAN, PARK_MM, above, below, changed, sound


@pytest.mark.parametrize(
    ("cam_rad", "opened", "sucking"),
    [
        (0.02, False, False),
        (-0.03, False, False),
        (above(0.02), False, True),
        (below(-0.03), False, True),
        (0.0, True, True),
    ],
)
def test_suction_lasts_from_the_command_or_the_seat_until_both_are_back(
    cam_rad: float, opened: bool, sucking: bool
) -> None:
    before = seen(**{"durations.sucking_s": 1.0})
    after = observed(before, sound(HEAD_MM)._replace(cam_rad=cam_rad), valve_open=opened)
    assert after.durations.sucking_s == (1.0 + DT_S if sucking else 0.0)


@pytest.mark.parametrize(("ticks", "sucking"), [(3, 0.0), (4, DT_S)])
def test_a_cam_that_is_not_read_for_five_ticks_counts_as_open(ticks: int, sucking: float) -> None:
    before = seen(**{"invalid.cam": ticks})
    after = observed(before, sound(HEAD_MM)._replace(cam_valid=False))
    assert after.durations.sucking_s == sucking


def test_the_anchor_is_the_least_reading_since_the_valve_left_its_seat() -> None:
    opened = sound(HEAD_MM)._replace(cam_rad=0.3)
    before = seen(suction_start_mm=48.0)
    assert observed(before, opened).suction_start_mm == 48.0
    assert observed(before, opened._replace(head_mm=47.0)).suction_start_mm == 47.0
    assert observed(before, sound(HEAD_MM)).suction_start_mm == HEAD_MM


@pytest.mark.parametrize(
    ("off_mm", "cam_rad", "opened", "parked_closed"),
    [
        (2.999, 0.02, False, True),
        (-2.999, 0.02, False, True),
        (3.001, 0.0, False, False),
        (-3.001, 0.0, False, False),
        (0.0, above(0.02), False, False),
        (0.0, 0.0, True, False),
    ],
)
def test_a_line_is_sealed_parked_within_three_millimetres_behind_a_closed_valve(
    off_mm: float, cam_rad: float, opened: bool, parked_closed: bool
) -> None:
    head = PARK_MM + off_mm
    high = sound(head)._replace(cam_rad=cam_rad, line_vacuum_mmhg=160.0)
    after = observed(seen(head), high, valve_open=opened)
    assert after.parked_closed == parked_closed
    assert after.durations.overpressure_s == (0.0 if parked_closed else DT_S)


def test_three_millimetres_are_parked() -> None:
    home = LIMITS._replace(park_head_mm=47.0)
    for head, parked_closed in (
        (50.0, True),
        (above(50.0), False),
        (44.0, True),
        (below(44.0), False),
    ):
        after = observed(seen(head), sound(head), limits=home)
        assert after.parked_closed == parked_closed


@pytest.mark.parametrize("name", ["head_valid", "cam_valid"])
def test_nothing_is_sealed_that_cannot_be_read(name: str) -> None:
    assert observed(seen(PARK_MM), sound(PARK_MM)).parked_closed
    dark = changed(sound(PARK_MM), {name: False})
    assert not observed(seen(PARK_MM), dark).parked_closed


@pytest.mark.parametrize(("head_mm", "highest"), [(HEAD_MM, 150.0), (PARK_MM, 190.0)])
def test_vacuum_is_over_its_limit_beyond_it_and_not_on_it(head_mm: float, highest: float) -> None:
    for vacuum, lasted in ((highest, 0.0), (above(highest), DT_S)):
        read = sound(head_mm)._replace(line_vacuum_mmhg=vacuum)
        assert observed(seen(head_mm), read).durations.overpressure_s == lasted
    # Not read now: what was read last counts.
    hidden = sound(head_mm)._replace(vacuum_valid=False)
    held = seen(head_mm, **{"line.vacuum_mmhg": above(highest)})
    assert observed(held, hidden).durations.overpressure_s == DT_S


@pytest.mark.parametrize(
    ("cam_rad", "opened", "name"),
    [
        # The line is judged as open or as closed where it is told so, and the cam is there.
        (0.5, True, "open_low_s"),
        (0.4, True, None),
        (0.0, True, None),
        (0.0, False, "closed_low_s"),
        (0.5, False, None),
    ],
)
def test_the_line_is_judged_by_what_it_was_told_and_where_the_cam_is(
    cam_rad: float, opened: bool, name: str | None
) -> None:
    built = START._replace(
        set_mmhg=120.0, vacuum_mmhg=120.0, slow_mmhg=120.0, pumping_s=60.0, built=True
    )
    read = sound(HEAD_MM)._replace(cam_rad=cam_rad)
    line = observed(seen(line=built), read, valve_open=opened, vacuum_mmhg=120.0).line
    assert line.vacuum_mmhg == 10.0
    for each in ("open_low_s", "closed_low_s"):
        assert getattr(line, each) == (DT_S if each == name else 0.0)
    # A cam that is not read is where it was, and not known to have closed.
    where = seen(line=built, cam_rad=cam_rad)
    hidden = read._replace(cam_valid=False, cam_rad=NAN)
    dark = observed(where, hidden, valve_open=opened, vacuum_mmhg=120.0).line
    assert dark.closed_low_s == 0.0
    assert dark.open_low_s == line.open_low_s


def test_a_line_that_is_not_read_keeps_what_was_known() -> None:
    known = START._replace(vacuum_mmhg=90.0, closed_low_s=0.2, pumping_s=9.0)
    assert observed(seen(line=known), sound(HEAD_MM)._replace(vacuum_valid=False)).line == known


def test_a_cam_that_is_not_read_is_not_stuck() -> None:
    stuck = seen(valve=ValveAxis(1.0, 1.0, 0.3, resting=False), cam_rad=0.3)
    read = sound(HEAD_MM)._replace(cam_rad=0.3)
    assert observed(stuck, read).valve == ValveAxis(1.0 + DT_S, 1.0 + DT_S, 0.3, resting=False)
    missing = changed(stuck, {"invalid.cam": 1})
    assert observed(missing, read._replace(cam_valid=False)).valve == ValveAxis(
        0.0, 0.0, 0.3, resting=False
    )
    assert observed(stuck, read, valve_command_changed=True).valve == ValveAxis(
        0.0, 0.0, 0.3, resting=False
    )
