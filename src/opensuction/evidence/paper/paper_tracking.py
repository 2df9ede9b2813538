"""Fig. 9 and Table I of the paper: a cycle of known travel, without and with compensation."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from opensuction.evidence.paper import claim
from opensuction.evidence.paper.claim import (
    CALIBRATED,
    COMPUTED,
    PREDICTED,
    ClaimKind,
    PaperClaim,
)
from opensuction.kernel.vocabulary import Phase
from opensuction.report.sheet import Curve, Plot, Section, Table
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation import rig as rigs
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
EXACT, PREVIEW = OURS = ("exact-inverse", "preview")
"""Compensators that the paper does not have."""
PUBLISHED = "published"
"""The paper's scheme with the parameters that the paper prints, whatever the machine."""
WHERE = "Table I"
TRIALS = "tolerance: from the scatter of five trials and of five machines"
OTHERS_PARAMETERS = (
    "they are another machine's: identified on each machine itself the same scheme leaves less"
)
SHOWN_SEED = 1
"""The trial that is drawn, as the paper draws one of its five."""


class TrackingTrial(NamedTuple):
    """One cycle under one compensation."""

    columns: Columns
    outcome: Outcome


def run_trial(compensation: str, seed: int) -> TrackingTrial:
    """The paper's cycle on a drawn bench, identified on that machine where it is compensated.

    compensation: ``PUBLISHED`` identifies nothing.
    """
    named = AFTER if compensation == PUBLISHED else compensation
    resolved = resolution.resolve(CycleChoice(RigChoice("bench", seed=seed), compensation=named))
    if compensation == PUBLISHED:
        rig = resolved.equipment.draw()
        prepared = cycle_run.assemble(resolved, rig, rigs.uncalibrated(rig.profile))
    else:
        prepared = cycle_run.prepare(resolved)
    columns = cycle_run.play(prepared)
    return TrackingTrial(columns, cycle_run.figures(prepared, columns))


class TrackingRow(NamedTuple):
    """A row of Table I: the paper's trial and ours, root mean square error."""

    trial: int
    seed: int
    """Of the machine."""
    paper_before_mm: float
    before_mm: float
    paper_after_mm: float
    after_mm: float
    published_mm: float
    """After compensation with the parameters that the paper prints."""
    exact_inverse_mm: float
    preview_mm: float


def table(trials: dict[tuple[str, int], TrackingTrial]) -> tuple[TrackingRow, ...]:
    """Rows of Table I: the paper's numbers and ours."""
    return tuple(
        TrackingRow(
            trial=number,
            seed=seed,
            paper_before_mm=before,
            before_mm=trials[BEFORE, seed].outcome.rmse_mm,
            paper_after_mm=after,
            after_mm=trials[AFTER, seed].outcome.rmse_mm,
            published_mm=trials[PUBLISHED, seed].outcome.rmse_mm,
            exact_inverse_mm=trials[EXACT, seed].outcome.rmse_mm,
            preview_mm=trials[PREVIEW, seed].outcome.rmse_mm,
        )
        for number, (seed, before, after) in enumerate(
            zip(SEEDS, BEFORE_MM, AFTER_MM, strict=True), start=1
        )
    )


def claims(rows: tuple[TrackingRow, ...]) -> list[PaperClaim]:
    """Means, scatter and reduction of Table I, and the paper's own parameters on our machines."""
    before, after = [row.before_mm for row in rows], [row.after_mm for row in rows]
    published = [row.published_mm for row in rows]
    gone, here = _reduced_percent(BEFORE_MM, AFTER_MM), _reduced_percent(before, after)
    means: tuple[tuple[str, ClaimKind, Sequence[float], Sequence[float], str], ...] = (
        ("RMSE before compensation, mean of five", CALIBRATED, BEFORE_MM, before, "mm"),
        ("RMSE after compensation, mean of five", CALIBRATED, AFTER_MM, after, "mm"),
        ("reduction of the RMSE, mean of five", CALIBRATED, gone, here, "%"),
        (
            "RMSE under the paper's own parameters, mean of five",
            PREDICTED,
            AFTER_MM,
            published,
            "mm",
        ),
    )
    spreads: tuple[tuple[str, ClaimKind, Sequence[float], Sequence[float]], ...] = (
        ("standard deviation before compensation", CALIBRATED, BEFORE_MM, before),
        ("standard deviation after compensation", PREDICTED, AFTER_MM, after),
    )
    found = [
        PaperClaim(
            name,
            WHERE,
            COMPUTED,
            kind,
            float(np.mean(paper)),
            float(np.mean(ours)),
            *claim.of_means(paper, ours),
            unit,
            (0.0, float(np.mean(BEFORE_MM))) if unit == "mm" and paper is AFTER_MM else (0.0,),
            TRIALS,
        )
        for name, kind, paper, ours, unit in means
    ]
    found[-1] = found[-1]._replace(explanation=OTHERS_PARAMETERS)
    return found + [
        PaperClaim(
            name,
            WHERE,
            COMPUTED,
            kind,
            float(np.std(paper, ddof=1)),
            float(np.std(ours, ddof=1)),
            *claim.of_spreads(paper, ours),
            "mm",
            (0.0,),
            TRIALS,
        )
        for name, kind, paper, ours in spreads
    ]


def _reduced_percent(before_mm: Sequence[float], after_mm: Sequence[float]) -> list[float]:
    return [100.0 * (1.0 - a / b) for b, a in zip(before_mm, after_mm, strict=True)]


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


def section() -> tuple[Section, list[PaperClaim], tuple[TrackingRow, ...]]:
    """Fig. 9 and Table I with their claims and the rows of the table."""
    trials = {
        (name, seed): run_trial(name, seed)
        for name in (BEFORE, AFTER, PUBLISHED, *OURS)
        for seed in SEEDS
    }
    rows = table(trials)
    found = claims(rows)
    errors_mm = list(zip(*(row[2:] for row in rows), strict=True))
    means = tuple(float(np.mean(column)) for column in errors_mm)
    spreads = tuple(float(np.std(column, ddof=1)) for column in errors_mm)
    columns = (
        "trial",
        "seed",
        "before: paper",
        "before",
        "after: paper",
        "after",
        "its parameters",
        *OURS,
    )
    shown = Table(
        "Table I: RMSE in mm over 29 s, paper and twin",
        columns,
        (*rows, ("mean", "", *means), ("SD", "", *spreads)),
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
        "judged with. Before: the head follows the reference. After: eqs. (7) and (8) as printed; "
        "beside it the same with the parameters that the paper prints. "
        "The columns to the right are compensators of this software on the same machines.",
    )
    return Section("Known travel length (Fig. 9, Table I)", text, (shown,), plots), found, rows
