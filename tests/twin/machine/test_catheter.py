import pytest

from opensuction.kernel.errors import InputError
from opensuction.twin import parameter, preset
from opensuction.twin.machine import catheter, suction_line
from opensuction.twin.machine.catheter import CATHETERS, PAPER, Catheter, Conduit
from opensuction.twin.patient import patient_preset
from opensuction.twin.patient.patient_parameter import PRESETS

VALUES = parameter.nominal(parameter.CLINICAL)
SMALL = CATHETERS["6fr"]


def open_flow_l_per_min(name: str, vacuum_mmhg: float) -> float:
    line = preset.machine(VALUES, catheter=CATHETERS[name]).line
    return 0.06 * suction_line.bore_flow_ml_per_s(line, vacuum_mmhg, 1.0)


def test_the_paper_s_catheter_is_as_computed_from_its_sizes() -> None:
    """Wall 2.945 mm2 and second moment 5.20 mm4."""
    assert catheter.wall_mm2(PAPER) == pytest.approx(2.945, abs=5e-4)
    assert catheter.second_moment_mm4(PAPER) == pytest.approx(5.20, abs=5e-3)


def test_the_paper_s_catheter_changes_no_parameter() -> None:
    for seed in range(20):
        values = parameter.draw(parameter.BENCH, seed)
        assert catheter.adapt(values, PAPER, catheter.lay("standard", PAPER)) == values


@pytest.mark.parametrize(
    ("vacuum_mmhg", "l_per_min"), [(80.0, 15.8), (100.0, 17.7), (120.0, 19.5), (150.0, 21.8)]
)
def test_the_wide_bore_passes_its_turbulent_flow(vacuum_mmhg: float, l_per_min: float) -> None:
    """Root of the vacuum instead of Blasius' power of 4/7: within 0.1 L/min here."""
    assert open_flow_l_per_min("12fr", vacuum_mmhg) == pytest.approx(l_per_min, abs=0.15)


def test_the_narrow_bore_lies_between_turbulent_and_laminar_flow() -> None:
    turbulent = 17.7 * (1.5 / 3.5) ** (19.0 / 7.0)
    laminar = 2.76  # Hagen-Poiseuille, 2 m of 1.5 mm at 100 mmHg, 18 uPa s
    assert turbulent < open_flow_l_per_min("6fr", 100.0) < laminar
    assert open_flow_l_per_min("6fr", 100.0) == pytest.approx(2.44, abs=0.01)


def test_a_still_narrower_bore_flows_laminar() -> None:
    """Below the critical Reynolds number the fourth power rules."""
    narrow = SMALL._replace(bore_mm=0.8)
    narrower = SMALL._replace(bore_mm=0.4)
    ratio = catheter.free_flow_l_per_min(narrow, 17.7) / catheter.free_flow_l_per_min(
        narrower, 17.7
    )
    assert ratio == pytest.approx(16.0)


@pytest.mark.parametrize("name", CATHETERS)
def test_every_conduit_leaves_two_millimetres_at_most(name: str) -> None:
    chosen = CATHETERS[name]
    for route in catheter.ROUTES:
        laid = catheter.lay(route, chosen)
        catheter.check(chosen, laid)
        assert chosen.bore_mm < chosen.outer_mm < laid.bore_mm <= chosen.outer_mm + 2.0


@pytest.mark.parametrize("name", PRESETS)
def test_a_patient_s_catheter_takes_less_than_the_allowed_share_of_the_tube(name: str) -> None:
    """Half of it; 70 % in neonates."""
    patient = patient_preset.patient(name, 1)
    chosen = catheter.for_patient(patient)
    assert chosen.outer_mm / patient.tube_id_mm < (0.7 if name == "neonate" else 0.5)
    assert preset.machine(VALUES, patient).catheter_mm == chosen.outer_mm


def test_a_narrow_catheter_is_softer_and_takes_up_less() -> None:
    small = catheter.adapt(VALUES, SMALL, catheter.lay("standard", SMALL))
    assert small["catheter_n_per_mm"] == pytest.approx(
        0.467 * VALUES["catheter_n_per_mm"], rel=1e-2
    )
    assert small["buckling_n"] == pytest.approx(0.103 * VALUES["buckling_n"], rel=1e-2)
    uptake = small["uptake_ml_per_s_per_mmhg"] / VALUES["uptake_ml_per_s_per_mmhg"]
    assert uptake == pytest.approx((1.5 / 3.5) ** 4)
    assert small["clearance_mm"] == VALUES["clearance_mm"]


def test_the_standard_conduit_is_the_paper_s() -> None:
    assert catheter.lay("standard", PAPER) == Conduit(6.0, 1500.0, 9.6)
    assert catheter.gap_ratio(PAPER, catheter.lay("standard", PAPER)) == 1.0


@pytest.mark.parametrize("route", catheter.ROUTES)
def test_the_gap_is_bend_times_clearance(route: str) -> None:
    """[calc-gap-width]: 11 rad x 2 mm in the paper's conduit."""
    laid = catheter.lay(route, PAPER)
    widths = preset.machine(VALUES, conduit=laid).transmission.widths_mm
    assert sum(widths) / len(widths) == pytest.approx(laid.bend_rad * 2.0)
    assert min(widths) > 0.0


def test_a_tighter_conduit_narrows_the_gap() -> None:
    tight = catheter.lay("standard", PAPER)._replace(bore_mm=5.0)
    fitted = catheter.adapt(VALUES, PAPER, tight)
    assert fitted["clearance_mm"] == 1.0
    assert fitted["width_spread_mm"] == 0.5 * VALUES["width_spread_mm"]


@pytest.mark.parametrize(
    ("chosen", "laid", "arithmetic"),
    [
        (PAPER._replace(bore_mm=4.0), Conduit(6.0, 1500.0, 9.6), r"4 mm cannot have a bore of 4"),
        (PAPER, Conduit(3.5, 1500.0, 9.6), r"bore of 3\.5 mm less 4 mm leaves -0\.5 mm"),
        (PAPER, Conduit(9.0, 1500.0, 9.6), r"leaves 5 mm of clearance, it should be 0\.2 to 4"),
        (PAPER, Conduit(6.0, 1800.0, 9.6), r"2000 - 1800 = 200 mm .* needs 300 mm"),
    ],
)
def test_what_does_not_fit_is_refused_with_the_arithmetic(
    chosen: Catheter, laid: Conduit, arithmetic: str
) -> None:
    with pytest.raises(InputError, match=arithmetic):
        catheter.check(chosen, laid)
