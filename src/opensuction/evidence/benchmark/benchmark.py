"""Every compensator on every plant with fixed seeds: which one is good for what.

Each pair is carried out as the plant was identified, and with what may change afterwards behind
the controller's back (`disturbance`), on all cores.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from opensuction import __version__
from opensuction.control.compensation import KIND_OF_NAME
from opensuction.evidence import worker_pool
from opensuction.evidence.benchmark.benchmark_plant import (
    DISTURBANCES,
    NOTHING,
    PLANT_OF_NAME,
    PLANTS,
    Model,
    Twin,
)
from opensuction.evidence.benchmark.plant_run import CarryOut, PlantRun, take
from opensuction.kernel.errors import InputError

COLUMNED = "bench"
"""The twin that is also played changed: eight cycles more for each compensator and seed."""
FIRST_SEED = 101
"""Seeds that no compensator was written with."""


class Disturbed(NamedTuple):
    """Result of a run on a disturbed plant."""

    rmse_mm: float
    completed: bool


class BenchmarkResult(NamedTuple):
    """One compensator on one plant, all seeds."""

    plant: str
    compensation: str
    runs: tuple[PlantRun, ...]
    refused: str
    """Why the controller refused the first refused run; empty where none was."""
    disturbed: dict[str, tuple[Disturbed, ...]]
    """By the disturbance's name; empty where the plant has no such columns."""


class Benchmark(NamedTuple):
    """All results, in the order of plants and compensators."""

    seeds: tuple[int, ...]
    results: list[BenchmarkResult]


class DisturbedFigures(NamedTuple):
    """Figures of one pair on the plant with one disturbance."""

    rmse_mm: float
    """Mean of the seeds."""
    rmse_worst_mm: float
    """Of the worst seed."""
    completed: int
    """Number of seeds."""


class PairFigures(NamedTuple):
    """Figures of one compensator on one plant, of all seeds; None where every run was refused."""

    plant: str
    compensation: str
    in_class: bool
    """Whether the plant is of the class of our twin."""
    floor_mm: float | None
    """Scatter of the recording that the plant was fitted to; None where there is none."""
    seeds: int
    """Number of runs that were not refused."""
    rmse_mm: float | None
    """Mean of the seeds."""
    rmse_worst_mm: float | None
    """Of the worst seed."""
    peak_mm: float | None
    """Largest error of all seeds."""
    head_mm_per_s: float | None
    """Fastest head of all seeds."""
    completed: int
    trips: int
    refused: str | None
    """Why the controller refused the first refused run; None where none was."""
    disturbances: Mapping[str, DisturbedFigures]
    """By the disturbance's name; empty where the plant has no such columns."""


class BenchmarkFigures(NamedTuple):
    """Figures of all pairs."""

    version: str
    """Of the software."""
    in_silico: bool
    seeds: tuple[int, ...]
    results: tuple[PairFigures, ...]
    first_seed_rmse_mm: Mapping[str, Mapping[str, float]]
    """Of the first seed alone by plant and compensator: what a quick check can repeat."""
    wall_s: float
    """Duration of the command."""


class Task(NamedTuple):
    """One plant with one seed, for a process of its own."""

    plant: str
    seed: int
    compensations: tuple[str, ...]


def seeds_of(count: int) -> tuple[int, ...]:
    """The first ``count`` seeds of the benchmark."""
    return tuple(range(FIRST_SEED, FIRST_SEED + count))


def is_disturbed(plant: Twin | Model) -> bool:
    """True for a plant with columns: every model, and of the twins the bench."""
    return isinstance(plant, Model) or plant.name == COLUMNED


def _carry_out_all(plant: str, name: str, carry_out: CarryOut, disturbed: bool) -> BenchmarkResult:
    """One compensator on one plant with one seed, undisturbed and disturbed."""
    kind = KIND_OF_NAME[name]
    try:
        found = carry_out(kind, NOTHING)
        columns: dict[str, tuple[Disturbed, ...]] = {}
        for one in DISTURBANCES if disturbed else ():
            if one.cycles > 0 and not isinstance(PLANT_OF_NAME[plant], Model):
                continue
            with suppress(InputError):  # what was learned asks for more than the cap leaves
                changed = carry_out(kind, one)
                columns[one.name] = (Disturbed(changed.rmse_mm, changed.completed),)
    except InputError as refusal:
        return BenchmarkResult(plant, name, (), str(refusal), {})
    return BenchmarkResult(plant, name, (found,), "", columns)


def _join(parts: list[BenchmarkResult]) -> BenchmarkResult:
    """One compensator on one plant, its seeds together."""
    names = [name for part in parts for name in part.disturbed]
    return BenchmarkResult(
        parts[0].plant,
        parts[0].compensation,
        tuple(run for part in parts for run in part.runs),
        next((part.refused for part in parts if part.refused), ""),
        {
            name: tuple(one for part in parts for one in part.disturbed.get(name, ()))
            for name in dict.fromkeys(names)
        },
    )


