"""The benchmark's figures on a few pairs, and what is committed of it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from docs.generator import benchmark_columns, benchmark_table
from opensuction.control.compensation import KIND_OF_NAME, CompensationKind
from opensuction.controller import machine_profile
from opensuction.evidence.benchmark import benchmark, benchmark_page, plant_run
from opensuction.evidence.benchmark.benchmark import PairFigures
from opensuction.evidence.benchmark.benchmark_plant import DISTURBANCE_NAMES as COLUMNS
from opensuction.evidence.benchmark.benchmark_plant import (
    DISTURBANCES,
    MODELS,
    NAMES,
    NOTHING,
    PLANT_OF_NAME,
    Model,
    of_record,
    wide_recording,
)
from opensuction.hysteresis.play import Play
from opensuction.kernel.interface import START
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning.protocol import PAPER
from opensuction.result.plain import to_json
from opensuction.simulation import rig as rigs
from opensuction.simulation import trace

SCHEME = "direct-inverse"
"""The paper's."""
DOCS = Path(__file__).resolve().parents[3] / "docs"
TEXT = (DOCS / "evidence" / "2026-11-27-benchmark.json").read_text(encoding="utf-8")
COMMITTED = benchmark_columns.read(TEXT)


def committed(plant: str, compensation: str) -> PairFigures:
    """One entry of the committed result."""
    return next(
        entry
        for entry in COMMITTED.results
        if (entry.plant, entry.compensation) == (plant, compensation)
    )


def rmse_mm(entry: PairFigures) -> float:
    """Mean of the seeds of a pair that was not refused."""
    assert entry.rmse_mm is not None
    return entry.rmse_mm


def worst_mm(entry: PairFigures) -> float:
    """RMSE of the worst seed of a pair that was not refused."""
    assert entry.rmse_worst_mm is not None
    return entry.rmse_worst_mm


def test_the_committed_result_has_every_pair_once() -> None:
    pairs = [(entry.plant, entry.compensation) for entry in COMMITTED.results]
    assert pairs == [(plant, name) for plant in NAMES for name in KIND_OF_NAME]


@pytest.mark.parametrize("plant", NAMES)
def test_the_papers_scheme_is_ahead_of_ours_on_no_plant(plant: str) -> None:
    ours = [committed(plant, name) for name in KIND_OF_NAME if name not in ("none", SCHEME)]
    least = min(ours, key=worst_mm)
    assert worst_mm(least) < rmse_mm(committed(plant, SCHEME))
    if not least.in_class:
        assert worst_mm(least) <= 0.2


@pytest.mark.parametrize("plant", ["bench-x1.3", "play"])
def test_a_sample_run_again_lies_within_the_committed_result(plant: str) -> None:
    names = ("none", "preview")
    seeds = benchmark.seeds_of(1)
    results = benchmark.run_on_plant(PLANT_OF_NAME[plant], seeds, names, disturbed=False)
    assert [result.compensation for result in results] == list(names)
    for result in results:
        again, kept = benchmark.figures(result), committed(plant, result.compensation)
        # The committed figures are rounded to .0001 mm; another processor's last bits, passed on
        # by the search in an identification, are far below a micrometre.
        shown = COMMITTED.first_seed_rmse_mm[plant][result.compensation]
        assert again.rmse_mm == pytest.approx(shown, abs=1e-3)
        assert rmse_mm(again) <= worst_mm(kept) + 1e-3
        assert again.peak_mm is not None
        assert kept.peak_mm is not None
        assert again.peak_mm <= kept.peak_mm + 1e-3
        assert again.completed == 1
        assert again.trips == 0


def test_without_compensation_the_tip_of_a_play_lags_by_its_gap() -> None:
    """Closed form: in steady motion the tip of a play under head = reference is off by a constant.

    On the way in ``gain (r - w/2) + offset - r``, and on the way out with + w/2.
    """
    model = Play(width_mm=20.0, gain=1.0, offset_mm=0.0)
    plant = of_record("play", model)
    run = plant_run.run_on_model(
        plant, CompensationKind.NONE, rigs.uncalibrated(machine_profile.BENCH)
    )
    # Peak: half the width, on either side. An ideal servo follows a trapezoid without error but
    # for the tick by which a head that is where the reference was comes late.
    assert np.max(run.error_mm) == pytest.approx(10.0, abs=0.02)
    assert np.min(run.error_mm) == pytest.approx(-10.0, abs=0.02)
    assert run.head_mm_per_s == pytest.approx(PAPER.insertion_mm_per_s, rel=0.02)


