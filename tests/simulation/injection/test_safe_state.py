"""Predicates of safe states, on traces made by hand."""

import numpy as np
import numpy.typing as npt
import pytest

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.simulation.closed_loop import COLUMNS, DT_S
from opensuction.simulation.injection import invariant
from opensuction.simulation.injection.invariant import SafeBounds
from opensuction.simulation.trace import Columns

BOUNDS = SafeBounds(boundary_mm=-80.0, vented_mmhg=5.0, vacuum_mmhg=150.0, contact_n=0.01)


def trace(ticks: int, **changes: npt.ArrayLike) -> Columns:
    """A trace in which everything is 0 but for what is given."""
    columns: Columns = {name: np.zeros(ticks) for name in COLUMNS}
    columns["time_s"] = DT_S * np.arange(ticks, dtype=np.float64)
    for name, values in changes.items():
        room, _, field = name.partition("__")
        columns[f"{room}.{field}" if field else room] = np.full(ticks, values, np.float64)
    return columns


@pytest.mark.parametrize(
    ("name", "safe", "unsafe"),
    [
        ("tip-outside", {"truth__tip_mm": -80.0}, {"truth__tip_mm": -79.9}),
        ("valve-closed", {"truth__valve_open_ratio": 0.0}, {"truth__valve_open_ratio": 0.01}),
        ("no-suction", {"truth__tip_vacuum_mmhg": 5.0}, {"truth__tip_vacuum_mmhg": 5.1}),
        ("vented", {"truth__line_vacuum_mmhg": 5.0}, {"truth__line_vacuum_mmhg": 5.1}),
        ("vacuum-limited", {"truth__line_vacuum_mmhg": 150.0}, {"truth__line_vacuum_mmhg": 151.0}),
        ("torque-off", {"commands__insertion_on": 0.0}, {"commands__insertion_on": 1.0}),
        ("pump-off", {"commands__pump_on": 0.0}, {"commands__pump_on": 1.0}),
        ("standing", {"truth__head_mm": 30.0}, {"truth__head_mm": np.arange(200) * 0.01}),
        ("untouched", {"truth__contact_n": 0.0}, {"truth__contact_n": 0.08}),
        ("resting", {"phase": Phase.HALTED}, {"phase": Phase.ABORTING}),
        ("not-inserted", {"truth__tip_mm": -80.0}, {"truth__tip_mm": -79.9}),
    ],
)
def test_a_predicate_tells_safe_from_unsafe(
    name: str, safe: dict[str, npt.ArrayLike], unsafe: dict[str, npt.ArrayLike]
) -> None:
    assert np.all(invariant.holds(trace(200, **safe), [name], BOUNDS))
    assert not invariant.holds(trace(200, **unsafe), [name], BOUNDS)[-1]


def test_a_tip_that_was_inside_was_inserted() -> None:
    tip = np.repeat([-90.0, -70.0, -90.0], 10)
    held = invariant.holds(trace(30, truth__tip_mm=tip), ["not-inserted"], BOUNDS)
    np.testing.assert_array_equal(held, np.arange(30) < 10)


def test_all_that_is_asked_must_hold() -> None:
    columns = trace(10, truth__tip_mm=-90.0, truth__line_vacuum_mmhg=np.linspace(20.0, 0.0, 10))
    both = invariant.holds(columns, ["tip-outside", "vented"], BOUNDS)
    np.testing.assert_array_equal(both, columns["truth.line_vacuum_mmhg"] <= 5.0)


def test_an_unknown_safe_state_is_refused_with_the_known() -> None:
    with pytest.raises(InputError, match="unknown safe state 'asleep': one of tip-outside"):
        invariant.holds(trace(5), ["asleep"], BOUNDS)


def test_safe_is_from_when_it_holds_to_the_end() -> None:
    columns = trace(6)
    held = np.array([True, False, True, False, True, True])
    assert invariant.safe_s(columns, held, 0.0) == pytest.approx(4 * DT_S)
    assert invariant.safe_s(columns, held, 5 * DT_S) == pytest.approx(5 * DT_S)
    assert np.isnan(invariant.safe_s(columns, ~held, 0.0))
