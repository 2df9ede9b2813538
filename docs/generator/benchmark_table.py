"""The figures of the benchmark as tables, from what the command wrote."""

from opensuction.evidence.benchmark.benchmark_page import Entry, by_plant


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
    runs = sum(entry["seeds"] for entry in data["results"])
    completed = sum(entry["completed"] for entry in data["results"])
    trips = sum(entry["trips"] for entry in data["results"])
    lines += ["", f"{completed} of {runs} runs completed; {trips} trips."]
    for entry in data["results"]:
        if entry["refused"]:
            pair = f"`{entry['compensation']}` on {entry['plant']}"
            lines.append(f"Refused: {pair}: {entry['refused']}.")
    return "\n".join(["", *lines, "", ""])
