"""The ``opensuction`` command: every error one plain line, every result readable or JSON."""

import os
import sys
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from opensuction import __version__
from opensuction.kernel.errors import InputError

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 130

app = typer.Typer(
    name="opensuction",
    help="Automated tracheal suctioning: controller and digital twin. Research software, not a "
    "medical device, not for use on people or animals; every result is in-silico.",
    invoke_without_command=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

CYCLE_EXAMPLES = """\b
Examples:
  opensuction cycle                                  an adult on a ventilator
  opensuction cycle --protocol paediatric --patient child-10kg
  opensuction cycle --protocol paper                 the paper's cycle on its bench
  opensuction cycle --protocol paper --compensation none --seed 7
  opensuction cycle --approach contact               stop where the tip touches
  opensuction cycle --protocol my.toml --out run1    a protocol of your own
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
    machine: Annotated[
        str | None,
        typer.Option(
            help="Machine: bench or clinical. Default: clinical, but bench for the protocol paper.",
            show_default=False,
        ),
    ] = None,
    protocol: Annotated[
        str,
        typer.Option(
            help="Protocol: adult, paediatric, paper (bench only), or a TOML file.",
            metavar="NAME|FILE",
        ),
    ] = "adult",
    patient: Annotated[
        str,
        typer.Option(
            help="Patient at the clinical machine: adult-icu, adult-ards, child-10kg, neonate."
        ),
    ] = "adult-icu",
    approach: Annotated[
        str,
        typer.Option(
            help="How the stopping point is found: travel (a taught length) or contact (the "
            "switch at the tip closes on the carina)."
        ),
    ] = "travel",
    compensation: Annotated[
        str,
        typer.Option(
            help="Compensation of the backlash: none, direct-inverse (the paper's, as printed), "
            "exact-inverse, gap-width, lookup-table, prandtl-ishlinskii or preview."
        ),
    ] = "exact-inverse",
    seed: Annotated[
        int, typer.Option(help="Draws the machine and its measurement noise.", min=0, max=2**32 - 1)
    ] = 1,
    pace: Annotated[
        float | None,
        typer.Option(
            help="Simulated seconds shown in one second; 0 is as fast as it goes. Default: 10 on "
            "a terminal, else 0.",
            show_default=False,
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of this run. Default: runs/<time>-<seed>.", show_default=False),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Write into a folder that is not empty.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="One JSON object on stdout and nothing else.")
    ] = False,
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
        approach=approach,
        compensation=compensation,
        seed=seed,
        pace=pace,
        out=out,
        force=force,
        as_json=as_json,
    )
    try:
        code = command.run(options)
    except KeyboardInterrupt:
        _leave_interrupted()
    raise typer.Exit(code)


def _leave_interrupted() -> NoReturn:
    """Exit at once: a compilation in the background knows no interruption."""
    print("opensuction: interrupted; nothing was written", file=sys.stderr)  # noqa: T201
    sys.stderr.flush()
    os._exit(EXIT_INTERRUPTED)


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
        _leave_interrupted()
    except BrokenPipeError:
        # The reader went away (a pager, head): what is left has nowhere to go.
        sys.stderr.close()
        code = EXIT_FAILED
    sys.exit(code if isinstance(code, int) else 0)


if __name__ == "__main__":
    main()
