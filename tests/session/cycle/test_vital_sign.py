"""Vital signs of a run: before, extremes, and whether and when they were back."""

import numpy as np
import numpy.typing as npt
import pytest

from opensuction.kernel.vocabulary import AgeGroup, Phase
from opensuction.result.cycle_result import SignCourse
from opensuction.safety import limits
from opensuction.session.cycle import summary_section
from opensuction.simulation.trace import Columns

BEGAN_S, END_S = 4.0, 60.0
TIME_S = np.arange(round(END_S / 1e-3)) * 1e-3
LIMITS = limits.limits_of(AgeGroup.ADULT, 6.0, monitored=True)


def _columns(**changes: npt.NDArray[np.float64]) -> Columns:
    """A run that inserts at 4 s, on a patient in whom nothing changes."""
    flat = np.ones(TIME_S.size)
    columns = {
        "time_s": TIME_S,
        "phase": np.where(TIME_S < BEGAN_S, float(Phase.CHECKING), float(Phase.INSERTING)),
        "truth.spo2_percent": 96.0 * flat,
        "truth.heart_rate_per_min": 90.0 * flat,
        "truth.airway_pressure_cmh2o": 10.0 - 4.0 * np.cos(2.0 * np.pi * TIME_S / 2.0),
        "truth.lung_volume_loss_ml": 0.0 * flat,
    }
    columns["truth.relaxed_pressure_cmh2o"] = columns["truth.airway_pressure_cmh2o"]
    return columns | {f"truth.{name}": values for name, values in changes.items()}


def _sign(name: str, columns: Columns, weight_kg: float = 70.0) -> SignCourse:
    found = getattr(summary_section.vital_signs(columns, LIMITS, weight_kg), name)
    assert isinstance(found, SignCourse)
    return found


def _dip(to: float, of: float, back: float, back_s: float) -> npt.NDArray[np.float64]:
    """From one level down to another at 20 s, and to a third at an instant."""
    return np.asarray(np.interp(TIME_S, [10.0, 20.0, back_s], [of, to, back]))


def test_what_never_changes_is_back_and_has_no_instant() -> None:
    found = summary_section.vital_signs(_columns(), LIMITS, 70.0)
    for sign in found:
        assert sign is not None
        assert sign.is_back is True
        assert sign.recovered_s is None
    pressure = found.airway_pressure_cmh2o
    assert pressure is not None
    assert pressure.before == pressure.at_end == pytest.approx(6.0)  # it breathes


def test_a_fall_that_comes_back_says_when() -> None:
    values = _dip(to=86.0, of=96.0, back=96.0, back_s=40.0)
    sign = _sign("spo2_percent", _columns(spo2_percent=values))
    assert (sign.before, sign.lowest) == (96.0, 86.0)
    assert sign.is_back is True
    assert sign.recovered_s == pytest.approx(38.0, abs=0.01)  # within 1 % of 96
    assert (sign.usual_least, sign.limit_least) == (88.0, 80.0)


def test_a_fall_that_does_not_come_back_has_no_instant() -> None:
    values = _dip(to=40.0, of=96.0, back=70.0, back_s=60.0)
    sign = _sign("spo2_percent", _columns(spo2_percent=values))
    assert sign.is_back is False
    assert sign.recovered_s is None
    assert sign.at_end == pytest.approx(66.25, abs=0.1)  # the least of the last 5 s


def test_what_is_back_only_now_and_then_is_not_back() -> None:
    values = 90.0 - 20.0 * (np.sin(2.0 * np.pi * TIME_S / 4.0) > 0.0) * (TIME_S > BEGAN_S)
    rate = _sign("heart_rate_per_min", _columns(heart_rate_per_min=values))
    assert rate.is_back is False


def test_ranges_go_by_the_patient() -> None:
    columns = _columns()
    assert _sign("lung_volume_loss_ml", columns, 10.0).usual_most == pytest.approx(76.0)
    assert _sign("heart_rate_per_min", columns, 10.0).usual_least == pytest.approx(72.0)
    assert _sign("airway_pressure_cmh2o", columns, 10.0).usual_most == 40.0


def test_a_cough_is_told_from_what_the_ventilator_does() -> None:
    quiet = _columns()["truth.airway_pressure_cmh2o"]
    coughed = np.where((TIME_S > 20.0) & (TIME_S < 20.3), 70.0, quiet)
    pressure = _sign("airway_pressure_cmh2o", _columns(airway_pressure_cmh2o=coughed))
    assert pressure.highest == 70.0
    assert pressure.relaxed_highest == pytest.approx(14.0)
    assert pressure.relaxed_lowest == pytest.approx(6.0)


def test_a_clock_that_does_not_begin_at_zero_changes_nothing() -> None:
    values = _dip(to=86.0, of=96.0, back=96.0, back_s=40.0)
    columns = _columns(spo2_percent=values)
    later = columns | {"time_s": columns["time_s"] + 3600.0}
    assert summary_section.vital_signs(columns, LIMITS, 70.0) == summary_section.vital_signs(
        later, LIMITS, 70.0
    )
