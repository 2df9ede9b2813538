import pytest

from opensuction.safety import valve_axis
from opensuction.safety.limits import ValveLimits
from opensuction.safety.valve_axis import ARRIVED, ValveAxis

LIMITS = ValveLimits(open_rad=0.52, stroke_s=0.5)
DT_S = 0.001


def told(opened: bool, cams_rad: list[float]) -> ValveAxis:
    state, before = ARRIVED, cams_rad[0]
    for i, cam in enumerate(cams_rad):
        state = valve_axis.step(LIMITS, state, opened, i == 0, cam, before, DT_S)
        before = cam
    return state


@pytest.mark.parametrize("opened", [True, False])
def test_a_stroke_in_time_is_never_stuck(opened: bool) -> None:
    way = [0.52 * i / 500 for i in range(501)]
    cams = [way[0]] * 20 + way + [way[-1]] * 2000
    for end in range(1, len(cams), 7):
        chosen = cams[:end] if opened else [0.52 - cam for cam in cams[:end]]
        assert not valve_axis.is_stuck(LIMITS, told(opened, chosen))


@pytest.mark.parametrize(("opened", "cam_rad"), [(True, 0.0), (True, 0.13), (False, 0.13)])
def test_a_cam_that_stands_on_its_way_is_stuck_in_an_instant(opened: bool, cam_rad: float) -> None:
    assert not valve_axis.is_stuck(LIMITS, told(opened, [cam_rad] * 140))
    assert valve_axis.is_stuck(LIMITS, told(opened, [cam_rad] * 160))


def test_a_cam_that_creeps_is_stuck_after_half_its_stroke_again() -> None:
    creeping = [0.1 + 1e-5 * i for i in range(1300)]
    assert not valve_axis.is_stuck(LIMITS, told(True, creeping[:1200]))
    assert valve_axis.is_stuck(LIMITS, told(True, creeping))


def test_a_cam_where_it_belongs_is_arrived() -> None:
    assert told(True, [0.5] * 5000) == ARRIVED
    assert told(False, [0.015] * 5000) == ARRIVED
