"""Options of ``identify`` and ``compare``, the two commands for recordings of one's own."""

from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from opensuction.cli import interruption

IDENTIFY_EXAMPLES = """\b
Examples:
  opensuction identify bench.csv --input head_mm --output tip_mm
  opensuction identify bench.csv --input head_mm --output tip_mm --time time_s \\
      --holdout 0.5 --out bench
  opensuction cycle --protocol paper --compensation bench/identification.toml
  opensuction identify jaw.csv --input spindle_deg --output jaw_deg --negate-output \\
      --time t_s --from 0.5
  opensuction identify run.parquet --input head_mm --output tip_mm --json | jq .parameters

\b
A recording is a table with a header line: CSV with commas, semicolons or tabs, decimal commas
allowed, or Parquet (pip install 'opensuction[parquet]'). Units are read from the columns' names
(head_mm, "Head (mm)"), or given by --input-unit and --output-unit.

\b
Exit status: 0 identified, 2 bad input, 130 interrupted."""

COMPARE_EXAMPLES = """\b
Examples:
  opensuction compare bench.csv --input head_mm --output tip_mm
  opensuction compare bench.csv --input head_mm --output tip_mm --time time_s --holdout 0.3
  opensuction compare jaw.csv --input spindle_deg --output jaw_deg --negate-output --json \\
      | jq '.models[] | [.model, .rmse_percent_of_range]'

\b
The recommended model is the one that cross-validation prefers. Recordings and units are as in
opensuction identify --help.

\b
Exit status: 0 compared, 2 bad input, 130 interrupted."""

DEFAULT_MODEL = "modified-dahl"
"""The paper's model, which the compensators use."""

File = Annotated[
    Path,
    typer.Argument(metavar="FILE", help="The recording: CSV or Parquet.", show_default=False),
]
Input = Annotated[
    str,
    typer.Option(
        "--input", metavar="COL", help="Column of what drives: the head.", show_default=False
    ),
]
Output = Annotated[
    str,
    typer.Option(
        "--output", metavar="COL", help="Column of what follows: the tip.", show_default=False
    ),
]
Time = Annotated[
    str | None,
    typer.Option("--time", metavar="COL", help="Column of time. Default: samples evenly spaced."),
]
NegateOutput = Annotated[
    bool,
    typer.Option(
        "--negate-output", help="Turn the output's sign round, where it falls as the input rises."
    ),
]
InputUnit = Annotated[
    str | None, typer.Option(metavar="UNIT", help="Unit of the input, if its name has none.")
]
OutputUnit = Annotated[
    str | None, typer.Option(metavar="UNIT", help="Unit of the output, if its name has none.")
]
Holdout = Annotated[
    float,
    typer.Option(
        metavar="R",
        help="Share of the recording, from its end, that is predicted instead of fitted, such as "
        "0.5: shows how the model does on what it has not seen.",
    ),
]
From = Annotated[
    float | None,
    typer.Option("--from", metavar="S", help="Leave out what lies before this time, in s."),
]
To = Annotated[
    float | None,
    typer.Option("--to", metavar="S", help="Leave out what lies after this time, in s."),
]
Force = Annotated[bool, typer.Option("--force", help="Write into a folder that is not empty.")]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object on stdout and nothing else.")]


def identify(
    file: File,
    input_: Input,
    output: Output,
    time: Time = None,
    negate_output: NegateOutput = False,
    model: Annotated[
        str,
        typer.Option(
            help="Model of the hysteresis: modified-dahl (the paper's; the only one that a cycle "
            "can be compensated with), dahl, bouc-wen, prandtl-ishlinskii, preisach, generalised."
        ),
    ] = DEFAULT_MODEL,
    method: Annotated[
        str | None,
        typer.Option(
            help="Way to fit it: variable-projection, genetic-algorithm (the paper's), "
            "differential-evolution, non-negative, regularised. Default: the model's own."
        ),
    ] = None,
    holdout: Holdout = 0.0,
    from_: From = None,
    to: To = None,
    input_unit: InputUnit = None,
    output_unit: OutputUnit = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the results. Default: runs/<time>-identify."),
    ] = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Fit a model of hysteresis to a recording of your own.

    Fits the output to the input, with 95 % intervals, and writes identification.toml (parameters,
    which 'opensuction cycle --compensation' takes), report.html (loop, time and residual plots)
    and identification.json.
    """
    _carry_out(
        file=file,
        input=input_,
        output=output,
        time=time,
        negate_output=negate_output,
        input_unit=input_unit,
        output_unit=output_unit,
        model=model,
        method=method,
        holdout=holdout,
        from_s=from_,
        to_s=to,
        out=out,
        force=force,
        as_json=as_json,
    )


def compare(
    file: File,
    input_: Input,
    output: Output,
    time: Time = None,
    negate_output: NegateOutput = False,
    holdout: Holdout = 0.0,
    from_: From = None,
    to: To = None,
    input_unit: InputUnit = None,
    output_unit: OutputUnit = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the results. Default: runs/<time>-compare."),
    ] = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Fit every model to a recording, recommend one.

    Writes report.html (ranking, and all models in the same plots), comparison.json and a
    parameter file for each model.
    """
    _carry_out(
        file=file,
        input=input_,
        output=output,
        time=time,
        negate_output=negate_output,
        input_unit=input_unit,
        output_unit=output_unit,
        model=None,
        method=None,
        holdout=holdout,
        from_s=from_,
        to_s=to,
        out=out,
        force=force,
        as_json=as_json,
    )


def _carry_out(**options: Any) -> NoReturn:
    """Run the command with its options and leave with its exit status."""
    from opensuction.cli import identification as command

    interruption.carry_out(lambda: command.run(command.Options(**options)))


def register(app: typer.Typer) -> None:
    """Add both commands to an application."""
    app.command(epilog=IDENTIFY_EXAMPLES)(identify)
    app.command(epilog=COMPARE_EXAMPLES)(compare)
