"""The benchmark's figures on a few pairs, and what is committed of it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from docs.generator import benchmark_table
from opensuction.control.compensation import KIND_OF_NAME, CompensationKind
from opensuction.controller import machine_profile
from opensuction.evidence.benchmark import benchmark
from opensuction.evidence.benchmark.benchmark_plant import NAMES, PLANTS, of_record
from opensuction.hysteresis.play import Play
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import START
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import ideal_loop, trace
from opensuction.simulation import rig as rigs

DOCS = Path(__file__).resolve().parents[3] / "docs"
COMMITTED: dict[str, Any] = json.loads(
    (DOCS / "evidence" / "2026-11-23-benchmark.json").read_text(encoding="utf-8")
)
PLANT_OF_NAME = {plant.name: plant for plant in PLANTS}


def committed(plant: str, compensation: str) -> dict[str, Any]:
    """One entry of the committed result."""
    return next(
        entry
        for entry in COMMITTED["results"]
        if (entry["plant"], entry["compensation"]) == (plant, compensation)
    )


def test_the_committed_result_has_every_pair_once() -> None:
    pairs = [(entry["plant"], entry["compensation"]) for entry in COMMITTED["results"]]
    assert pairs == [(plant, name) for plant in NAMES for name in KIND_OF_NAME]


@pytest.mark.parametrize("plant", ["bench-x1.3", "play"])
def test_a_sample_run_again_lies_within_the_committed_result(plant: str) -> None:
    names = ("none", "preview")
    results = benchmark.run_on_plant(PLANT_OF_NAME[plant], benchmark.seeds_of(1), names)
    assert [result.compensation for result in results] == list(names)
    for result in results:
        again, kept = benchmark.figures(result), committed(plant, result.compensation)
        # The committed figures are rounded to .0001 mm; another processor's last bits, passed on
        # by the search in an identification, are far below a micrometre.
        shown = COMMITTED["first_seed_rmse_mm"][plant][result.compensation]
        assert again["rmse_mm"] == pytest.approx(shown, abs=1e-3)
        assert again["rmse_mm"] <= kept["rmse_worst_mm"] + 1e-3
        assert again["peak_mm"] <= kept["peak_mm"] + 1e-3
        assert again["completed"] == 1
        assert again["trips"] == 0


def test_without_compensation_the_tip_of_a_play_lags_by_its_gap() -> None:
    """Closed form: in steady motion the tip of a play under head = reference is off by a constant.

    On the way in ``gain (r - w/2) + offset - r``, and on the way out with + w/2.
    """
    model = Play(width_mm=20.0, gain=1.0, offset_mm=0.0)
    plant = of_record("play", model)
    run = benchmark.run_on_model(
        plant, CompensationKind.NONE, rigs.uncalibrated(machine_profile.BENCH)
    )
    # Peak: half the width, on either side. An ideal servo follows a trapezoid without error but
    # for the step of its first tick.
    assert np.max(run.error_mm) == pytest.approx(10.0, abs=0.02)
    assert np.min(run.error_mm) == pytest.approx(-10.0, abs=0.02)
    assert run.head_mm_per_s == pytest.approx(PAPER.insertion_mm_per_s, rel=0.02)


def test_a_model_plant_is_known_only_by_its_noisy_recording() -> None:
    model = Play(width_mm=20.0, gain=0.95, offset_mm=-2.0)
    found = benchmark.identify(of_record("play", model), 101)
    width = float(found.width.inwards_mm[0] - found.width.outwards_mm[0])
    # .08 mm of noise over 40,000 samples: a micrometre on the mean, some more on the width.
    assert width == pytest.approx(20.0, abs=0.02)
    assert width != 20.0


def test_the_ideal_loop_asks_for_what_the_procedure_asks_for() -> None:
    """The same plan in the whole controller gives the same references and announcements."""
    rig = rigs.rig("bench", 101, nominal=True)
    loop, state = rigs.assemble(
        rig, PAPER, CompensationKind.EXACT_INVERSE, rigs.uncalibrated(rig.profile), 2
    )
    _, columns = trace.record(loop, state, START, 60.0)
    # The controller waits for its servo to settle before it inserts; the ideal one has none.
    inserting = np.flatnonzero(columns["phase"] == Phase.INSERTING)[0]
    course = ideal_loop.course(loop.controller.plan)
    demand = course.demand[course.insertion_tick :]
    there = slice(inserting, inserting + demand.shape[0])
    # Each phase of the controller may begin some ticks later: it waits for an event.
    ticks = 10
    asked = columns["demand.reference_mm"][there]
    assert demand[:, 0] == pytest.approx(asked, abs=PAPER.insertion_mm_per_s * 0.001 * ticks)
    for column, name in ((2, "demand.direction"), (3, "demand.starts_in_s")):
        # No compensator tells 0 (moving) from below 0 (nothing announced); while the controller's
        # servo settles at the end of the way in it still says 0.
        ours, theirs = demand[:, column], columns[name][there]
        if name == "demand.starts_in_s":
            ours, theirs = np.maximum(ours, 0.0), np.maximum(theirs, 0.0)
        differs = np.abs(ours - theirs) > 0.001 * ticks
        assert np.count_nonzero(differs) <= ticks, name


def test_a_refused_pair_is_a_gap_in_the_tables_and_a_sentence() -> None:
    found = benchmark.BenchmarkResult("bench", "none", (), "cap_mm: too low")
    entry = benchmark.figures(found)
    assert entry["rmse_mm"] is None
    assert entry["seeds"] == entry["completed"] == 0
    text = benchmark_table.markdown({"seeds": [101], "results": [entry]})
    assert "| bench | - |" in text
    assert "Refused: `none` on bench: cap_mm: too low." in text
