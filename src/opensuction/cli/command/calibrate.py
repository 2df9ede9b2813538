"""``calibrate``: two runs of the excitation, a verdict, a parameter file."""

import shlex
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli.delivery import CommandResult, OutputChoice, delivering, to_text
from opensuction.cli.entry import Command
from opensuction.result.plain import to_json
from opensuction.session.choice import CalibrationChoice, RigChoice

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.result.calibration_result import CalibrationResult, IdentifiedModels


class CalibrateOptions(NamedTuple):
    """Options of ``calibrate``."""

    choice: CalibrationChoice = CalibrationChoice()
    results: OutputChoice = OutputChoice()


def _compute(options: CalibrateOptions, progress: "ProgressTeller", folder: Path) -> CommandResult:
    from opensuction.report import sheet
    from opensuction.report.calibration import calibration_page
    from opensuction.report.calibration.calibration_page import Excitation
    from opensuction.session.calibration import calibration_file, calibration_run
    from opensuction.settings import identification_file
    from opensuction.simulation.closed_loop import DT_S

    found = calibration_run.run(options.choice, progress.tell)
    now = datetime.now(tz=UTC)
    found = calibration_file.confirmed(found, now)
    name = calibration_file.PARAMETER_FILE
    files = {calibration_file.RECORDING_FILE: calibration_file.recording_text(found.whole)}
    path = None
    if found.accepted:
        files[name] = identification_file.to_toml(calibration_file.parameter_file(found, now))
        path = str(folder / name)
    result = calibration_file.to_result(found, now, progress.elapsed_s, path)
    first, second = (
        Excitation(one.head_mm, one.laser_mm, DT_S) for one in (found.first, found.second)
    )
    page = calibration_page.page(result, first, second, found.predicted)
    files["report.html"] = sheet.render(page)
    data = to_json(result)
    files["calibrate.json"] = to_text(data)
    next_command = _next_command(options.choice.rig, path)
    return CommandResult(
        data,
        files,
        lambda console, folder: _summarise(console, result, folder, next_command),
        is_good=found.accepted,
        # A file of an earlier run would pass for the one that was refused.
        stale=() if found.accepted else (name,),
    )


def _next_command(rig: RigChoice, parameter_file: str | None) -> str:
    """The cycle that the parameter file is for."""
    words = ["opensuction", "cycle"]
    for name in ("machine", "patient", "catheter", "conduit"):
        given = getattr(rig, name)
        words += [] if given is None else [f"--{name}", str(given)]
    words += ["--seed", str(rig.seed)]
    words += [] if rig.spread == 1.0 else ["--spread", f"{rig.spread:g}"]
    return shlex.join((*words, "--compensation", str(parameter_file)))


def _summarise(
    console: "Console", found: "CalibrationResult", folder: Path, next_command: str
) -> None:
    from rich.text import Text

    accepted = found.accepted
    console.print(
        Text("Calibrated" if accepted else "Refused", "bold green" if accepted else "bold red"),
        Text(f"(machine {found.machine}, seed {found.seed})", "dim"),
    )
    for reason in found.reasons:
        console.print(Text(f"  {reason}"), soft_wrap=True)
    if found.identified is not None:
        for line in (*_sentences(found.identified), *_choice_sentence(found)):
            console.print(Text(f"  {line}"), soft_wrap=True)
    console.print(f"Report: {folder / 'report.html'}", soft_wrap=True)
    if accepted:
        console.print(f"Parameter file: {found.parameter_file}", soft_wrap=True)
        console.print(f"Use it: {next_command}", soft_wrap=True)
    else:
        console.print("No parameter file was written.")
    console.print("In-silico: the machine is a simulated one.")


def _sentences(models: "IdentifiedModels") -> list[str]:
    found, servo = models.validation, models.servo
    return [
        f"The tip comes {models.gap_mm:.1f} mm later than the head at a reversal, "
        f"{100.0 * models.gap_ratio:.0f} % of what this machine was built with.",
        "On a second run, which nothing was fitted to, the plays miss the tip by "
        f"{found.plays_rmse_mm:.3f} mm RMS ({found.plays_percent_of_range:.2f} % of its "
        f"range), the modified Dahl model by {found.model_rmse_mm:.3f} mm "
        f"({found.model_percent_of_range:.2f} %).",
        f"The same motion twice differs by {found.repeatability_mm:.3f} mm RMS.",
        f"The motor takes {servo.velocity_v_s_per_mm:.3f} V for each mm/s and "
        f"{servo.friction_v:.2f} V against friction; {found.servo_rmse_v:.3f} V RMS are left "
        "unexplained.",
    ]


def _choice_sentence(found: "CalibrationResult") -> list[str]:
    """Compensator that the file names, with the reason where it was chosen."""
    choice = found.choice
    return [] if choice is None else [f"Compensation: {found.compensation}. {choice.reason}"]


COMMAND = Command(
    name="calibrate",
    options=CalibrateOptions,
    run=delivering("calibrate", "Calibrating", _compute),
    sentence="Calibrate a machine: excite it over its stroke, fit, confirm, write the parameter "
    "file.",
    details="Finds hysteresis and the servo's feedforward from one run of the excitation and holds "
    "them against a second; a poor fit is refused, with the reason. 'opensuction cycle "
    "--compensation' takes the file. Nobody is on the machine: the patient says where it parks and "
    "with which catheter. The compensation is the one that the file is to name: best, the default, "
    "goes on with four shorter strokes, holds every model that drives against the others on "
    "strokes left out, and takes the one that does best; it cannot be none.",
    examples="""\b
Examples:
  opensuction calibrate --machine bench --seed 3 --out bench3
  opensuction cycle --machine bench --seed 3 \\
      --compensation bench3/calibration.toml
  opensuction calibrate --patient child-10kg  as set up for a child
  opensuction calibrate --compensation exact-inverse --json | jq .validation

Written: calibration.toml (not for a poor fit; with --force one of an earlier run is removed then),
recording.csv, report.html, calibrate.json.""",
    ends="0 calibrated, 1 refused for a poor fit",
)
