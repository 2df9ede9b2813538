"""The ``calibrate`` command: two runs of the excitation, a verdict, a parameter file."""

import json
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Console
from rich.text import Text

from opensuction.cli import output_folder
from opensuction.cli.cycle import interruptible

Json = dict[str, Any]


class Options(NamedTuple):
    """Options of the command as a person gave them."""

    machine: str
    patient: str | None
    catheter: str | None
    conduit: str | None
    compensation: str
    seed: int
    out: Path | None
    force: bool
    as_json: bool


def run(options: Options) -> int:
    """Carry the command out; returns the exit status. Raises InputError for bad input."""
    began_s = time.monotonic()
    console = Console(stderr=options.as_json, highlight=False)
    folder = output_folder.chosen(options.out, "calibrate")
    with output_folder.whole(folder, options.force) as staging:
        data = _calibrate_and_write(options, staging, folder, began_s)
    if not data["accepted"]:
        # A file of an earlier run would pass for the one that was refused.
        (folder / "calibration.toml").unlink(missing_ok=True)
    if options.as_json:
        print(json.dumps(data))  # noqa: T201 - the one object of --json
    else:
        _summarise(console, data, folder, _next_command(options, data))
    return 0 if data["accepted"] else 1


def _calibrate_and_write(options: Options, staging: Path, folder: Path, began_s: float) -> Json:
    # Heavy imports.
    from opensuction.kernel import compiled
    from opensuction.report import sheet
    from opensuction.session.calibration import calibration_file, calibration_page, calibration_run
    from opensuction.session.cycle.cycle_choice import Choice
    from opensuction.settings import identification_file

    choice = Choice(
        machine=options.machine,
        protocol="adult",  # a run of its own: no protocol is carried out
        approach="travel",
        compensation=options.compensation,
        seed=options.seed,
        patient=options.patient,
        catheter=options.catheter,
        conduit=options.conduit,
    )
    calibration_run.check(choice)
    # Progress goes to stderr: a refusal may still come, and then nothing is on stdout.
    progress = Console(stderr=True, highlight=False)

    def tell(line: str) -> None:
        progress.print(line, soft_wrap=True)

    if compiled.is_cold():
        tell("Compiling the control core: once for this version, about a minute")
    now = datetime.now(tz=UTC)
    found = interruptible(lambda: calibration_run.run(choice, tell))
    found = calibration_file.confirmed(found, now)
    text = calibration_file.recording_text(found.first)
    (staging / calibration_file.RECORDING_FILE).write_text(text, encoding="utf-8", newline="")
    path = None
    if found.accepted:
        name = calibration_file.PARAMETER_FILE
        content = identification_file.to_toml(calibration_file.parameter_file(found, now))
        (staging / name).write_text(content, encoding="utf-8")
        path = str(folder / name)
    data = calibration_file.plain(found, now, time.monotonic() - began_s, path)
    html = sheet.render(calibration_page.page(found, data))
    (staging / "report.html").write_text(html, encoding="utf-8")
    (staging / "calibrate.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    return data


def _next_command(options: Options, data: Json) -> str:
    """The cycle that the parameter file is for."""
    words = ["opensuction cycle"]
    if data["patient"] is None:
        words.append("--protocol paper")
    for name in ("machine", "patient", "catheter", "conduit"):
        given = getattr(options, name)
        words += [] if given is None else [f"--{name} {given}"]
    return " ".join((*words, f"--seed {options.seed} --compensation {data['parameter_file']}"))


def _summarise(console: Console, data: Json, folder: Path, next_command: str) -> None:
    accepted = data["accepted"]
    console.print(
        Text("Calibrated" if accepted else "Refused", "bold green" if accepted else "bold red"),
        Text(f"(machine {data['machine']}, seed {data['seed']})", "dim"),
    )
    for reason in data["reasons"]:
        console.print(Text(f"  {reason}"), soft_wrap=True)
    if data["validation"] is not None:
        for line in _sentences(data):
            console.print(Text(f"  {line}"), soft_wrap=True)
    console.print(f"Report: {folder / 'report.html'}", soft_wrap=True)
    if accepted:
        console.print(f"Parameter file: {data['parameter_file']}", soft_wrap=True)
        console.print(f"Use it: {next_command}", soft_wrap=True, markup=False)
    else:
        console.print("No parameter file was written.")
    console.print("In-silico: the machine is a simulated one.")


def _sentences(data: Json) -> list[str]:
    found, servo = data["validation"], data["servo"]
    return [
        f"The tip comes {data['gap_mm']:.1f} mm later than the head at a reversal, "
        f"{100.0 * data['gap_ratio']:.0f} % of what this machine was built with.",
        "On a second run, which nothing was fitted to, the plays miss the tip by "
        f"{found['plays_rmse_mm']:.3f} mm RMS ({found['plays_percent_of_range']:.2f} % of its "
        f"range), the modified Dahl model by {found['model_rmse_mm']:.3f} mm "
        f"({found['model_percent_of_range']:.2f} %).",
        f"The same motion twice differs by {found['repeatability_mm']:.3f} mm RMS.",
        f"The motor takes {servo['velocity_v_s_per_mm']:.3f} V for each mm/s and "
        f"{servo['friction_v']:.2f} V against friction; {found['servo_rmse_v']:.3f} V RMS are left "
        "unexplained.",
    ]
