"""The benchmark's result in columns, as it is committed: a quarter of what the command writes.

Every figure is in it, unrounded; names stand once instead of in each pair. Made by
``opensuction benchmark --json | python -m docs.generator.benchmark_columns``.
"""

import json
import sys
from collections.abc import Mapping
from typing import Any, NamedTuple

from pydantic import TypeAdapter

from opensuction.evidence.benchmark.benchmark import (
    BenchmarkFigures,
    DisturbedFigures,
    PairFigures,
)
from opensuction.evidence.benchmark.benchmark_page import by_plant, changes

Numbers = tuple[float | None, ...]
Counts = tuple[int | None, ...]
Json = dict[str, Any]


class DisturbedColumns(NamedTuple):
    """Figures of a plant with one disturbance, by compensator; None where a pair has none."""

    rmse_mm: Numbers
    rmse_worst_mm: Numbers
    completed: Counts


class PlantColumns(NamedTuple):
    """Figures of a plant, by compensator; see `PairFigures`."""

    in_class: tuple[bool, ...]
    floor_mm: Numbers
    seeds: tuple[int, ...]
    rmse_mm: Numbers
    rmse_worst_mm: Numbers
    peak_mm: Numbers
    head_mm_per_s: Numbers
    completed: tuple[int, ...]
    trips: tuple[int, ...]
    refused: tuple[str | None, ...]
    disturbances: Mapping[str, DisturbedColumns]
    first_seed_rmse_mm: Numbers


class BenchmarkColumns(NamedTuple):
    """The result; every plant has a pair with every compensator."""

    version: str
    in_silico: bool
    seeds: tuple[int, ...]
    compensations: tuple[str, ...]
    plants: Mapping[str, PlantColumns]
    wall_s: float


FIGURES = tuple(name for name in PlantColumns._fields if name in PairFigures._fields[2:-1])
"""Columns that hold a field of every pair."""


def _columns_of(pairs: list[PairFigures], first_seed: Mapping[str, float]) -> Json:
    found: Json = {name: [getattr(pair, name) for pair in pairs] for name in FIGURES}
    found["disturbances"] = {
        change: {
            name: [getattr(pair.disturbances.get(change), name, None) for pair in pairs]
            for name in DisturbedFigures._fields
        }
        for change in changes(pairs)
    }
    found["first_seed_rmse_mm"] = [first_seed.get(pair.compensation) for pair in pairs]
    return found


def _pair_of(columns: PlantColumns, plant: str, compensation: str, at: int) -> Json:
    """A pair as the command writes it. at: place of its compensator."""
    disturbances = {
        change: {name: getattr(one, name)[at] for name in DisturbedFigures._fields}
        for change, one in columns.disturbances.items()
        if one.rmse_mm[at] is not None
    }
    figures = {name: getattr(columns, name)[at] for name in FIGURES}
    names = {"plant": plant, "compensation": compensation}
    return names | figures | {"disturbances": disturbances}


def pack(found: BenchmarkFigures) -> str:
    """A result in columns."""
    names, rows = by_plant(found.results)
    plants = {
        plant: _columns_of(
            [entries[name] for name in names], found.first_seed_rmse_mm.get(plant, {})
        )
        for plant, entries in rows.items()
    }
    head = {"version": found.version, "in_silico": found.in_silico, "seeds": found.seeds}
    return _text({**head, "compensations": names, "plants": plants, "wall_s": found.wall_s}) + "\n"


def read(text: str) -> BenchmarkFigures:
    """The result that `pack` made columns of. Raises ValidationError where that is no such."""
    told = TypeAdapter(BenchmarkColumns).validate_json(text)
    names = told.compensations
    first_seed = {
        plant: {
            name: value
            for name, value in zip(names, columns.first_seed_rmse_mm, strict=True)
            if value is not None
        }
        for plant, columns in told.plants.items()
    }
    return TypeAdapter(BenchmarkFigures).validate_python(
        {
            "version": told.version,
            "in_silico": told.in_silico,
            "seeds": told.seeds,
            "results": [
                _pair_of(columns, plant, name, at)
                for plant, columns in told.plants.items()
                for at, name in enumerate(names)
            ],
            "first_seed_rmse_mm": {plant: one for plant, one in first_seed.items() if one},
            "wall_s": told.wall_s,
        }
    )


def _text(value: Any) -> str:
    """JSON with a line for each column, and no spaces."""
    if not isinstance(value, Mapping) or not value:
        return json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    lines = [f"{json.dumps(key)}:{_text(one)}" for key, one in value.items()]
    return "{\n" + ",\n".join(lines) + "\n}"


if __name__ == "__main__":
    written = sys.stdin.read()
    sys.stdout.write(pack(TypeAdapter(BenchmarkFigures).validate_json(written)))
