import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin import parameter, preset
from opensuction.twin.machine import dc_axis
from opensuction.twin.machine.dc_axis import AxisMotion

BENCH = preset.machine(parameter.nominal(parameter.BENCH))
VALVE = BENCH.valve
STROKE_RAD = math.radians(30.0)
angles = st.floats(-1.0, 2.0)


def test_thirty_degrees_slide_the_valve_five_millimetres() -> None:
    assert dc_axis.slide_mm(VALVE, STROKE_RAD) == pytest.approx(5.0)
    assert dc_axis.slide_mm(VALVE, 0.0) == 0.0
    assert dc_axis.open_ratio(VALVE, STROKE_RAD) == pytest.approx(1.0)


@given(one=angles, other=angles)
def test_more_angle_never_closes(one: float, other: float) -> None:
    less, more = min(one, other), max(one, other)
    opened = [dc_axis.open_ratio(VALVE, angle) for angle in (less, more)]
    assert 0.0 <= opened[0] <= opened[1] <= 1.0
    assert dc_axis.slide_mm(VALVE, less) <= dc_axis.slide_mm(VALVE, more)


def test_the_seal_holds_for_its_travel() -> None:
    seal_rad = STROKE_RAD * VALVE.seal_mm / VALVE.slide_mm
    assert dc_axis.open_ratio(VALVE, 0.999 * seal_rad) == 0.0
    assert dc_axis.open_ratio(VALVE, 1.01 * seal_rad) > 0.0


def test_the_spring_pushes_only_while_the_cam_touches_it_and_beats_friction() -> None:
    assert dc_axis.load_v(VALVE, 0.0) == 0.0
    assert dc_axis.load_v(VALVE, -0.1) == 0.0
    assert dc_axis.load_v(VALVE, 1e-6) > BENCH.valve_axis.friction_v


@pytest.mark.parametrize("opened", [0.1, 0.3, 0.6, 1.0])
def test_without_torque_the_spring_closes_the_valve_within_a_second(opened: float) -> None:
    """Closed means sealed for good: no bounce off the end stop opens it again."""
    motion = AxisMotion(position=opened * STROKE_RAD, velocity=0.0, drive_v=0.0)
    closed_s = None
    for tick in range(3000):
        load_v = dc_axis.load_v(VALVE, motion.position)
        turned = dc_axis.step(BENCH.valve_axis, motion, 0.0, False, load_v, 0.001)
        motion = dc_axis.stopped(turned, -VALVE.stop_rad, math.inf)
        sealed = dc_axis.open_ratio(VALVE, motion.position) == 0.0
        assert sealed or closed_s is None
        if sealed and closed_s is None:
            closed_s = tick * 0.001
    assert closed_s is not None
    assert closed_s < 1.0
    assert motion.velocity == 0.0
    # And it rests where the controller counts the cam as closed.
    assert abs(motion.position) <= 0.02 * STROKE_RAD


def test_the_end_stop_ends_a_motion_and_leaves_others_alone() -> None:
    beyond = AxisMotion(position=-0.3, velocity=-1.0, drive_v=-2.0)
    assert dc_axis.stopped(beyond, -VALVE.stop_rad, math.inf)[:2] == (-VALVE.stop_rad, 0.0)
    before = AxisMotion(position=0.2, velocity=-1.0, drive_v=-2.0)
    assert dc_axis.stopped(before, -VALVE.stop_rad, math.inf) == before
