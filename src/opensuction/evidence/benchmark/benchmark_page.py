"""The benchmark as an HTML page."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from opensuction import __version__
from opensuction.evidence.benchmark.benchmark import (
    Benchmark,
    BenchmarkResult,
    PairFigures,
    figures,
)
from opensuction.evidence.benchmark.benchmark_plant import LEFT_OUT, PLANTS
from opensuction.report.sheet import Curve, Plot, Section, Sheet, Table
from opensuction.simulation.closed_loop import DT_S

HUES = {
    "none": "head",
    "direct-inverse": "reference",
    "exact-inverse": "tip",
    "gap-width": "removed",
    "lookup-table": "deepest",
    "prandtl-ishlinskii": "tip-vacuum",
    "preview": "valve",
    "model-preview": "soft",
}
"""Colour of each compensator, by its name in the style sheet."""
METHOD = (
    "A twin runs the whole controller, its governor and a noisy machine, and is scored as the "
    "paper scores: laser minus reference, the laser's .08 mm included. A model plant runs the "
    "compensator alone, on an ideal servo within the head's speed and acceleration, and is scored "
    "without noise. Compare within a row, not between the two kinds of rows.",
    "Every plant is identified by the same excitation before it is compensated; no compensator "
    "knows a plant's parameters.",
    LEFT_OUT,
)


CHANGED = (
    "RMSE in mm, mean of the seeds, of plants that were identified as they were and then changed: "
    "gap or lag, gain from the head's position 0, offset, creep, and commands that come 5 ms late. "
    "Creep x4 on a model is four times the nominal bench's, for a model has none; a late command "
    "is the head's on an ideal servo and the drives' at a twin.",
)
PLANT_COLUMNS = ("plant", "in the class of our twin", "scatter of its recording, mm", "is")


def by_plant(
    results: Iterable[PairFigures],
) -> tuple[list[str], dict[str, dict[str, PairFigures]]]:
    """Names of the compensators, and for each plant its entries by compensator, in order."""
    names: dict[str, None] = {}
    rows: dict[str, dict[str, PairFigures]] = {}
    for entry in results:
        names[entry.compensation] = None
        rows.setdefault(entry.plant, {})[entry.compensation] = entry
    return list(names), rows


def changes(results: Iterable[PairFigures]) -> list[str]:
    """Names of the disturbances that any entry has, in order."""
    return list(dict.fromkeys(name for entry in results for name in entry.disturbances))


def least(entries: Iterable[PairFigures], change: str | None = None) -> tuple[str, float] | None:
    """The compensator with the least mean RMSE, and that, mm; None where there is none.

    entries: of one plant. change: with this disturbance; None: as identified.
    """
    found = []
    for entry in entries:
        what = entry if change is None else entry.disturbances.get(change)
        if what is not None and what.rmse_mm is not None:
            found.append((what.rmse_mm, entry.compensation))
    if not found:
        return None
    rmse_mm, name = min(found)
    return name, rmse_mm


def best_of(results: Iterable[PairFigures]) -> dict[str, PairFigures]:
    """The entry with the least mean RMSE of each plant."""
    _, rows = by_plant(entry for entry in results if entry.rmse_mm is not None)
    return {
        plant: min(entries.values(), key=lambda entry: entry.rmse_mm or 0.0)
        for plant, entries in rows.items()
    }


def _table(
    caption: str, results: Sequence[PairFigures], figure: Callable[[PairFigures], float | None]
) -> Table:
    names, rows = by_plant(results)
    cells = tuple(
        (plant, *(figure(entries[name]) if name in entries else None for name in names))
        for plant, entries in rows.items()
    )
    return Table(caption, ("plant", *names), cells)


def _changed(name: str, results: Sequence[PairFigures]) -> Table:
    """RMSE with one disturbance, of the plants that have it."""
    names, rows = by_plant(entry for entry in results if name in entry.disturbances)
    cells = tuple(
        (plant, *(entries[one].disturbances[name].rmse_mm for one in names if one in entries))
        for plant, entries in rows.items()
    )
    return Table(name, ("plant", *names), cells)


def _findings(results: Sequence[PairFigures]) -> tuple[str, ...]:
    """The main results in sentences."""
    found = [
        f"{plant}: {entry.compensation} tracks best, {entry.rmse_mm:.3g} mm RMSE (worst seed "
        f"{entry.rmse_worst_mm:.3g}), peak {entry.peak_mm:.3g} mm."
        for plant, entry in best_of(results).items()
    ]
    for entry in results:
        if entry.refused:
            found.append(f"{entry.compensation} on {entry.plant} was refused: {entry.refused}.")
        if entry.completed < entry.seeds or entry.trips:
            found.append(
                f"{entry.compensation} on {entry.plant}: {entry.completed} of "
                f"{entry.seeds} cycles completed, {entry.trips} trips."
            )
    return tuple(found)


def _plot(plant: str, results: list[BenchmarkResult], seed: int) -> Plot:
    curves = []
    for result in results:
        if result.plant == plant and result.runs:
            error = result.runs[0].error_mm
            time_s = DT_S * np.arange(error.size, dtype=np.float64)
            curves.append(Curve(result.compensation, error, HUES[result.compensation], x=time_s))
    return Plot(
        f"Error on {plant}, seed {seed}", "Time (s)", "Tip minus reference (mm)", tuple(curves)
    )


def sheet(found: Benchmark) -> Sheet:
    """The page of a benchmark."""
    entries = [figures(result) for result in found.results]
    cycles = sum(entry.seeds for entry in entries)
    completed = sum(entry.completed for entry in entries)
    trips = sum(entry.trips for entry in entries)
    refused = sum(bool(entry.refused) for entry in entries)
    plants = list(dict.fromkeys(entry.plant for entry in entries))
    about = tuple(
        (plant.name, plant.in_class, getattr(plant, "floor_mm", None), plant.about)
        for plant in PLANTS
        if plant.name in plants
    )
    tables = (
        _table("RMSE in mm, mean of the seeds", entries, lambda entry: entry.rmse_mm),
        _table("RMSE in mm, worst seed", entries, lambda entry: entry.rmse_worst_mm),
        _table("Largest error of all seeds, mm", entries, lambda entry: entry.peak_mm),
        _table("Fastest head of all seeds, mm/s", entries, lambda entry: entry.head_mm_per_s),
    )
    plots = tuple(_plot(plant, found.results, found.seeds[0]) for plant in plants)
    seeds = f"{found.seeds[0]} to {found.seeds[-1]}"
    return Sheet(
        title="Compensators on twins and models",
        verdict=f"{completed} of {cycles} runs completed, {trips} trips, {refused} pairs refused",
        good=completed == cycles and trips == 0 and refused == 0,
        lead="In-silico: every plant is a simulated one.",
        run=(("version", __version__), ("seeds", seeds)),
        sections=(
            Section("Figures", METHOD, tables),
            Section(
                "Changed after the identification",
                CHANGED,
                tuple(_changed(name, entries) for name in changes(entries)),
            ),
            Section("Findings", _findings(entries)),
            Section("Plants", (), (Table("What each plant is", PLANT_COLUMNS, about),)),
            Section("Error over time", (), (), plots),
        ),
    )
