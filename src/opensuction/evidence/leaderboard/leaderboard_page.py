"""The leaderboard in Markdown: a table for each data set, then the models and what was left out."""

from collections.abc import Iterable, Sequence

from opensuction.evidence.leaderboard.data_set import GENERATED, THERE
from opensuction.evidence.leaderboard.leaderboard import (
    DataSetSummary,
    Entry,
    HeldOutError,
    Interval,
    LeaderboardResult,
)

USED = (THERE, GENERATED)


def write_interval(value: float, ends: Interval) -> str:
    """A figure with its interval, to three digits."""
    low, high = ends
    return f"{value:.3g} ({low:.3g} to {high:.3g})"


def _table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    cells = (tuple(cell.replace("|", "\\|") for cell in row) for row in rows)
    lines = ["| " + " | ".join(row) + " |" for row in (tuple(columns), *cells)]
    return [lines[0], "|---" * len(columns) + "|", *lines[1:]]


def _errors(error: HeldOutError) -> tuple[str, str]:
    return (
        write_interval(error.rmse_percent_of_range, error.rmse_percent_of_range_ci95),
        write_interval(error.rrse, error.rrse_ci95),
    )


def _row(entry: Entry, error: HeldOutError, unit: str) -> tuple[str, ...]:
    place = f"{entry.place}{' =' if entry.like_best and entry.place != 1 else ''}"
    fitted = f"{entry.fitted_rrse:.3g}"
    rmse = f"{error.rmse:.3g} {unit}".rstrip()
    return (place, entry.model, rmse, *_errors(error), fitted, f"{entry.seconds:.1f}")


def list_refusals(entries: Iterable[Entry]) -> list[str]:
    """Models that could not be fitted, those with the same reason in one line."""
    reasons: dict[str, list[str]] = {}
    for entry in entries:
        if entry.refused is not None:
            reasons.setdefault(entry.refused, []).append(entry.model)
    return [f"not fitted: {', '.join(names)}: {why}" for why, names in reasons.items()]


def _describe(one: DataSetSummary) -> str:
    units = f" ({', '.join(one.units)})" if one.units else ""
    return (
        f"{one.title[0].upper()}{one.title[1:]}. "
        f"{'Simulated. ' if one.simulated else ''}"
        f"Input {' and '.join(f'`{name}`' for name in one.inputs)}, output `{one.output}`{units}, "
        f"{one.sampling}. {one.fitted_samples:,} samples fitted, {one.held_out_samples:,} held "
        f"out: {one.split}. {'Published at' if one.file else 'Generated from'} {one.source}, "
        f"{one.licence}" + (f"; `{one.file}`, sha256 `{one.sha256}`." if one.file else ".")
    )


def _section(one: DataSetSummary, entries: Iterable[Entry]) -> list[str]:
    own = [entry for entry in entries if entry.data_set == one.name]
    unit = one.units[-1] if one.units else ""
    rows = [_row(entry, entry.error, unit) for entry in own if entry.error is not None]
    rows += [("", f"*{other.by}*", "", "", f"{other.rrse:.3g}", "", "") for other in one.published]
    columns = (
        "place",
        "model",
        "held out, RMSE",
        "% of range (95 %)",
        "RRSE (95 %)",
        "fitted, RRSE",
        "s",
    )
    below = [line for refusal in list_refusals(own) for line in (f"N{refusal[1:]}.", "")]
    return [f"### {one.name}", "", _describe(one), "", *_table(columns, rows), "", *below]


def _models(found: LeaderboardResult) -> list[str]:
    most = max(one.scored for one in found.models)
    # Those of a few data sets last: their places are among few.
    ranked = sorted(found.models, key=lambda one: (2 * one.scored < most, one.mean_place or 0.0))
    rows = (
        (
            one.name,
            one.words,
            str(one.scored),
            str(one.like_best),
            "-" if one.mean_place is None else f"{one.mean_place:.1f}",
        )
        for one in ranked
    )
    return _table(("model", "is", "data sets", "best, or as good", "mean place"), rows)


def markdown(found: LeaderboardResult) -> str:
    """The whole table."""
    lines = [
        f"Written by `opensuction leaderboard`, version {found.version}, {found.date_utc[:10]}. "
        "Every model was fitted to the first part of each data set and simulated over the rest "
        "from the inputs alone, in free run: it was never given what was measured there. RRSE is "
        "the root relative squared error (1: as good as the mean of the held-out output). "
        f"Intervals: {found.interval}. `=` is as good as the best, within one standard error of "
        "the difference. In italics: figures that others published, for the same samples.",
        "",
        *_models(found),
        "",
    ]
    for one in found.data_sets:
        if one.state in USED:
            lines += _section(one, found.entries)
    missing = [one for one in found.data_sets if one.state not in USED]
    if missing:
        rows = ((one.name, one.state, one.note) for one in missing)
        lines += ["### Not used", "", *_table(("data set", "state", "why"), rows), ""]
    return "\n".join(lines)
