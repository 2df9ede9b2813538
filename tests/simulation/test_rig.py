import numpy as np
import pytest

from opensuction.hysteresis.play import PLAYS
from opensuction.identification.estimator import modified_dahl
from opensuction.identification.estimator.modified_dahl import Fit
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.simulation import rig as rigs
from opensuction.twin import parameter, preset
from tests.hysteresis import distributed_play


def test_more_plays_change_no_figure_of_the_bench_by_a_percent() -> None:
    nominal = rigs.rig("bench", 1, nominal=True)
    head_mm = rigs.excite(nominal)["truth.head_mm"]
    values, gain = nominal.values, nominal.machine.transmission.gain

    def identified(plays: int) -> Fit:
        mean_mm = values["bend_rad"] * values["clearance_mm"]
        widths_mm = preset.play_widths_mm(mean_mm, values["width_spread_mm"], plays)
        start_mm = distributed_play.retracted_positions_mm(widths_mm, float(head_mm[0]))
        tip_mm = distributed_play.simulate(widths_mm, gain, values["offset_mm"], head_mm, start_mm)
        return modified_dahl.fit(head_mm, tip_mm)

    few, many = identified(PLAYS), identified(48)
    assert few.model == pytest.approx(many.model, rel=0.01)
    assert few.rmse_mm == pytest.approx(many.rmse_mm, rel=0.01)


def test_a_nominal_rig_is_the_table_and_a_seed_draws_another() -> None:
    assert rigs.rig("bench", 5, nominal=True).values == parameter.nominal(parameter.BENCH)
    assert rigs.rig("bench", 5).values == parameter.draw(parameter.BENCH, 5)


def test_an_unknown_machine_is_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"'bnech'.*one of bench"):
        rigs.rig("bnech", 1)


def test_the_excitation_takes_the_head_there_and_back_twice() -> None:
    columns = rigs.excite(rigs.rig("bench", 1))
    during = columns["phase"] == Phase.IDENTIFYING
    head = columns["readings.head_mm"][during]
    assert np.count_nonzero(during) == pytest.approx(40_000, abs=1)
    # PD lags by 1.3 mm at 16 mm/s and slows down before the turns.
    assert head.max() == pytest.approx(100.0, abs=1.0)
    assert np.count_nonzero(np.diff(head > 50.0)) == 4
    assert np.all(columns["verdict.trips"] == 0.0)
    assert np.all(columns["truth.valve_open_ratio"] == 0.0)


def test_the_servo_s_feedforward_is_the_axis_it_was_fitted_to() -> None:
    rig = rigs.rig("bench", 3)
    found = rigs.identify(rig).servo
    # 24 V less friction at the no-load speed; the fit sees a moving axis for most of 40 s.
    expected = rig.values["supply_v"] / rig.values["no_load_mm_per_s"]
    assert found.velocity_v_s_per_mm == pytest.approx(expected, rel=0.01)
    assert found.friction_v == pytest.approx(rig.values["insertion_friction_v"], abs=0.03)
