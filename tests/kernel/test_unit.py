import pytest

from opensuction.kernel.unit import unit_of


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("tip_mm", "mm"),
        ("speed_mm_per_s", "mm/s"),
        ("limit_mm_per_s2", "mm/s^2"),
        ("dwell_s", "s"),
        ("threshold_n", "N"),
        ("vacuum_mmhg", "mmHg"),
        ("pressure_cmh2o", "cmH2O"),
        ("removed_ml", "mL"),
        ("flow_ml_per_s", "mL/s"),
        ("pump_l_per_min", "L/min"),
        ("compliance_ml_per_cmh2o", "mL/cmH2O"),
        ("recruitment_ml_per_cmh2o_per_s", "mL/cmH2O/s"),
        ("cam_rad", "rad"),
        ("removed_percent", "%"),
        ("supply_v", "V"),
        ("proportional_v_per_mm", "V/mm"),
        ("derivative_v_s_per_mm", "V s/mm"),
        ("decay_per_mm", "1/mm"),
        ("valve_open_ratio", ""),
        ("slope", ""),
        ("strokes", ""),
        ("x_per_turn", ""),
    ],
)
def test_the_suffix_of_a_name_gives_its_unit(name: str, unit: str) -> None:
    assert unit_of(name) == unit