def test_a_model_plant_is_known_only_by_its_noisy_recording() -> None:
    model = Play(width_mm=20.0, gain=0.95, offset_mm=-2.0)
    found = plant_run.identify(of_record("play", model), 101)
    width = float(found.width.inwards_mm[0] - found.width.outwards_mm[0])
    # .08 mm of noise over 40,000 samples: a micrometre on the mean, some more on the width.
    assert width == pytest.approx(20.0, abs=0.02)
    assert width != 20.0


def test_on_the_paper_s_own_parameters_the_paper_s_scheme_is_not_ahead() -> None:
    carry_out = plant_run.take(PLANT_OF_NAME["bouc-wen-published"], 101)
    theirs = carry_out(CompensationKind.DIRECT_INVERSE, NOTHING).rmse_mm
    assert carry_out(CompensationKind.PRANDTL_ISHLINSKII, NOTHING).rmse_mm < 0.9 * theirs
    assert theirs < 0.02  # not for want of it


def test_the_ideal_loop_asks_for_what_the_procedure_asks_for() -> None:
    """The same plan in the whole controller gives the same references and announcements."""
    rig = rigs.rig("bench", 101, nominal=True)
    loop, state = rigs.assemble(
        rig, PAPER, CompensationKind.EXACT_INVERSE, rigs.uncalibrated(rig.profile), 2
    )
    _, columns = trace.record(loop, state, START, 60.0)
    # The controller waits for its servo to settle before it inserts; the ideal one has none.
    inserting = np.flatnonzero(columns["phase"] == Phase.INSERTING)[0]
    course = plant_run.cycle_course(loop.controller.plan)
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
    found = benchmark.BenchmarkResult("bench", "none", (), "cap_mm: too low", {})
    entry = benchmark.figures(found)
    assert entry.rmse_mm is None
    assert entry.seeds == entry.completed == 0
    text = benchmark_table.markdown(COMMITTED._replace(seeds=(101,), results=(entry,)))
    assert "| bench | - |" in text
    assert "Refused: `none` on bench: cap_mm: too low." in text


def test_the_committed_result_is_written_as_it_was_read() -> None:
    assert benchmark_columns.pack(COMMITTED) == TEXT


def test_columns_keep_every_figure_of_what_the_command_writes() -> None:
    """Refused pairs have none, and only some plants have a figure of the first seed alone."""
    first, *others = COMMITTED.results
    refused = first._replace(rmse_mm=None, seeds=0, refused="cap_mm: too low", disturbances={})
    some_seeds = {"play": {"preview": 0.1}}
    found = COMMITTED._replace(results=(refused, *others), first_seed_rmse_mm=some_seeds)
    assert to_json(benchmark_columns.read(benchmark_columns.pack(found))) == to_json(found)


def test_what_is_no_result_of_the_benchmark_is_not_read_as_one() -> None:
    data = json.loads(TEXT)
    for changed in ({}, {**data, "plants": {"play": {}}}, {**data, "seeds": ["first"]}):
        with pytest.raises(ValidationError):
            benchmark_columns.read(json.dumps(changed))


def test_of_two_that_are_alike_the_first_is_the_best() -> None:
    entry = committed("play", "preview")
    alike = [entry._replace(compensation=name) for name in ("preview", "gap-width")]
    refused = entry._replace(compensation="none", rmse_mm=None, refused="cap_mm: too low")
    other = refused._replace(plant="bench")
    assert benchmark_page.best_of([refused, *alike, other]) == {"play": alike[0]}


def test_the_worst_seed_and_the_mean_are_of_every_run_on_a_disturbed_plant() -> None:
    errors = (benchmark.Disturbed(1.0, True), benchmark.Disturbed(2.0, False))
    found = benchmark.BenchmarkResult("play", "preview", (), "", {"creep x4": errors})
    assert to_json(benchmark.figures(found))["disturbances"] == {
        "creep x4": {"rmse_mm": 1.5, "rmse_worst_mm": 2.0, "completed": 1}
    }


def test_every_plant_that_is_disturbed_has_every_column() -> None:
    for entry in COMMITTED.results:
        plant = PLANT_OF_NAME[entry.plant]
        wanted: tuple[str, ...] = ()
        if benchmark.is_disturbed(plant) and not entry.refused:
            taught = isinstance(plant, Model)  # a twin of the bench has no light barrier
            wanted = tuple(one.name for one in DISTURBANCES if taught or one.cycles == 0)
        assert tuple(entry.disturbances) == wanted, (entry.plant, entry.compensation)
        assert entry.in_class == plant.in_class


def test_the_floor_of_a_recorded_conduit_is_its_recordings_scatter() -> None:
    for plant in MODELS:
        recorded = plant.name.startswith(("preisach-", "readout-"))
        assert (plant.floor_mm is not None) == recorded
        assert committed(plant.name, "preview").floor_mm == (
            None if plant.floor_mm is None else pytest.approx(plant.floor_mm)
        )


