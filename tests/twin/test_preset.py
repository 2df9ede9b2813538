import numpy as np
import pytest

from opensuction.twin import parameter, preset
from opensuction.twin.machine import machine
from opensuction.twin.machine.dc_axis import AxisMotion

VALUES = parameter.nominal(parameter.BENCH)
BENCH = preset.machine(VALUES)


def test_force_and_voltage_agree_with_mass_and_time_constant() -> None:
    """F = m a: the drive's limit must accelerate the stated mass as the axis says it does."""
    axis = BENCH.insertion_axis
    acceleration_m_per_s2 = axis.speed_per_v * axis.force_v / axis.time_constant_s / 1000.0
    assert acceleration_m_per_s2 == pytest.approx(
        VALUES["drive_force_n"] / VALUES["moving_mass_kg"]
    )


def test_the_drive_gives_no_more_power_than_it_takes() -> None:
    electric_w_per_n = VALUES["drive_a_per_n"] * VALUES["supply_v"]
    assert electric_w_per_n > VALUES["no_load_mm_per_s"] / 1000.0


def test_current_is_that_of_the_force() -> None:
    force_n = 2.0
    motion = AxisMotion(0.0, 0.0, drive_v=force_n * BENCH.load_v_per_n)
    current = machine.measure(BENCH, motion, 0.0, 0.0, 0.0).current_a
    assert current == pytest.approx(force_n * VALUES["drive_a_per_n"])


def test_secretions_add_up_and_lie_above_the_carina() -> None:
    for seed in range(20):
        values = parameter.draw(parameter.BENCH, seed)
        bins = preset.secretions_ml(values)
        assert bins.sum() == pytest.approx(values["secretion_ml"])
        assert np.all(bins >= 0.0)
        middles = (np.arange(bins.size) + 0.5) * 10.0
        assert np.all(bins[middles > values["carina_mm"]] == 0.0)


@pytest.mark.parametrize("head_mm", [-4.1, 0.0, 30.0])
def test_a_parked_machine_reads_the_position_it_was_parked_at(head_mm: float) -> None:
    """After a retract: the encoder is there, the head behind its gear's play a little deeper."""
    state = preset.park(BENCH, VALUES, head_mm, seed=1, run=0).machine
    reading = machine.read(BENCH, state)
    assert reading.head_mm == pytest.approx(head_mm, abs=0.5 * VALUES["head_encoder_mm"])
    assert state.head_mm == pytest.approx(head_mm + 0.5 * VALUES["gear_backlash_mm"])
    step_mm = VALUES["carriage_sensor_mm"]
    assert reading.carriage_mm == pytest.approx(state.head_mm, abs=0.5 * step_mm + 1e-9)
    assert reading.carriage_mm / step_mm == pytest.approx(round(reading.carriage_mm / step_mm))
    assert not reading.contact_closed
