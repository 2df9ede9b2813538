"""The figures of the benchmark as tables, from what the command wrote."""

from collections.abc import Sequence

from opensuction.evidence.benchmark.benchmark import BenchmarkFigures, PairFigures
from opensuction.evidence.benchmark.benchmark_page import by_plant, changes, least

OTHERS = ("none", "direct-inverse", "gap-width", "lookup-table")
"""Compensators that are others': the paper's, and the literature's baselines."""


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _row(
    plant: str, values: Sequence[float | None], worst: Sequence[float | None] | None = None
) -> str:
    """A row of one figure of each compensator, the least in bold. worst: shown in parentheses."""
    best = min((value for value in values if value is not None), default=None)
    cells = []
    for k, value in enumerate(values):
        text = _number(value)
        if worst is not None and value is not None:
            text += f" ({_number(worst[k])})"
        cells.append(f"**{text}**" if value is not None and value == best else text)
    return f"| {plant} | {' | '.join(cells)} |"


def _cell(found: tuple[str, float] | None) -> str:
    return "-" if found is None else f"{_number(found[1])} `{found[0]}`"


def _ours(entries: dict[str, PairFigures]) -> list[PairFigures]:
    return [entry for name, entry in entries.items() if name not in OTHERS]


def _out_of_class(rows: dict[str, dict[str, PairFigures]]) -> list[str]:
    """The least of ours beside the paper's scheme on plants that are not ours."""
    lines = [
        "",
        "Plants out of our class: the least of our compensators beside the paper's scheme.",
    ]
    lines += [
        "",
        "| plant | least of ours, mm | `direct-inverse`, mm | scatter of its recording, mm |",
    ]
    lines.append("|---|---|---|---|")
    for plant, entries in rows.items():
        paper = entries.get("direct-inverse")
        if paper is not None and not paper.in_class:
            floor, scheme = _number(paper.floor_mm), _number(paper.rmse_mm)
            lines.append(f"| {plant} | {_cell(least(_ours(entries)))} | {scheme} | {floor} |")
    return lines


def _changed(rows: dict[str, dict[str, PairFigures]], names: list[str]) -> list[str]:
    """The least of ours on each plant, as identified and changed afterwards."""
    lines = ["", "Changed after the identification: the least of our compensators, RMSE in mm."]
    lines += [
        "",
        f"| plant | as identified | {' | '.join(names)} |",
        "|---" * (len(names) + 2) + "|",
    ]
    for plant, entries in rows.items():
        ours = _ours(entries)
        if any(entry.disturbances for entry in ours):
            found = (least(ours, name) for name in (None, *names))
            lines.append(f"| {plant} | {' | '.join(map(_cell, found))} |")
    return lines


def markdown(found: BenchmarkFigures) -> str:
    """All tables."""
    names, rows = by_plant(found.results)
    head = f"| plant | {' | '.join(f'`{name}`' for name in names)} |"
    rule = "|---" * (len(names) + 1) + "|"
    seeds = found.seeds
    lines = [f"Seeds {seeds[0]} to {seeds[-1]}."]
    caption = "RMSE in mm: mean of the seeds, worst seed in parentheses"
    lines += ["", f"{caption}; the least of each row is bold.", "", head, rule]
    for plant, entries in rows.items():
        row = [entries[name] for name in names]
        lines.append(_row(plant, [one.rmse_mm for one in row], [one.rmse_worst_mm for one in row]))
    caption = "Largest error of all seeds, mm"
    lines += ["", f"{caption}; the least of each row is bold.", "", head, rule]
    for plant, entries in rows.items():
        lines.append(_row(plant, [entries[name].peak_mm for name in names]))
    lines += ["", "Fastest head of all seeds, mm/s.", "", head, rule]
    for plant, entries in rows.items():
        speeds = (_number(entries[name].head_mm_per_s) for name in names)
        lines.append(f"| {plant} | {' | '.join(speeds)} |")
    lines += [*_out_of_class(rows), *_changed(rows, changes(found.results))]
    runs = sum(entry.seeds for entry in found.results)
    completed = sum(entry.completed for entry in found.results)
    trips = sum(entry.trips for entry in found.results)
    lines += ["", f"{completed} of {runs} runs completed; {trips} trips."]
    for entry in found.results:
        if entry.refused:
            pair = f"`{entry.compensation}` on {entry.plant}"
            lines.append(f"Refused: {pair}: {entry.refused}.")
    return "\n".join(["", *lines, "", ""])
