"""A calibration as a page: loop, what the models leave on the second run, bounds, parameters."""

import numpy as np

from opensuction import __version__
from opensuction.report.sheet import Curve, Plot, Section, Sheet, Table
from opensuction.session.calibration import calibration_check, calibration_run
from opensuction.session.calibration.calibration_run import Calibrated
from opensuction.session.plain import Json
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.rig import Identification


def page(calibrated: Calibrated, data: Json) -> Sheet:
    """The page. data: the JSON object of the command."""
    sections = [_verdict(calibrated)]
    first = calibrated.first
    if calibrated.found is None and first.head_mm.size:
        loop = Curve("laser", first.laser_mm, "soft", x=first.head_mm)
        sections.append(
            Section("Recording", plots=(Plot("Loop", "Head (mm)", "Tip (mm)", (loop,)),))
        )
    if calibrated.found is not None:
        sections += [_loop(calibrated, calibrated.found), _parameters(data)]
    lead = "Taken: a cycle may be compensated with it."
    if not calibrated.accepted:
        lead = "No parameter file was written. " + " ".join(calibrated.reasons)
    run = (
        ("machine", str(data["machine"])),
        ("set up for", data["patient"] or ""),
        ("catheter", f"{data['catheter_mm']:.1f} mm"),
        ("seed", str(data["seed"])),
        ("compensation", str(data["compensation"])),
        ("date", str(data["date_utc"])),
        ("version", __version__),
    )
    return Sheet(
        title="Calibration of a machine",
        verdict="Calibrated" if calibrated.accepted else "Refused",
        good=calibrated.accepted,
        lead=f"{lead} In-silico: the machine is a simulated one.",
        run=tuple((name, value) for name, value in run if value),
        sections=tuple(sections),
    )


def _verdict(calibrated: Calibrated) -> Section:
    table = Table(
        "What must hold before a compensator may be driven by it",
        ("check", "here", "unit", "should be", "holds"),
        tuple(
            (entry.name, entry.value, entry.unit, calibration_check.bound(entry), entry.ok)
            for entry in calibrated.checks
        ),
    )
    return Section("Verdict", calibrated.reasons, (table,))


def _loop(calibrated: Calibrated, found: Identification) -> Section:
    first, second = calibrated.first, calibrated.second
    model, plays = calibration_run.predicted(found, second)
    time_s = DT_S * np.arange(second.head_mm.size, dtype=np.float64)
    fitted = Plot(
        "Second run: the loop, and what the models say of it",
        "Head (mm)",
        "Tip (mm)",
        (
            Curve("laser", second.laser_mm, "soft", x=second.head_mm),
            Curve("modified Dahl", model, "head", True, second.head_mm),
            Curve("plays", plays, "tip", False, second.head_mm),
        ),
    )
    left = Plot(
        "Second run: laser less model",
        "Time (s)",
        "mm",
        (
            Curve("modified Dahl", second.laser_mm - model, "head"),
            Curve("plays", second.laser_mm - plays, "tip"),
        ),
        time_s,
        "Nothing was fitted to this run. What the laser adds of noise is in both.",
    )
    samples = min(first.laser_mm.size, second.laser_mm.size)
    repeated = Plot(
        "Second run less first",
        "Time (s)",
        "mm",
        (Curve("tip", (second.laser_mm - first.laser_mm[:samples])[:samples], "soft"),),
        time_s[:samples],
        "The same motion twice: the noise of two readings, and what does not repeat.",
    )
    return Section("Two runs", plots=(fitted, left, repeated))


def _parameters(data: Json) -> Section:
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
