"""Units in the names of columns: known ones in their usual spellings, never a guess."""

import pytest

from opensuction.kernel.errors import InputError
from opensuction.recording.column_unit import find_unit, seconds_of_column, unit_of_column


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("tip_mm", "mm"),
        ("TIP (MM)", "mm"),
        ("headMm", "mm"),
        ("Head (mm) left", "mm"),
        ("Head (mm, raw)", "mm"),
        ("pos_mm (filtered)", "mm"),
        ("Spindle [°]", "deg"),
        ("angle_degrees", "deg"),
        ("x / mm", "mm"),
        ("F [mN]", "mN"),
        ("v (m/s)", "m/s"),
        ("a (m/s²)", "m/s^2"),
        ("k [V/mm]", "V/mm"),
        ("jaw_torque_Nm", "Nm"),
        ("vacuum_mmhg", "mmHg"),
        ("speed_mm_per_s", "mm/s"),
        ("signal (%)", "%"),
        ("ratio (-)", ""),
    ],
)
def test_units_are_found_as_people_write_them(name: str, unit: str) -> None:
    assert unit_of_column(name) == unit


@pytest.mark.parametrize(
    "name",
    ["pos (5)", "motor_a", "motor_A", "x_in", "head_min", "head_bar", "x_m", "left_n", "tip/head"],
)
def test_what_is_more_often_something_else_is_no_unit(name: str) -> None:
    assert unit_of_column(name) == ""


@pytest.mark.parametrize(
    ("name", "unit"),
    [("current_a", "A"), ("force_n", "N"), ("supply_v", "V"), ("FORCE (N)", "N"), ("t_min", "min")],
)
def test_one_letter_is_a_unit_of_what_the_name_speaks_of(name: str, unit: str) -> None:
    assert unit_of_column(name) == unit


@pytest.mark.parametrize("name", ["Head (furlong)", "Motor (a)", "Force (N) vs (mm)"])
def test_brackets_that_hold_no_known_unit_are_asked_for(name: str) -> None:
    assert unit_of_column(name) is None


def test_a_unit_that_is_given_is_spelled_as_the_others() -> None:
    assert [find_unit(text) for text in ("Millimeter", "msec", "rubber")] == ["mm", "ms", None]


@pytest.mark.parametrize(
    ("name", "seconds"),
    [
        ("t", 1.0),
        ("t (msec)", 1e-3),
        ("time (minutes)", 60.0),
        ("time_minutes", 60.0),
        ("timeMs", 1e-3),
        ("t / ms", 1e-3),
        ("t_ns", 1e-9),
        ("TIME (S)", 1.0),
        ("day (hours)", 3600.0),
    ],
)
def test_times_are_taken_in_the_unit_of_their_column(name: str, seconds: float) -> None:
    assert seconds_of_column(name, None) == seconds


def test_a_time_of_another_unit_asks_for_one() -> None:
    for name, words in (
        ("t (ticks)", "in ticks, no unit of time; give --time-unit"),
        ("t (jiffies)", "no known unit; give --time-unit"),
        ("head_mm", "in mm, no unit of time; give --time-unit"),
    ):
        with pytest.raises(InputError, match=words) as refused:
            seconds_of_column(name, None)
        assert "\n" not in str(refused.value)
        assert seconds_of_column(name, "milliseconds") == 1e-3
    with pytest.raises(InputError, match="--time-unit 'mm': should be one of ns, us, ms"):
        seconds_of_column("t", "mm")
