import pytest

from opensuction.control import backlash_inverse
from opensuction.hysteresis import play
from opensuction.identification.estimator import branch_curve
from opensuction.kernel.errors import InputError
from tests.identification.plant import HEAD_MM

WIDTH_MM = 19.0
TIP_MM = 0.95 * play.simulate(WIDTH_MM, HEAD_MM, 0.5 * WIDTH_MM) - 6.0


def test_a_single_play_has_its_width_found() -> None:
    curves = branch_curve.fit_parallel(HEAD_MM, TIP_MM)
    inner, outer = backlash_inverse.branches_mm(curves, 40.0)
    assert inner - outer == pytest.approx(WIDTH_MM, abs=1e-3)
    assert inner == pytest.approx(46.0 / 0.95 + 0.5 * WIDTH_MM, abs=1e-3)


def test_the_table_holds_both_branches_of_a_loop_that_bends() -> None:
    bent = TIP_MM + 5e-5 * TIP_MM * TIP_MM
    curves = branch_curve.fit_table(HEAD_MM, bent)
    for tip in (10.0, 40.0, 70.0):
        inner, outer = backlash_inverse.branches_mm(curves, tip + 5e-5 * tip * tip)
        middle = (tip + 6.0) / 0.95
        # Entries are 2 mm apart, the samples around each averaged along the mean slope.
        assert inner == pytest.approx(middle + 0.5 * WIDTH_MM, abs=0.02)
        assert outer == pytest.approx(middle - 0.5 * WIDTH_MM, abs=0.02)


def test_a_recording_without_a_way_back_is_refused() -> None:
    with pytest.raises(InputError, match="outwards"):
        branch_curve.fit_table(HEAD_MM[:1000], TIP_MM[:1000])
    with pytest.raises(InputError, match="negate"):
        branch_curve.fit_parallel(HEAD_MM, -TIP_MM)
