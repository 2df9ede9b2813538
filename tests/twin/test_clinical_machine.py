import math

import pytest

from opensuction.kernel.interface import Commands
from opensuction.twin import parameter, preset
from opensuction.twin.machine import machine
from opensuction.twin.machine.machine import MachineState
from tests.twin.holding import DT_S, hold_machine

VALUES = parameter.nominal(parameter.CLINICAL)
CLINICAL = preset.machine(VALUES)
FULL = Commands(
    head_mm=0.0,
    insertion_v=24.0,
    insertion_on=True,
    cam_rad=0.0,
    valve_v=24.0,
    valve_on=True,
    pump_on=False,
    vacuum_mmhg=0.0,
)

# Data sheet of the 1524T024SR, in SI units.
OHM = 79.3
NM_PER_A = 23.1e-3
ROTOR_KG_M2 = 0.56e-7
NO_LOAD_RAD_PER_S = 9800.0 * 2.0 * math.pi / 60.0
NO_LOAD_A = 4.0e-3
EFFICIENCY = 0.65


def run(seconds: float, commands: Commands) -> MachineState:
    state = preset.park(CLINICAL, VALUES, -100.0, seed=1, run=0).machine
    return hold_machine(CLINICAL, state, commands, round(seconds / DT_S))


def test_inertia_time_constant_and_current_are_one_motor_s() -> None:
    """That of the data sheet behind a gear that makes 60 mm/s of 9800 rpm."""
    m_per_rad = VALUES["no_load_mm_per_s"] / 1000.0 / NO_LOAD_RAD_PER_S
    assert VALUES["moving_mass_kg"] == pytest.approx(ROTOR_KG_M2 / m_per_rad**2, rel=0.01)
    own_s = OHM * ROTOR_KG_M2 / NM_PER_A**2
    assert VALUES["insertion_time_constant_s"] == pytest.approx(own_s / EFFICIENCY, rel=0.01)
    a_per_n = m_per_rad / NM_PER_A / EFFICIENCY
    assert VALUES["drive_a_per_n"] == pytest.approx(a_per_n, rel=0.02)
    assert CLINICAL.amperes_per_v == pytest.approx(1.0 / OHM, rel=0.03)
    assert VALUES["insertion_friction_v"] > NO_LOAD_A * OHM


def test_the_drive_gives_no_more_power_than_it_takes() -> None:
    electric_w_per_n = VALUES["drive_a_per_n"] * VALUES["supply_v"]
    assert electric_w_per_n > VALUES["no_load_mm_per_s"] / 1000.0


def test_force_is_limited_to_five_newtons_less_friction() -> None:
    axis = CLINICAL.insertion_axis
    first = run(DT_S, FULL)
    net_n = 5.0 - axis.friction_v / CLINICAL.load_v_per_n
    assert first.insertion.velocity == pytest.approx(net_n / VALUES["moving_mass_kg"], rel=1e-6)
    assert first.insertion.velocity > 0.2  # mm/s in a millisecond: 0.2 m/s2 can be planned


def test_the_head_comes_near_its_no_load_speed() -> None:
    fast = run(1.5, FULL).insertion.velocity
    assert fast == pytest.approx(60.0 * (24.0 - VALUES["insertion_friction_v"]) / 24.0, rel=1e-3)
    assert fast > 50.0


def test_the_cam_turns_at_sixty_degrees_a_second_against_its_spring() -> None:
    """With volts to spare for the servo; and the spring alone closes the valve."""
    axis, valve = CLINICAL.valve_axis, CLINICAL.valve
    load_v = valve.spring_preload_v + valve.spring_v_per_rad * valve.stroke_rad
    needed_v = math.radians(60.0) / axis.speed_per_v + axis.friction_v + load_v
    assert needed_v < 0.5 * VALUES["supply_v"]
    opened = run(0.5, FULL)
    assert opened.valve.position > valve.stroke_rad
    state = hold_machine(CLINICAL, opened, FULL._replace(valve_on=False), 600)
    assert machine.truth(CLINICAL, state).valve_open_ratio == 0.0


@pytest.mark.parametrize("seed", range(5))
def test_every_drawn_machine_can_do_what_is_planned(seed: int) -> None:
    """50 mm/s and 0.2 m/s2."""
    drawn = preset.machine(parameter.draw(parameter.CLINICAL, seed))
    axis = drawn.insertion_axis
    assert axis.speed_per_v * (axis.voltage_limit_v - axis.friction_v) > 55.0
    acceleration = axis.speed_per_v * (axis.force_v - axis.friction_v) / axis.time_constant_s
    assert acceleration > 200.0
