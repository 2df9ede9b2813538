import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin.airway import airway

FLOW_ML_PER_S = 300.0  # 18 L/min


@pytest.mark.parametrize(("bore_mm", "lost_cmh2o"), [(7.5, 1.4), (8.0, 0.94), (9.0, 0.49)])
def test_a_catheter_of_4_mm_takes_the_pressure_of_the_annulus(
    bore_mm: float, lost_cmh2o: float
) -> None:
    ratio = 4.0 / bore_mm
    made = airway.of_size(bore_mm, 80.0, FLOW_ML_PER_S)
    loss = airway.loss(made, ratio) * FLOW_ML_PER_S * FLOW_ML_PER_S
    assert loss == pytest.approx(lost_cmh2o, rel=0.03)  # the figures have two digits


@given(narrow=st.floats(0.0, 0.95), wide=st.floats(0.0, 0.95))
def test_a_wider_catheter_never_helps(narrow: float, wide: float) -> None:
    made = airway.of_size(8.5, 80.0, FLOW_ML_PER_S)
    low, high = sorted((narrow, wide))
    assert airway.loss(made, low) <= airway.loss(made, high)


def test_a_catheter_as_wide_as_the_tube_leaves_a_gap() -> None:
    made = airway.of_size(8.5, 80.0, FLOW_ML_PER_S)
    assert airway.loss(made, 2.0) == airway.loss(made, airway.WIDEST_RATIO)
    assert airway.loss(made, -1.0) == airway.loss(made, 0.0)


def test_the_laminar_part_that_is_left_out_is_small() -> None:
    """Hagen-Poiseuille at 6 L/min in the adult tube, against what the module says."""
    pa_s_per_m3 = 128.0 * 1.8e-5 * 0.080 / (3.1416 * 0.0085**4)
    assert pa_s_per_m3 * 100e-6 / airway.PA_PER_CMH2O < 0.013