def changed(**what: Any) -> float:
    """RMSE of exact-inverse on a recorded conduit that has changed since its identification."""
    carry_out = plant_run.take(PLANT_OF_NAME["preisach-25"], 101)
    disturbance = NOTHING._replace(**what)
    return carry_out(CompensationKind.EXACT_INVERSE, disturbance).rmse_mm


def test_a_disturbance_costs_what_it_is() -> None:
    assert changed() == pytest.approx(0.204, abs=0.01)
    # An offset adds to a mean error near 0.
    assert changed(offset_mm=2.0) == pytest.approx(2.0, abs=0.15)
    # 2 % of a tip that goes 7 to 97 mm from its place at head 0: 1.4 mm RMS over the trapezoid.
    assert changed(gain_ratio=1.02) == pytest.approx(1.4, abs=0.15)
    # 5 ms of 9 mm/s are .045 mm, two thirds of the time, beside an error of .2.
    assert changed(delay_s=0.005) == pytest.approx(changed(), abs=0.05)
    # The gap is 2 mm wide, of which a tenth are .1 mm each way, beside what is left anyway.
    assert changed(gap_ratio=1.1) > changed() + 0.05
    assert changed(creep_ratio=4.0) > changed() + 0.1


@pytest.mark.sweep
def test_two_cycles_past_a_barrier_bring_a_changed_gap_back_without_contact() -> None:
    """Asked for: at most .3 mm, of a gap 10 % off."""
    carry_out = plant_run.take(PLANT_OF_NAME["preisach-25"], 101)
    narrow = NOTHING._replace(gap_ratio=0.9)
    kind = CompensationKind.MODEL_PREVIEW
    before = carry_out(kind, narrow).rmse_mm
    after = carry_out(kind, narrow._replace(cycles=2)).rmse_mm
    assert after == pytest.approx(0.078, abs=0.01)
    assert before > 3.0 * after
    # Who compensates nothing learns nothing.
    none = CompensationKind.NONE
    taught = carry_out(none, narrow._replace(cycles=2)).rmse_mm
    assert taught == carry_out(none, narrow).rmse_mm


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(plant.name, marks=pytest.mark.sweep if plant.name == "generalised" else ())
        for plant in MODELS
        if plant.name != "preisach"
    ],
)
def test_a_models_gap_is_as_many_times_as_wide(name: str) -> None:
    """At one head position the branches of a long stroke are so many times as far apart."""
    plant = PLANT_OF_NAME[name]
    assert isinstance(plant, Model)
    laid = plant.matched(*wide_recording(101))
    heads = np.concatenate([np.linspace(0.0, 120.0, 600), np.linspace(120.0, 0.0, 600)])
    gaps = []
    for ratio in (1.0, 1.1):
        tips = laid(ratio)(heads)
        gaps.append(float(np.interp(-60.0, -heads[600:], tips[600:]) - tips[300]))
    # Lines that bend, and what a stroke of 60 mm has not yet forgotten: some per cent of it.
    assert gaps[1] / gaps[0] == pytest.approx(1.1, abs=0.012)


def test_a_twins_disturbance_is_behind_its_controllers_back() -> None:
    carry_out = plant_run.take(PLANT_OF_NAME["bench"], 101)
    none = carry_out(CompensationKind.PREVIEW, NOTHING)
    offset = next(one for one in DISTURBANCES if one.name == "offset +2 mm")
    moved = carry_out(CompensationKind.PREVIEW, offset)
    assert moved.completed
    assert np.mean(moved.error_mm - none.error_mm) == pytest.approx(2.0, abs=0.01)


def test_tables_name_the_least_of_ours_beside_the_papers_scheme() -> None:
    text = benchmark_table.markdown(COMMITTED)
    mine = {
        name: rmse_mm(committed("preisach-25", name))
        for name in KIND_OF_NAME
        if name not in benchmark_table.OTHERS
    }
    best = min(mine, key=mine.__getitem__)
    scheme = committed("preisach-25", "direct-inverse").rmse_mm
    assert f"| preisach-25 | {mine[best]:.3g} `{best}` | {scheme:.3g} |" in text
    for column in COLUMNS:
        assert column in text


def test_a_page_shows_what_was_changed() -> None:
    names = ("direct-inverse", "preview")
    seeds = benchmark.seeds_of(1)
    found = benchmark.run_on_plant(PLANT_OF_NAME["bouc-wen-published"], seeds, names)
    sheet = benchmark_page.sheet(benchmark.Benchmark(seeds, found))
    changed_section = next(one for one in sheet.sections if one.title.startswith("Changed"))
    assert [table.caption for table in changed_section.tables] == list(COLUMNS)
    assert changed_section.tables[0].columns == ("plant", *names)
