import pytest

from opensuction.safety.limits import ValveLimits
from opensuction.safety.watch import valve_axis
from opensuction.safety.watch.valve_axis import START, ValveAxis
from tests.safety.watchdog import above, below

LIMITS = ValveLimits(open_rad=0.52, stroke_s=0.5)
AWAY = ValveAxis(away_s=0.0, still_s=0.0, still_rad=0.25, resting=False)
DT_S = 0.001


def seen(opened: bool, cams_rad: list[float]) -> list[ValveAxis]:
    """What is made of the cam, tick by tick."""
    state, states = START, []
    for i, cam in enumerate(cams_rad):
        state = valve_axis.step(LIMITS, state, opened, i == 0, cam, DT_S)
        states.append(state)
    return states


def told(opened: bool, cams_rad: list[float]) -> ValveAxis:
    return seen(opened, cams_rad)[-1]


@pytest.mark.parametrize("opened", [True, False])
def test_a_stroke_in_time_is_never_stuck(opened: bool) -> None:
    way = [0.52 * i / 500 for i in range(501)]
    cams = [way[0]] * 20 + way + [way[-1]] * 2000
    chosen = cams if opened else [0.52 - cam for cam in cams]
    assert not any(valve_axis.is_stuck(LIMITS, state) for state in seen(opened, chosen))


@pytest.mark.parametrize(("opened", "cam_rad"), [(True, 0.0), (True, 0.13), (False, 0.13)])
def test_a_cam_that_stands_on_its_way_is_stuck_in_an_instant(opened: bool, cam_rad: float) -> None:
    assert not valve_axis.is_stuck(LIMITS, told(opened, [cam_rad] * 140))
    assert valve_axis.is_stuck(LIMITS, told(opened, [cam_rad] * 160))


def test_a_cam_that_creeps_is_stuck_after_half_its_stroke_again() -> None:
    creeping = [0.1 + 1e-4 * i for i in range(1300)]
    assert not valve_axis.is_stuck(LIMITS, told(True, creeping[:1200]))
    assert valve_axis.is_stuck(LIMITS, told(True, creeping))


def test_a_cam_where_it_belongs_is_arrived() -> None:
    assert told(True, [0.5] * 5000) == ValveAxis(0.0, 0.0, 0.5, resting=False)
    assert told(False, [0.004] * 5000) == ValveAxis(0.0, 0.0, 0.0, resting=True)


def test_nine_tenths_of_the_angle_are_open_and_a_fiftieth_of_a_radian_is_closed() -> None:
    assert valve_axis.is_open(LIMITS, 0.9 * 0.52)
    assert not valve_axis.is_open(LIMITS, below(0.9 * 0.52))
    for cam_rad in (0.02, 0.0, -0.03):
        assert valve_axis.is_closed(cam_rad)
    for cam_rad in (above(0.02), below(-0.03)):
        assert not valve_axis.is_closed(cam_rad)


def test_a_cam_may_stand_and_be_away_for_its_time_and_no_longer() -> None:
    assert not valve_axis.is_stuck(LIMITS, AWAY._replace(away_s=0.0, still_s=0.15))
    assert valve_axis.is_stuck(LIMITS, AWAY._replace(away_s=0.0, still_s=above(0.15)))
    # Half as long again as the stroke of 0.5 s, and 0.5 s to settle.
    assert not valve_axis.is_stuck(LIMITS, AWAY._replace(away_s=1.25, still_s=0.0))
    assert valve_axis.is_stuck(LIMITS, AWAY._replace(away_s=above(1.25), still_s=0.0))


def test_a_cam_that_moved_a_little_has_not_stood_and_is_still_away() -> None:
    state = ValveAxis(away_s=0.2, still_s=0.1, still_rad=0.25, resting=False)
    moved_rad = 0.2551
    moved = valve_axis.step(LIMITS, state, True, False, moved_rad, 0.125)
    assert moved == ValveAxis(away_s=0.325, still_s=0.0, still_rad=moved_rad, resting=False)
    # What is not farther than the sensor's noise is no way.
    for stood_rad in (0.2549, 0.25, 0.2451):
        stood = valve_axis.step(LIMITS, state, True, False, stood_rad, 0.125)
        assert stood == ValveAxis(away_s=0.325, still_s=0.225, still_rad=0.25, resting=False)
    # A new command begins anew, wherever the cam is.
    begun = valve_axis.step(LIMITS, state, True, True, 0.25, 0.125)
    assert begun == START._replace(still_rad=0.25)


def test_a_valve_that_came_home_rests_until_it_is_told_to_open() -> None:
    home = told(False, [0.3, 0.2, 0.1, 0.0])
    assert home.resting
    # Whatever the encoder then says.
    erring = valve_axis.step(LIMITS, home, False, False, 0.3, DT_S)
    assert erring == ValveAxis(away_s=DT_S, still_s=0.0, still_rad=0.3, resting=True)
    assert not valve_axis.step(LIMITS, home, True, True, 0.0, DT_S).resting
    assert not told(False, [0.3, 0.2, 0.1, 0.021]).resting
    # Told to close again: a stroke is driven, even if it rested before.
    assert not valve_axis.step(LIMITS, home, False, True, 0.3, DT_S).resting


def test_after_a_reset_a_cam_on_its_way_has_all_its_time_again() -> None:
    stuck = told(True, [0.13] * 160)
    assert valve_axis.is_stuck(LIMITS, stuck)
    begun = valve_axis.restart(stuck)
    assert begun == ValveAxis(0.0, 0.0, 0.13, resting=False)
    assert not valve_axis.is_stuck(LIMITS, begun)
    assert valve_axis.restart(told(False, [0.0] * 3)).resting
