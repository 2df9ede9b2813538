import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from opensuction.hysteresis import dahl, modified_dahl
from opensuction.hysteresis.dahl import Dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl

models = st.builds(Dahl, st.floats(0.05, 5.0), st.floats(0.05, 10.0))


@pytest.mark.parametrize("speed_mm_per_s", [3.0, 60.0])
@pytest.mark.parametrize(("deflection_mm", "move_mm"), [(0.0, 5.0), (1.5, -4.0), (-2.0, 0.3)])
def test_step_solves_the_papers_differential_equation(
    deflection_mm: float, move_mm: float, speed_mm_per_s: float
) -> None:
    model = Dahl(stiffness_n_per_mm=0.8, coulomb_n=1.6)
    rate = math.copysign(speed_mm_per_s, move_mm)

    def equation_1(_time_s: float, z: list[float]) -> list[float]:
        return [rate - model.stiffness_n_per_mm * abs(rate) * z[0] / model.coulomb_n]

    solved = solve_ivp(equation_1, (0.0, move_mm / rate), [deflection_mm], rtol=1e-11, atol=1e-12)
    # The solver's own tolerance, added up over its steps.
    assert dahl.step(model, deflection_mm, move_mm) == pytest.approx(solved.y[0, -1], abs=1e-9)


@given(model=models, turns=st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=20))
def test_the_force_never_exceeds_coulombs(model: Dahl, turns: list[float]) -> None:
    force_n = dahl.simulate(model, np.array([0.0, *turns]), 0.0)
    assert np.abs(force_n).max() <= model.coulomb_n * (1.0 + 1e-15)


@given(model=models, turns=st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=20))
def test_the_modified_model_is_a_line_and_a_dahl_state_the_other_way(
    model: Dahl, turns: list[float]
) -> None:
    x_mm = np.array([0.0, *turns])
    lag = ModifiedDahl(
        slope=1.0,
        velocity_gain=1.0,
        decay_per_mm=model.stiffness_n_per_mm / model.coulomb_n,
        offset_mm=0.0,
    )
    lag_mm = modified_dahl.simulate(lag, x_mm, 0.0) - x_mm
    deflection_mm = dahl.simulate(model, x_mm, 0.0) / model.stiffness_n_per_mm
    assert lag_mm == pytest.approx(-deflection_mm, rel=1e-11, abs=1e-11)


def test_a_full_cycle_takes_the_coulomb_forces_work() -> None:
    """Long strokes slide: twice the stroke at F_c, less the bend of two reversals."""
    model = Dahl(stiffness_n_per_mm=2.0, coulomb_n=0.5)
    x_mm = 50.0 - np.abs(np.linspace(-50.0, 50.0, 400_001))
    start = -1.0 * dahl.saturation_mm(model)
    force_n = dahl.simulate(model, x_mm, start)
    work_mj = float(np.sum(0.5 * (force_n[1:] + force_n[:-1]) * np.diff(x_mm)))
    # Each reversal lacks the integral of 2 F_c exp(-x/0.25 mm). Trapezium rule: (1e-4)^2.
    assert work_mj == pytest.approx(2 * 0.5 * 50.0 - 2 * 2 * 0.5 * 0.25, abs=1e-5)


@given(model=models, start=st.floats(-1.5, 1.5), target=st.floats(-0.999, 0.999))
def test_the_inverse_reaches_every_force_below_coulombs(
    model: Dahl, start: float, target: float
) -> None:
    z_mm = start * dahl.saturation_mm(model)
    found = dahl.inverse_step(model, z_mm, target * model.coulomb_n)
    assert found.reached
    force_n = dahl.output_n(model, dahl.step(model, z_mm, found.move_mm))
    assert force_n == pytest.approx(target * model.coulomb_n, abs=1e-14 * model.coulomb_n)


@pytest.mark.parametrize("target_n", [0.5, -0.7, math.inf, math.nan])
def test_a_force_that_sliding_never_gives_is_not_reached(target_n: float) -> None:
    assert dahl.inverse_step(Dahl(2.0, 0.5), 0.1, target_n) == (0.0, False)


@pytest.mark.parametrize("ratio", [-1.0, 0.0, 0.4, 1.0])
def test_the_force_there_is_asks_for_no_move_even_in_sliding(ratio: float) -> None:
    model = Dahl(stiffness_n_per_mm=0.3, coulomb_n=0.7)
    z_mm = ratio * dahl.saturation_mm(model)
    assert dahl.inverse_step(model, z_mm, dahl.output_n(model, z_mm)) == (0.0, True)
