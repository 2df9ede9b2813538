"""A calibration as a page: loop, what the models leave on the second run, bounds, parameters."""

from typing import NamedTuple

import numpy as np

from opensuction.report.sheet import Curve, Plot, Section, Sheet, Table, Values
from opensuction.result.calibration_result import CalibrationResult, IdentifiedModels


class Excitation(NamedTuple):
    """Head and tip in one run of the excitation, each of shape (n,)."""

    head_mm: Values
    """Encoder."""
    laser_mm: Values
    """Tip."""
    period_s: float
    """Between two samples."""


def page(
    found: CalibrationResult,
    first: Excitation,
    second: Excitation,
    predicted: tuple[Values, ...] | None,
) -> Sheet:
    """The page.

    predicted: tip in the second run by the modified Dahl model and by the plays, mm; None where
    no model was found.
    """
    sections = [_verdict(found)]
    if predicted is not None and found.identified is not None:
        sections += [_runs(first, second, *predicted), _parameters(found.identified)]
    elif first.head_mm.size:
        loop = Curve("laser", first.laser_mm, "soft", x=first.head_mm)
        sections.append(
            Section("Recording", plots=(Plot("Loop", "Head (mm)", "Tip (mm)", (loop,)),))
        )
    lead = "Taken: a cycle may be compensated with it."
    if not found.accepted:
        lead = "No parameter file was written. " + " ".join(found.reasons)
    run = (
        ("machine", found.machine),
        ("set up for", found.patient or ""),
        ("catheter", f"{found.catheter_mm:.1f} mm"),
        ("seed", str(found.seed)),
        ("compensation", found.compensation),
        ("date", found.date_utc),
        ("version", found.version),
    )
    return Sheet(
        title="Calibration of a machine",
        verdict="Calibrated" if found.accepted else "Refused",
        good=found.accepted,
        lead=f"{lead} In-silico: the machine is a simulated one.",
        run=tuple((name, value) for name, value in run if value),
        sections=tuple(sections),
    )


def _verdict(found: CalibrationResult) -> Section:
    table = Table(
        "What must hold before a compensator may be driven by it",
        ("check", "here", "unit", "should be", "holds"),
        tuple(
            (entry.name, entry.value, entry.unit, entry.bound, entry.ok) for entry in found.checks
        ),
    )
    choice = found.choice
    said = []
    if choice is not None:
        said.append(f"Compensation: {found.compensation}. {choice.reason}")
        said += [f"{model} drives no head: {why}." for model, why in choice.refused.items()]
    return Section("Verdict", (*found.reasons, *said), (table,))


def _runs(first: Excitation, second: Excitation, model_mm: Values, plays_mm: Values) -> Section:
    head_mm, tip_mm = second.head_mm, second.laser_mm
    time_s = second.period_s * np.arange(head_mm.size, dtype=np.float64)
    fitted = Plot(
        "Second run: the loop, and what the models say of it",
        "Head (mm)",
        "Tip (mm)",
        (
            Curve("laser", tip_mm, "soft", x=head_mm),
            Curve("modified Dahl", model_mm, "head", True, head_mm),
            Curve("plays", plays_mm, "tip", False, head_mm),
        ),
    )
    left = Plot(
        "Second run: laser less model",
        "Time (s)",
        "mm",
        (
            Curve("modified Dahl", tip_mm - model_mm, "head"),
            Curve("plays", tip_mm - plays_mm, "tip"),
        ),
        time_s,
        "Nothing was fitted to this run. What the laser adds of noise is in both.",
    )
    samples = min(first.laser_mm.size, tip_mm.size)
    repeated = Plot(
        "Second run less first",
        "Time (s)",
        "mm",
        (Curve("tip", tip_mm[:samples] - first.laser_mm[:samples], "soft"),),
        time_s[:samples],
        "The same motion twice: the noise of two readings, and what does not repeat.",
    )
    return Section("Two runs", plots=(fitted, left, repeated))


def _parameters(models: IdentifiedModels) -> Section:
    found, servo = models.plays, models.servo
    identified = ((name, one.value, one.unit) for name, one in models.parameters.items())
    plays = Table(
        "Plays: half width and weight of each",
        ("half width, mm", "weight"),
        tuple(zip(found.thresholds_mm, found.weights, strict=True)),
    )
    tables = (
        _values(
            "Modified Dahl model",
            *identified,
            ("gap", models.gap_mm, "mm"),
            ("gap over nominal", models.gap_ratio, "mm/mm"),
        ),
        plays,
        _values(
            "Plays: what they have in common",
            ("slope", found.slope, "mm/mm"),
            ("offset", found.offset_mm, "mm"),
            ("curvature", found.curvature_per_mm, "1/mm"),
            ("gap", found.gap_mm, "mm"),
        ),
        _values(
            "Servo feedforward",
            ("velocity", servo.velocity_v_s_per_mm, "V s/mm"),
            ("friction", servo.friction_v, "V"),
            ("left unexplained, RMS", servo.rmse_v, "V"),
        ),
    )
    return Section("Parameters", tables=tables)


def _values(caption: str, *rows: tuple[str, float | None, str]) -> Table:
    return Table(caption, ("parameter", "value", "unit"), rows)
