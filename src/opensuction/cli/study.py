"""Options of the commands that show or find something by runs of their own on the twin."""

from pathlib import Path
from typing import Annotated

import typer

from opensuction.cli import interruption, option

REPRODUCE_EXAMPLES = """\b
Examples:
  opensuction reproduce                              report.html and reproduce.json under runs/
  opensuction reproduce --out paper                  in a folder of your own
  opensuction reproduce --json | jq .table1          Table I, the paper's numbers and ours

\b
Exit status: 0 every claim holds or is explained, 1 one differs, 2 bad input, 130 interrupted."""


def reproduce(
    out: option.StudyOut = None,
    force: option.Force = False,
    as_json: option.AsJson = False,
) -> None:
    """The paper's figures 5 to 11 and tables I and II on the twin, each number beside its own.

    Every claim has a tolerance and a verdict, and says whether the twin was calibrated to it or
    predicts it.
    """
    from opensuction.cli import reproduce as command

    interruption.carry_out(
        lambda: command.run(command.Options(out=out, force=force, as_json=as_json))
    )


CALIBRATE_EXAMPLES = """\b
Examples:
  opensuction calibrate --machine bench --seed 3 --out bench3
  opensuction cycle --protocol paper --seed 3 --compensation bench3/calibration.toml
  opensuction calibrate --patient child-10kg         as set up for a child: tube and catheter
  opensuction calibrate --compensation exact-inverse --json | jq .validation

\b
Written: calibration.toml (not for a poor fit; with --force one of an earlier run is removed then),
recording.csv, report.html, calibrate.json.

\b
Exit status: 0 calibrated, 1 refused for a poor fit, 2 bad input, 130 interrupted."""


def calibrate(
    machine: Annotated[
        str,
        typer.Option(help="Machine: bench, clinical, or a TOML file.", metavar="NAME|FILE"),
    ] = "clinical",
    patient: Annotated[
        str | None,
        typer.Option(
            help="Whom a clinical machine is set up for, which says where it parks and with which "
            "catheter; nobody is on it. Default: adult-icu.",
            metavar="NAME|FILE",
            show_default=False,
        ),
    ] = None,
    catheter: option.Catheter = None,
    conduit: option.Conduit = None,
    compensation: Annotated[
        str,
        typer.Option(
            help="Compensation that the parameter file names: preview, prandtl-ishlinskii, "
            "exact-inverse, direct-inverse, lookup-table or gap-width."
        ),
    ] = "preview",
    seed: option.Seed = 1,
    out: option.StudyOut = None,
    force: option.Force = False,
    as_json: option.AsJson = False,
) -> None:
    """Calibrate a machine: excite it over its stroke, fit, confirm, write the parameter file.

    Finds hysteresis and the servo's feedforward from one run of the excitation and holds them
    against a second; a poor fit is refused, with the reason. 'opensuction cycle --compensation'
    takes the file.
    """
    from opensuction.cli import calibrate as command

    options = command.Options(
        machine=machine,
        patient=patient,
        catheter=catheter,
        conduit=conduit,
        compensation=compensation,
        seed=seed,
        out=out,
        force=force,
        as_json=as_json,
    )
    interruption.carry_out(lambda: command.run(options))


BENCHMARK_EXAMPLES = """\b
Examples:
  opensuction benchmark                              report.html and benchmark.json under runs/
  opensuction benchmark --seeds 1                    a quick look
  opensuction benchmark --json | jq '.results[] | select(.plant == "bench")'

\b
Exit status: 0 done, 2 bad input, 130 interrupted."""


def benchmark(
    seeds: option.Seeds = 5,
    out: option.StudyOut = None,
    force: option.Force = False,
    as_json: option.AsJson = False,
) -> None:
    """Every compensator on every plant with fixed seeds: error, peak and head speed of each pair.

    Plants are the twins (bench, bedside, conduits laid otherwise) and the hysteresis models; each
    is identified by the same excitation before it is compensated.
    """
    from opensuction.cli import benchmark as command

    options = command.Options(seeds=seeds, out=out, force=force, as_json=as_json)
    interruption.carry_out(lambda: command.run(options))


SAFETY_CASE_EXAMPLES = """\b
Examples:
  opensuction safety-case                            report.html and safety-case.json under runs/
  opensuction safety-case --seeds 5                  five machines and patients for each run
  opensuction safety-case --table mine.toml          hazards of your own
  opensuction safety-case --json | jq '.hazards[] | select(.ok | not) | .problems'
  opensuction cycle --fault pump-runaway@suctioning  one of its faults, seen in a whole cycle

\b
A row of a hazard table (docs/how-to/safety-case.md says what the keys mean):
  [[hazard]]
  id = "OS-H17"
  hazard = "Vacuum above the patient's limit"
  cause = "Pump runs away"
  effect = "Mucosal haemorrhage"
  severity = "serious"                 # negligible, minor, serious, critical
  detection = "Line vacuum above its limit"
  control = "Valve closed, pump off; out"
  alarm = ["VACUUM_EXCEEDED"]          # any of these; priority is the first one's
  priority = "high"
  safe_state = "out-without-suction"
  detected_ms = 2000
  safe_ms = 10000
  because = "The line takes 2 s to climb that far; 8 s to come out."
  requirements = ["OS-R07"]
  [[hazard.fault]]                     # any key above may be here too, for this fault alone
  name = "pump-runaway"
  phases = ["opening", "suctioning"]   # or all

\b
Exit status: 0 every bound holds, 1 one is broken, 2 bad input, 130 interrupted."""


def safety_case(
    table: Annotated[
        Path | None,
        typer.Option(
            help="Hazard table (TOML). Default: the project's own.",
            metavar="FILE",
            show_default=False,
        ),
    ] = None,
    seeds: Annotated[
        int,
        typer.Option(
            help="How many machines and patients are drawn for each run, seeds 1 on.",
            min=1,
            max=100,
            metavar="N",
        ),
    ] = 1,
    out: option.StudyOut = None,
    force: option.Force = False,
    as_json: option.AsJson = False,
) -> None:
    """Every hazard on the twin: its faults injected, alarm and safe state timed against bounds.

    A hazard whose bound is broken is shown as broken. The report has a strip chart of each
    hazard's worst run. Two processes share the work.
    """
    from opensuction.cli import safety_case as command

    options = command.Options(table=table, seeds=seeds, out=out, force=force, as_json=as_json)
    interruption.carry_out(lambda: command.run(options))


def register(app: typer.Typer) -> None:
    """Add these commands to the ``opensuction`` command."""
    app.command(epilog=REPRODUCE_EXAMPLES)(reproduce)
    app.command(epilog=CALIBRATE_EXAMPLES)(calibrate)
    app.command(epilog=BENCHMARK_EXAMPLES)(benchmark)
    app.command(name="safety-case", epilog=SAFETY_CASE_EXAMPLES)(safety_case)
