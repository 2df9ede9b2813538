"""Options of commands that read recordings and records, a person's own or those of a machine."""

from collections.abc import Sequence
from typing import Any

import typer

from opensuction.cli import completion


def join(names: Sequence[str]) -> str:
    """Names as a sentence lists them."""
    return f"{', '.join(names[:-1])} or {names[-1]}"


def take_name(words: str, names: Sequence[str], metavar: str = "NAME") -> Any:
    """An option that takes one of these names, completed by the shell."""
    return typer.Option(
        help=words,
        metavar=metavar,
        autocompletion=completion.complete_from(names),
        show_default=False,
    )


RECORDING_OPTIONS: dict[str, Any] = {
    "file": typer.Argument(
        metavar="FILE",
        help="The recording: CSV, JSON, .xlsx, Parquet, .npz or .mat; - is standard input.",
        show_default=False,
    ),
    "input": typer.Option(
        metavar="COL",
        help="Column of what drives: the head; leave it out to be told which columns FILE has. "
        "Given again: what drives too, such as another joint; play-readout follows several.",
        show_default=False,
    ),
    "output": typer.Option(
        metavar="COL", help="Column of what follows: the tip.", show_default=False
    ),
    "driven": typer.Option(
        "--input",
        metavar="COL",
        help="Column of the model's input; of several give it again, in the model's order. "
        "Default: the columns that it was fitted to.",
        show_default=False,
    ),
    "measured": typer.Option(
        "--output",
        metavar="COL",
        help="Column that the prediction is held against. Default: the one that the model was "
        "fitted to, where FILE has it; '' for none.",
        show_default=False,
    ),
    "parameter_file": typer.Option(
        "--model",
        metavar="FIT.toml",
        help="Parameter file that opensuction identify, compare or calibrate wrote.",
    ),
    "with_interval": typer.Option(
        "--with-interval",
        help="Beside each value the interval that holds 95 % of the measured ones.",
    ),
    "time": typer.Option(metavar="COL", help="Column of time. Default: samples evenly spaced."),
    "negate_output": typer.Option(
        "--negate-output", help="Turn the output's sign round, where it falls as the input rises."
    ),
    "model": take_name(
        "Model of the hysteresis: modified-dahl (the paper's), prandtl-ishlinskii, preisach or "
        "play-readout (of one or several inputs), which a cycle can be compensated with; dahl, "
        "bouc-wen, generalised, residual-readout or maxwell-slip, which drive no head. Default: "
        "modified-dahl.",
        completion.MODELS,
    ),
    "purpose": take_name(
        "What the recommended model is for: predict, compensate (only what a compensator takes) or "
        "transfer (to another speed or time). Default: predict.",
        completion.PURPOSES,
    ),
    "method": take_name(
        "Way to fit it: variable-projection, genetic-algorithm (the paper's), "
        "differential-evolution, non-negative, rising (a play readout that can drive) or "
        "regularised. Default: the model's own.",
        completion.METHODS,
    ),
    "holdout": typer.Option(
        metavar="R",
        help="Share of the recording, from its end, that is predicted instead of fitted, such as "
        "0.5: shows how the model does on what it has not seen.",
        show_default=False,
    ),
    "from_s": typer.Option(
        "--from", metavar="S", help="Leave out what lies before this time, in s."
    ),
    "to_s": typer.Option("--to", metavar="S", help="Leave out what lies after this time, in s."),
    "input_unit": typer.Option(metavar="UNIT", help="Unit of the input, if its name has none."),
    "output_unit": typer.Option(metavar="UNIT", help="Unit of the output, if its name has none."),
    "time_unit": typer.Option(
        metavar="UNIT", help="Unit of the time, if its name has none: ns to d. Default: s."
    ),
    "skip_missing": typer.Option(
        "--skip-missing",
        help="Leave out the rows in which a named column has no number, instead of refusing them.",
    ),
    "sheet": typer.Option(
        metavar="NAME", help="Sheet of the workbook. Default: the one that has rows of numbers."
    ),
    "data_folder": typer.Option(
        "--data",
        help="Folder in which the files of the data sets lie, or in a folder of it.",
        metavar="DIR",
        show_default=False,
    ),
    "contenders": typer.Option(
        "--model",
        help="Model that is held against others; may be given many times. Default: all of the "
        "catalogue, modified-bouc-wen, bouc-wen-oscillator and straight-line.",
        metavar="NAME|MODULE:CLASS",
        autocompletion=completion.complete_from(completion.CONTENDERS),
        show_default=False,
    ),
    "data_sets": typer.Option(
        "--data-set",
        help=f"Data set: {join(completion.DATA_SETS)}; may be given many times. Default: all of "
        "them.",
        metavar="NAME",
        autocompletion=completion.complete_from(completion.DATA_SETS),
        show_default=False,
    ),
    "recording": typer.Argument(
        metavar="FILE", help="A recording (.mcap) that opensuction wrote.", show_default=False
    ),
    "replayed": typer.Argument(
        metavar="FILE",
        help="Recordings (.mcap) that opensuction wrote: one, or several.",
        show_default=False,
    ),
    "unrecorded": typer.Option(
        "--no-recording",
        help="Write no recording.mcap: it has every tick, .22 MB a second of the run.",
    ),
    "trace": typer.Option(
        help="Write the time series, a row for each millisecond, as FILE.csv or FILE.parquet "
        "(needs pip install 'opensuction[parquet]'); of a day the last cycle's.",
        metavar="FILE",
        show_default=False,
    ),
    "format": typer.Option(
        help="csv, or parquet (needs pip install 'opensuction[parquet]'). Default: csv.",
        metavar="csv|parquet",
        autocompletion=completion.complete_from(completion.FORMATS),
        show_default=False,
    ),
    "columns": typer.Option(
        help="Columns that are wanted, such as inputs.readings.head_mm or 'outputs.*'; may be "
        "given many times. Default: all.",
        metavar="NAME",
        show_default=False,
    ),
    "database": typer.Option(
        help="Database of the records: a file, sqlite:///FILE or postgresql://USER@HOST/NAME. "
        "Default: OPENSUCTION_DATABASE, else records.db in the user's data folder.",
        metavar="FILE|URL",
        show_default=False,
    ),
    "act": typer.Argument(
        metavar="ACT",
        help="list, add, role, deactivate or reset-password. Default: list.",
        autocompletion=completion.complete_from(completion.ACTS_ON_USERS),
        show_default=False,
    ),
    "account": typer.Argument(metavar="NAME", help="Whose account.", show_default=False),
    "role": take_name(f"What the person is here for: {join(completion.ROLES)}.", completion.ROLES),
    "administrator": typer.Option(
        "--administrator", help="May manage accounts, too. With role: no more, without it."
    ),
    "reason": typer.Option(help="Why; it is put on record.", metavar="TEXT", show_default=False),
    "expect_head": typer.Option(
        help="Last hash of an earlier audit, which the trail must still hold.",
        metavar="HASH",
        show_default=False,
    ),
    "recordings": typer.Option(
        help="Folder where the recordings lie by now. Default: where each was written.",
        metavar="DIR",
        show_default=False,
    ),
    "trail_only": typer.Option("--trail-only", help="Read no recordings."),
}
"""By the name of the field that an option fills."""