def run_on_plant(
    plant: Twin | Model,
    seeds: tuple[int, ...],
    compensations: tuple[str, ...],
    disturbed: bool = True,
) -> list[BenchmarkResult]:
    """Some compensators on one plant. disturbed: with the columns of all disturbances."""
    disturbed = disturbed and is_disturbed(plant)
    parts: list[list[BenchmarkResult]] = []
    for seed in seeds:
        carry_out = take(plant, seed)
        parts.append(
            [_carry_out_all(plant.name, name, carry_out, disturbed) for name in compensations]
        )
    return [_join(list(one)) for one in zip(*parts, strict=True)]


def play(task: Task) -> list[BenchmarkResult]:
    """One plant with one seed, in whatever process."""
    return run_on_plant(PLANT_OF_NAME[task.plant], (task.seed,), task.compensations)


def run(
    count: int,
    tell: Callable[[str], None] = lambda _: None,
    plants: tuple[Twin | Model, ...] = PLANTS,
    compensations: tuple[str, ...] = tuple(KIND_OF_NAME),
    workers: int | None = None,
) -> Benchmark:
    """Run everything, on all cores.

    count: of seeds. tell: called with a line of progress after each plant and seed. workers:
    processes; None: as many as there are cores.
    """
    seeds = seeds_of(count)
    tasks = [Task(plant.name, seed, compensations) for plant in plants for seed in seeds]
    finished = 0

    def hear(number: int, _: object) -> None:
        nonlocal finished
        finished += 1
        task = tasks[number]
        tell(f"{finished} of {len(tasks)}: {task.plant}, seed {task.seed}")

    # The first one here: whatever must be compiled is, once.
    answers = [play(tasks[0])]
    hear(0, None)
    cores = worker_pool.count_cores() if workers is None else workers
    answers += worker_pool.spread(
        play, tasks[1:], cores, lambda number, _: hear(number + 1, None), tell
    )
    results = []
    for first in range(0, len(tasks), count):
        group = answers[first : first + count]
        results += [_join(list(one)) for one in zip(*group, strict=True)]
    return Benchmark(seeds, results)


def _round(value: float) -> float:
    """To a tenth of a micrometre: further digits are the arithmetic of one processor."""
    return round(value, 4)


def figures(result: BenchmarkResult) -> PairFigures:
    """Figures of one pair."""
    errors_mm = [run.rmse_mm for run in result.runs]
    peaks_mm = [float(np.max(np.abs(run.error_mm))) for run in result.runs]
    plant = PLANT_OF_NAME[result.plant]
    return PairFigures(
        plant=result.plant,
        compensation=result.compensation,
        in_class=plant.in_class,
        floor_mm=_rounded(plant.floor_mm) if isinstance(plant, Model) else None,
        seeds=len(result.runs),
        rmse_mm=_round(float(np.mean(errors_mm))) if errors_mm else None,
        rmse_worst_mm=_rounded(max(errors_mm, default=None)),
        peak_mm=_rounded(max(peaks_mm, default=None)),
        head_mm_per_s=_rounded(max((run.head_mm_per_s for run in result.runs), default=None)),
        completed=sum(run.completed for run in result.runs),
        trips=sum(run.trips for run in result.runs),
        refused=result.refused or None,
        disturbances={name: _disturbed(runs) for name, runs in result.disturbed.items()},
    )


def _rounded(value: float | None) -> float | None:
    return None if value is None else _round(value)


def _disturbed(runs: tuple[Disturbed, ...]) -> DisturbedFigures:
    """runs: at least one."""
    errors_mm = [one.rmse_mm for one in runs]
    return DisturbedFigures(
        rmse_mm=_round(float(np.mean(errors_mm))),
        rmse_worst_mm=_round(max(errors_mm)),
        completed=sum(one.completed for one in runs),
    )


def _first_seed_rmse_mm(found: Benchmark) -> dict[str, dict[str, float]]:
    first: dict[str, dict[str, float]] = {}
    for result in found.results:
        if result.runs:
            rmse_mm = _round(result.runs[0].rmse_mm)
            first.setdefault(result.plant, {})[result.compensation] = rmse_mm
    return first


def to_figures(found: Benchmark, wall_s: float) -> BenchmarkFigures:
    """The result of the command."""
    return BenchmarkFigures(
        version=__version__,
        in_silico=True,
        seeds=found.seeds,
        results=tuple(figures(result) for result in found.results),
        first_seed_rmse_mm=_first_seed_rmse_mm(found),
        wall_s=wall_s,
    )
