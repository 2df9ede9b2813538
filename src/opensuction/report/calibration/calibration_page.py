"""A calibration as a page: loop, what the models leave on the second run, bounds, parameters."""

from typing import NamedTuple

from opensuction.report.sheet import Curve, Plot, Section, Sheet, Table, Values
from opensuction.report.summary import Summary


class CalibrationRuns(NamedTuple):
    """The tip in both runs and as the models predict it, mm; arrays over each run's samples."""

    first_head_mm: Values
    first_tip_mm: Values
    second_head_mm: Values
    second_tip_mm: Values
    second_time_s: Values
    model_mm: Values
    """In the second run by the modified Dahl model; empty where none was found."""
    plays_mm: Values
    """The same by the plays."""


def page(data: Summary, runs: CalibrationRuns) -> Sheet:
    """The page. data: the JSON object of the command."""
    sections = [_verdict(data)]
    if data["model"] is not None:
        sections += [_runs(runs), _parameters(data)]
    elif runs.first_head_mm.size:
        loop = Curve("laser", runs.first_tip_mm, "soft", x=runs.first_head_mm)
        sections.append(
            Section("Recording", plots=(Plot("Loop", "Head (mm)", "Tip (mm)", (loop,)),))
        )
    lead = "Taken: a cycle may be compensated with it."
    if not data["accepted"]:
        lead = "No parameter file was written. " + " ".join(data["reasons"])
    run = (
        ("machine", str(data["machine"])),
        ("set up for", data["patient"] or ""),
        ("catheter", f"{data['catheter_mm']:.1f} mm"),
        ("seed", str(data["seed"])),
        ("compensation", str(data["compensation"])),
        ("date", str(data["date_utc"])),
        ("version", data["version"]),
    )
    return Sheet(
        title="Calibration of a machine",
        verdict="Calibrated" if data["accepted"] else "Refused",
        good=data["accepted"],
        lead=f"{lead} In-silico: the machine is a simulated one.",
        run=tuple((name, value) for name, value in run if value),
        sections=tuple(sections),
    )


def _verdict(data: Summary) -> Section:
    table = Table(
        "What must hold before a compensator may be driven by it",
        ("check", "here", "unit", "should be", "holds"),
        tuple(
            (entry["name"], entry["value"], entry["unit"], entry["bound"], entry["ok"])
            for entry in data["checks"]
        ),
    )
    return Section("Verdict", tuple(data["reasons"]), (table,))


def _runs(runs: CalibrationRuns) -> Section:
    head_mm, tip_mm = runs.second_head_mm, runs.second_tip_mm
    fitted = Plot(
        "Second run: the loop, and what the models say of it",
        "Head (mm)",
        "Tip (mm)",
        (
            Curve("laser", tip_mm, "soft", x=head_mm),
            Curve("modified Dahl", runs.model_mm, "head", True, head_mm),
            Curve("plays", runs.plays_mm, "tip", False, head_mm),
        ),
    )
    left = Plot(
        "Second run: laser less model",
        "Time (s)",
        "mm",
        (
            Curve("modified Dahl", tip_mm - runs.model_mm, "head"),
            Curve("plays", tip_mm - runs.plays_mm, "tip"),
        ),
        runs.second_time_s,
        "Nothing was fitted to this run. What the laser adds of noise is in both.",
    )
    samples = min(runs.first_tip_mm.size, tip_mm.size)
    repeated = Plot(
        "Second run less first",
        "Time (s)",
        "mm",
        (Curve("tip", tip_mm[:samples] - runs.first_tip_mm[:samples], "soft"),),
        runs.second_time_s[:samples],
        "The same motion twice: the noise of two readings, and what does not repeat.",
    )
    return Section("Two runs", plots=(fitted, left, repeated))


def _parameters(data: Summary) -> Section:
    model = Table(
        "Modified Dahl model",
        ("parameter", "value", "unit"),
        (
            *((name, entry["value"], entry["unit"]) for name, entry in data["parameters"].items()),
            ("gap", data["gap_mm"], "mm"),
            ("gap over nominal", data["gap_ratio"], "mm/mm"),
        ),
    )
    found = data["plays"]
    plays = Table(
        "Plays: half width and weight of each",
        ("half width, mm", "weight"),
        tuple(zip(found["thresholds_mm"], found["weights"], strict=True)),
    )
    rest = Table(
        "Plays: what they have in common",
        ("parameter", "value", "unit"),
        (
            ("slope", found["slope"], "mm/mm"),
            ("offset", found["offset_mm"], "mm"),
            ("curvature", found["curvature_per_mm"], "1/mm"),
            ("gap", found["gap_mm"], "mm"),
        ),
    )
    servo = Table(
        "Servo feedforward",
        ("parameter", "value", "unit"),
        (
            ("velocity", data["servo"]["velocity_v_s_per_mm"], "V s/mm"),
            ("friction", data["servo"]["friction_v"], "V"),
            ("left unexplained, RMS", data["servo"]["rmse_v"], "V"),
        ),
    )
    return Section("Parameters", tables=(model, plays, rest, servo))
