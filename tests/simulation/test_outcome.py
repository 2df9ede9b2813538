import math

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.interface import ABORT, START
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation import trace
from opensuction.simulation.closed_loop import COLUMNS, DT_S
from opensuction.simulation.outcome import Outcome, outcome, tracked
from opensuction.simulation.trace import Columns

MACHINE = rigs.rig("bench", 1, nominal=True).machine


def empty(ticks: int) -> Columns:
    columns: Columns = {name: np.zeros(ticks) for name in COLUMNS}
    columns["time_s"] = np.arange(ticks, dtype=np.float64) * DT_S
    return columns


def of(columns: Columns, span_s: float | None = None) -> Outcome:
    return outcome(columns, MACHINE, target_mm=90.0, secretion_ml=3.0, span_s=span_s)


@pytest.fixture(scope="module")
def cycle() -> Columns:
    rig = rigs.rig("bench", 1, nominal=True)
    calibration = rigs.uncalibrated(rig.profile)
    kind = CompensationKind.EXACT_INVERSE
    loop, start = rigs.assemble(rig, PAPER, kind, calibration, run=2)
    return trace.record(loop, start, START, 60.0)[1]


def test_figures_of_a_whole_cycle_fit_together(cycle: Columns) -> None:
    found = of(cycle)
    assert found.completed
    assert found.trips == ()
    assert found.alarms == ()
    assert found.told == ()
    assert found.harm == ()
    assert found.cycle_s == pytest.approx(cycle["time_s"].size * DT_S)
    assert found.reached_mm <= found.exposure.deepest_mm == np.max(cycle["truth.tip_mm"])
    # Dwell 9 s, withdrawal 10 s, closing stroke 2 s; opening and settling take a little.
    assert found.negative_pressure_s == pytest.approx(21.0, abs=0.5)
    # By the truth, from a millimetre in: of the first and last the phases know nothing.
    assert found.exposure.in_airway_s == pytest.approx(28.5, abs=0.7)
    assert not found.exposure.inside_at_end
    assert found.removed_percent == pytest.approx(100.0 * found.removed_ml / 3.0)
    assert 0.0 < found.rmse_mm < found.peak_error_mm


def test_a_tip_past_the_cap_that_is_given_is_a_harm(cycle: Columns) -> None:
    """Of the bench, too: rubber can be pressed. Without a cap there is none to pass."""
    cap_mm = of(cycle).exposure.deepest_mm - 0.1
    (found,) = outcome(cycle, MACHINE, 90.0, 3.0, cap_mm=cap_mm).harm
    assert (found.name, found.limit, found.unit) == ("tip-past-cap", cap_mm, "mm")
    assert found.worst == pytest.approx(cap_mm + 0.1)


def test_error_is_scored_over_the_span_asked_for(cycle: Columns) -> None:
    whole, paper = tracked(cycle, None), tracked(cycle, 29.0)
    first = int(np.argmax(cycle["phase"] == Phase.INSERTING))
    assert np.argmax(whole) == np.argmax(paper) == first
    assert np.count_nonzero(paper) == 29_000
    shifted = {**cycle, "truth.laser_mm": cycle["demand.reference_mm"] - 2.0}
    assert of(shifted, 29.0).rmse_mm == pytest.approx(2.0)
    assert of(shifted).peak_error_mm == pytest.approx(2.0)


def test_a_cycle_that_never_began_has_no_figures() -> None:
    found = of(empty(10))
    assert not found.completed
    assert math.isnan(found.rmse_mm)
    assert math.isnan(found.peak_error_mm)
    assert found.exposure.in_airway_s == 0.0
    assert found.removed_ml == 0.0


def test_no_secretions_to_begin_with_are_no_share() -> None:
    assert math.isnan(outcome(empty(10), MACHINE, 90.0, 0.0).removed_percent)


def test_an_aborted_cycle_is_not_completed() -> None:
    rig = rigs.rig("bench", 1)
    calibration = rigs.uncalibrated(rig.profile)
    loop, start = rigs.assemble(rig, PAPER, CompensationKind.NONE, calibration, run=2)
    state, before = trace.record(loop, start, START, 14.0)
    _, after = trace.record(loop, state, ABORT, 60.0)
    both = {name: np.concatenate([before[name], after[name]]) for name in COLUMNS}
    found = of(both)
    assert not found.completed
    assert found.exposure.deepest_mm > 10.0


def test_trips_are_listed_in_the_order_in_which_they_happened() -> None:
    columns = empty(100)
    columns["verdict.trips"][20:] = 1 << 9
    columns["verdict.trips"][50:] = 1 << 9 | 1 << 3
    found = of(columns).trips
    assert [int(item.trip) for item in found] == [9, 3]
    assert [item.time_s for item in found] == pytest.approx([0.020, 0.050])
