"""Long campaign: many drawn machines under every compensation, none past a limit."""

import json
from pathlib import Path

import numpy as np
import pytest

from opensuction.control.compensation import KIND_OF_NAME
from opensuction.kernel.vocabulary import Phase
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.resolution import APPROACHES
from opensuction.simulation.trace import Columns

MACHINES = 300
FIRST_SEED = 10_000
"""Away from the seeds that were looked at while the twin was calibrated."""


def inward_with_vacuum_mm(columns: Columns) -> float:
    """Largest net advance of the tip since the valve left its seat, while it is off it."""
    # The pre-use test strokes the valve too, with the tip parked and the line vented.
    testing = columns["phase"] == Phase.CHECKING
    opened = (columns["truth.valve_open_ratio"] > 0.0) & ~testing
    if not np.any(opened):
        return 0.0
    tip = columns["truth.tip_mm"][opened]
    return float(np.max(tip - np.minimum.accumulate(tip)))


@pytest.mark.soak
@pytest.mark.parametrize("compensation", KIND_OF_NAME)
def test_no_drawn_machine_breaks_a_limit(compensation: str) -> None:
    rmse, deepest, advance = [], [], []
    for seed in range(FIRST_SEED, FIRST_SEED + MACHINES):
        choice = CycleChoice(RigChoice("bench", seed=seed), compensation=compensation)
        prepared = cycle_run.prepare(resolution.resolve(choice))
        columns = cycle_run.play(prepared)
        figures = cycle_run.figures(prepared, columns)
        assert figures.completed, seed
        assert figures.trips == (), seed
        assert figures.alarms == (), seed
        assert figures.exposure.deepest_mm <= prepared.protocol.cap_mm, seed
        assert Phase.ABORTING not in columns["phase"], seed
        rmse.append(figures.rmse_mm)
        deepest.append(figures.exposure.deepest_mm)
        advance.append(inward_with_vacuum_mm(columns))
    assert max(advance) <= 0.5
    result = {
        "compensation": compensation,
        "machines": MACHINES,
        "rmse_mm": {"mean": np.mean(rmse), "sd": np.std(rmse, ddof=1), "max": max(rmse)},
        "deepest_mm": {"mean": np.mean(deepest), "max": max(deepest)},
        "advance_with_vacuum_mm": {"max": max(advance)},
    }
    folder = Path("runs") / "soak"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"bench-{compensation}.json").write_text(json.dumps(result, indent=2) + "\n")


@pytest.mark.soak
@pytest.mark.parametrize("approach", APPROACHES)
@pytest.mark.parametrize("compensation", ["exact-inverse", "preview"])
def test_no_drawn_adult_is_suctioned_beyond_a_limit(compensation: str, approach: str) -> None:
    """Fifty ventilated adults on fifty clinical machines, within the guidelines in every one."""
    for seed in range(1, 51):
        rig = RigChoice(seed=seed)
        choice = CycleChoice(rig, approach=approach, compensation=compensation)
        prepared = cycle_run.prepare(resolution.resolve(choice))
        columns = cycle_run.play(prepared)
        figures = cycle_run.figures(prepared, columns)
        assert figures.completed, seed
        assert figures.trips == (), seed
        assert figures.alarms == (), seed
        assert figures.negative_pressure_s <= 15.0, seed
        assert figures.exposure.in_airway_s <= 30.0, seed
        assert figures.peak_vacuum_mmhg <= 1.1 * prepared.protocol.vacuum_mmhg, seed
        assert figures.exposure.deepest_mm <= prepared.protocol.cap_mm, seed
        assert figures.exposure.force_peak_n <= 0.3, seed
        assert np.count_nonzero(columns["readings.contact_closed"]) <= 2000, seed  # ticks of 1 ms
        assert inward_with_vacuum_mm(columns) <= 0.5, seed
