"""Fig. 9 and Table I of the paper: a cycle of known travel, without and with compensation."""

from typing import Any, NamedTuple

import numpy as np

from opensuction.evidence.paper.claim import PaperClaim
from opensuction.kernel.phase import Phase
from opensuction.report.sheet import Curve, Plot, Section, Table
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation.outcome import Outcome
from opensuction.simulation.trace import Columns

SEEDS = (1, 2, 3, 4, 5)
"""Five machines, as the paper has five trials."""
BEFORE_MM = (15.413, 15.552, 16.011, 14.998, 16.189)
"""Table I, before compensation."""
AFTER_MM = (2.4578, 2.2243, 2.5527, 2.3692, 2.6032)
"""Table I, after compensation."""
BEFORE, AFTER = "none", "direct-inverse"
"""The paper's two rows by our names."""
OURS = ("exact-inverse", "preview")
"""Compensators that the paper does not have."""
SHOWN_SEED = 1
"""The trial that is drawn, as the paper draws one of its five."""


class TrackingTrial(NamedTuple):
    """One cycle under one compensation."""

    columns: Columns
    outcome: Outcome


def run_trial(compensation: str, seed: int) -> TrackingTrial:
    """The paper's cycle on a drawn bench, identified on that machine where it is compensated."""
    choice = CycleChoice(RigChoice("bench", seed=seed), compensation=compensation)
    prepared = cycle_run.prepare(resolution.resolve(choice))
    columns = cycle_run.play(prepared)
    return TrackingTrial(columns, cycle_run.figures(prepared, columns))


def table(trials: dict[tuple[str, int], TrackingTrial]) -> list[dict[str, Any]]:
    """Rows of Table I: the paper's numbers and ours, RMSE in mm."""
    rows = []
    for number, (seed, before, after) in enumerate(
        zip(SEEDS, BEFORE_MM, AFTER_MM, strict=True), start=1
    ):
        row: dict[str, Any] = {
            "trial": number,
            "seed": seed,
            "paper_before_mm": before,
            "before_mm": trials[BEFORE, seed].outcome.rmse_mm,
            "paper_after_mm": after,
            "after_mm": trials[AFTER, seed].outcome.rmse_mm,
        }
        for name in OURS:
            row[f"{name.replace('-', '_')}_mm"] = trials[name, seed].outcome.rmse_mm
        rows.append(row)
    return rows


def claims(rows: list[dict[str, Any]]) -> list[PaperClaim]:
    """Means, scatter and reduction of Table I."""
    pairs = [
        (published, [row[key] for row in rows])
        for published, key in ((BEFORE_MM, "before_mm"), (AFTER_MM, "after_mm"))
    ]
    means = [[float(np.mean(values)) for values in pair] for pair in pairs]
    spreads = [[float(np.std(values, ddof=1)) for values in pair] for pair in pairs]
    reduction = [100.0 * (1.0 - after / before) for before, after in zip(*means, strict=True)]
    trials = "tolerance: one standard deviation of the paper's trials"
    machines = "tolerance: one and a half standard deviations of drawn machines"
    follows = "follows from the two above"
    scatter = "a standard deviation of five is itself known to a factor of about two"
    found = (
        ("RMSE before compensation, mean of five", means[0], 0.5, "mm", "calibrated", trials),
        ("RMSE after compensation, mean of five", means[1], 0.25, "mm", "calibrated", machines),
        ("reduction of the mean RMSE", reduction, 2.0, "%", "calibrated", follows),
        ("standard deviation before compensation", spreads[0], 0.25, "mm", "predicted", scatter),
        ("standard deviation after compensation", spreads[1], 0.1, "mm", "predicted", scatter),
    )
    return [
        PaperClaim(name, "Table I", paper, ours, tolerance, unit, origin, note)
        for name, (paper, ours), tolerance, unit, origin, note in found
    ]


def _inside(found: TrackingTrial) -> tuple[Columns, float]:
    """The cycle from the start of insertion, and when that was."""
    start = int(np.argmax(found.columns["phase"] == Phase.INSERTING))
    columns = {name: values[start:] for name, values in found.columns.items()}
    return columns, float(found.columns["time_s"][start])


def _tracking(found: TrackingTrial, title: str, caption: str) -> Plot:
    columns, start_s = _inside(found)
    return Plot(
        title,
        "Time (s)",
        "Tip (mm)",
        (
            Curve("desired", columns["demand.reference_mm"], "reference", True),
            Curve("measured by the laser", columns["truth.laser_mm"], "tip"),
        ),
        columns["time_s"] - start_s,
        caption,
    )


def _error(trials: dict[tuple[str, int], TrackingTrial]) -> Plot:
    hues = dict(zip((BEFORE, AFTER, *OURS), ("head", "tip", "valve", "tip-vacuum"), strict=False))
    curves = []
    for name, hue in hues.items():
        columns, start_s = _inside(trials[name, SHOWN_SEED])
        error = columns["truth.laser_mm"] - columns["demand.reference_mm"]
        curves.append(Curve(name, error, hue, x=columns["time_s"] - start_s))
    return Plot("Fig. 9(c): tracking error", "Time (s)", "Tip minus desired (mm)", tuple(curves))


def _cam(found: TrackingTrial) -> Plot:
    columns, start_s = _inside(found)
    return Plot(
        "Fig. 9(d): cam of the suction valve",
        "Time (s)",
        "Cam (degrees)",
        (Curve("cam", np.degrees(columns["readings.cam_rad"]), "valve"),),
        columns["time_s"] - start_s,
        "30 degrees at 15 degrees per second, as in the paper.",
    )


def section() -> tuple[Section, list[PaperClaim], list[dict[str, Any]]]:
    """Fig. 9 and Table I with their claims and the rows of the table."""
    trials = {
        (name, seed): run_trial(name, seed) for name in (BEFORE, AFTER, *OURS) for seed in SEEDS
    }
    rows = table(trials)
    found = claims(rows)
    cells = [tuple(row.values()) for row in rows]
    means = tuple(float(np.mean([row[key] for row in rows])) for key in list(rows[0])[2:])
    spreads = tuple(float(np.std([row[key] for row in rows], ddof=1)) for key in list(rows[0])[2:])
    columns = ("trial", "seed", "before: paper", "before", "after: paper", "after", *OURS)
    shown = Table(
        "Table I: RMSE in mm over 29 s, paper and twin",
        columns,
        (*cells, ("mean", "", *means), ("SD", "", *spreads)),
    )
    before, after = trials[BEFORE, SHOWN_SEED], trials[AFTER, SHOWN_SEED]
    plots = (
        _tracking(before, "Fig. 9(a): no compensation", "The tip lags by the gap of the conduit."),
        _tracking(after, "Fig. 9(b): the paper's compensation", "As printed, identified here."),
        _error(trials),
        _cam(after),
    )
    text = (
        "Each trial is one drawn machine of the bench, identified with other noise than it is "
        "judged with. Before: the head follows the reference. After: eqs. (7) and (8) as printed. "
        "The columns to the right are compensators of this software on the same machines.",
    )
    return Section("Known travel length (Fig. 9, Table I)", text, (shown,), plots), found, rows
