"""The figures of the benchmark as tables, from what the command wrote."""

from opensuction.evidence.benchmark.benchmark_page import Entry, by_plant, changes, least

OTHERS = ("none", "direct-inverse", "gap-width", "lookup-table")
"""Compensators that are others': the paper's, and the literature's baselines."""


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _row(plant: str, entries: dict[str, Entry], names: list[str], key: str) -> str:
    best = min((entry[key] for entry in entries.values() if entry[key] is not None), default=None)
    cells = []
    for name in names:
        entry = entries[name]
        text = _number(entry[key])
        if key == "rmse_mm" and entry[key] is not None:
            text += f" ({_number(entry['rmse_worst_mm'])})"
        cells.append(f"**{text}**" if entry[key] is not None and entry[key] == best else text)
    return f"| {plant} | {' | '.join(cells)} |"


def _cell(found: tuple[str, float] | None) -> str:
    return "-" if found is None else f"{_number(found[1])} `{found[0]}`"


def _ours(entries: dict[str, Entry]) -> list[Entry]:
    return [entry for name, entry in entries.items() if name not in OTHERS]


def _out_of_class(rows: dict[str, dict[str, Entry]]) -> list[str]:
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
        if paper is not None and not paper["in_class"]:
            floor, scheme = _number(paper["floor_mm"]), _number(paper["rmse_mm"])
            lines.append(f"| {plant} | {_cell(least(_ours(entries)))} | {scheme} | {floor} |")
    return lines


def _changed(rows: dict[str, dict[str, Entry]], names: list[str]) -> list[str]:
    """The least of ours on each plant, as identified and changed afterwards."""
    lines = ["", "Changed after the identification: the least of our compensators, RMSE in mm."]
    lines += [
        "",
        f"| plant | as identified | {' | '.join(names)} |",
        "|---" * (len(names) + 2) + "|",
    ]
    for plant, entries in rows.items():
        ours = _ours(entries)
        if any(entry["disturbances"] for entry in ours):
            found = (least(ours, name) for name in (None, *names))
            lines.append(f"| {plant} | {' | '.join(map(_cell, found))} |")
    return lines


def markdown(data: Entry) -> str:
    """All tables, from the JSON object of the command."""
    names, rows = by_plant(data["results"])
    head = f"| plant | {' | '.join(f'`{name}`' for name in names)} |"
    rule = "|---" * (len(names) + 1) + "|"
    seeds = data["seeds"]
    lines = [f"Seeds {seeds[0]} to {seeds[-1]}."]
    for caption, key in (
        ("RMSE in mm: mean of the seeds, worst seed in parentheses", "rmse_mm"),
        ("Largest error of all seeds, mm", "peak_mm"),
    ):
        lines += ["", f"{caption}; the least of each row is bold.", "", head, rule]
        lines += [_row(plant, entries, names, key) for plant, entries in rows.items()]
    lines += ["", "Fastest head of all seeds, mm/s.", "", head, rule]
    for plant, entries in rows.items():
        speeds = (_number(entries[name]["head_mm_per_s"]) for name in names)
        lines.append(f"| {plant} | {' | '.join(speeds)} |")
    lines += [*_out_of_class(rows), *_changed(rows, changes(data["results"]))]
    runs = sum(entry["seeds"] for entry in data["results"])
    completed = sum(entry["completed"] for entry in data["results"])
    trips = sum(entry["trips"] for entry in data["results"])
    lines += ["", f"{completed} of {runs} runs completed; {trips} trips."]
    for entry in data["results"]:
        if entry["refused"]:
            pair = f"`{entry['compensation']}` on {entry['plant']}"
            lines.append(f"Refused: {pair}: {entry['refused']}.")
    return "\n".join(["", *lines, "", ""])
