"""The ``opensuction`` command: every error one plain line, every result readable or JSON."""

import sys
import textwrap
from typing import Annotated

import typer

from opensuction import __version__
from opensuction.cli import interruption, option, study, workbench
from opensuction.kernel.errors import InputError
from opensuction.twin.fault_table import KINDS

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2

app = typer.Typer(
    name="opensuction",
    help="Automated tracheal suctioning: controller and digital twin. Research software, not a "
    "medical device, not for use on people or animals; every performance claim is in-silico.",
    invoke_without_command=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

FAULTS = textwrap.fill(
    ", ".join(fault.title for fault in KINDS),
    width=80,
    initial_indent="  ",
    subsequent_indent="  ",
    break_on_hyphens=False,
)
CYCLE_EXAMPLES = f"""\b
Examples:
  opensuction cycle                                  an adult on a ventilator
  opensuction cycle --protocol paediatric --patient child-10kg
  opensuction cycle --protocol paper                 the paper's cycle on its bench
  opensuction cycle --protocol paper --compensation none --seed 7
  opensuction cycle --approach contact               stop where the tip touches
  opensuction cycle --protocol my.toml --out run1    a protocol of your own
  opensuction cycle --machine my-machine.toml --patient my-patient.toml
  opensuction cycle --protocol paper --compensation bench/identification.toml
  opensuction cycle --repeat 6 --every 240           a day: a cycle every four hours
  opensuction cycle --fault valve-jammed@suctioning+2
  opensuction cycle --fault line-leak=0.5 --fault power-lost@12
  opensuction cycle --approach contact --repeat 6 --every 60 --self-calibrate --gap-scale 1.2
                                                     the gap changed, and is found by contact
  opensuction cycle --json | jq .tip                 figures for a script

\b
A protocol file holds the keys of the preset, for example:
  travel_mm = 85.0
  cap_mm = 90.0
  contact_from_mm = 30.0
  backoff_mm = 0.0
  insertion_mm_per_s = 9.0
  withdrawal_mm_per_s = 9.0
  dwell_s = 9.0
  vacuum_mmhg = 100.0
  negative_pressure_budget_s = 24.0
  in_airway_budget_s = 35.0
  bench_only = true

\b
A machine file says what it starts from and what it changes:
  preset = "clinical"
  catheter = "12fr"
  conduit = "looped"
  [twin]                          # what the machine does
  pump_free_l_per_min = 15.0
  [controller]                    # what its controller goes by
  cam_rad_per_s = 0.8

\b
A patient file likewise; a value with a spread is drawn by the seed:
  preset = "adult-icu"
  weight_kg = 82.0
  carina_mm = {{ value = 60.0, spread = 4.0 }}

\b
docs/reference/parameters.md lists every parameter with unit, range and source.

\b
A fault comes S seconds after the start (@S), S seconds into a phase (@PHASE+S:
checking, preloading, inserting, backing_off, opening, suctioning, withdrawing,
closing, aborting, halted), or is there from the start. Its strength has a unit of
its own. docs/reference/faults.md says what each does:
{FAULTS}

\b
Exit status: 0 completed, 1 aborted, 2 bad input, 130 interrupted."""


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"opensuction {__version__}")
        raise typer.Exit


@app.callback()
def main_options(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Options of every command."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


@app.command(epilog=CYCLE_EXAMPLES)
def cycle(
    machine: option.Machine = None,
    protocol: option.Protocol = "adult",
    patient: option.Patient = None,
    catheter: option.Catheter = None,
    conduit: option.Conduit = None,
    approach: option.Approach = "travel",
    compensation: option.Compensation = "preview",
    taught: option.TaughtLength = None,
    fault: option.Faults = None,
    repeat: option.Repeat = 1,
    every: option.Every = None,
    self_calibrate: option.SelfCalibrate = False,
    gap_scale: option.GapScale = 1.0,
    seed: option.Seed = 1,
    pace: option.Pace = None,
    out: option.Out = None,
    force: option.Force = False,
    as_json: option.AsJson = False,
) -> None:
    """One automated suction cycle on the digital twin: live phases, summary, report.

    Identifies the drawn machine where the compensation needs it, runs the cycle under the real
    controller, and writes report.html (open it in a browser) and cycle.json.
    """
    from opensuction.cli import cycle as command

    options = command.Options(
        machine=machine,
        protocol=protocol,
        patient=patient,
        catheter=catheter,
        conduit=conduit,
        approach=approach,
        compensation=compensation,
        taught_mm=taught,
        faults=tuple(fault or ()),
        repeat=repeat,
        every_min=every,
        self_calibrates=self_calibrate,
        gap_scale=gap_scale,
        seed=seed,
        pace=pace,
        out=out,
        force=force,
        as_json=as_json,
    )
    interruption.carry_out(lambda: command.run(options))


study.register(app)
workbench.register(app)


def _refuse(message: str) -> int:
    print(f"opensuction: {' '.join(message.split())}", file=sys.stderr)  # noqa: T201
    return EXIT_BAD_INPUT


def main() -> None:
    """Entry point of the console script; never ends in a traceback for what a person did."""
    try:
        code = app(prog_name="opensuction", standalone_mode=False)
    except typer.Exit as leaving:
        code = leaving.exit_code
    except InputError as refused:
        code = _refuse(str(refused))
    except typer.TyperException as misused:
        code = _refuse(misused.format_message())
    except KeyboardInterrupt:
        interruption.leave()
    except BrokenPipeError:
        # The reader went away (a pager, head): what is left has nowhere to go.
        sys.stderr.close()
        code = EXIT_FAILED
    sys.exit(code if isinstance(code, int) else 0)


if __name__ == "__main__":
    main()
