"""``identify`` and ``compare``: a recording in, parameters and a report out."""

import time
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli.delivery import CommandResult, OutputChoice, delivering, to_text
from opensuction.cli.entry import Command
from opensuction.result.plain import to_json
from opensuction.session.choice import RecordingChoice

if TYPE_CHECKING:
    from opensuction.cli.progress import ProgressTeller
    from opensuction.identification.workbench import FittedModel
    from opensuction.result.identification_result import WorkbenchResult
    from opensuction.session.identification.identification_run import LoadedRecording


class IdentifyOptions(NamedTuple):
    """Options of ``identify``."""

    recording: RecordingChoice
    model: str = "modified-dahl"
    """The paper's model, which the compensators use."""
    method: str | None = None
    results: OutputChoice = OutputChoice()


class CompareOptions(NamedTuple):
    """Options of ``compare``."""

    recording: RecordingChoice
    purpose: str = "predict"
    results: OutputChoice = OutputChoice()


def _compute(
    options: IdentifyOptions | CompareOptions, progress: "ProgressTeller", folder: Path
) -> CommandResult:
    """Fit one model, or every one to compare them."""
    from opensuction.recording import table
    from opensuction.session.identification import identification_run

    recording, model, method, purpose = options.recording, None, None, "predict"
    if isinstance(options, IdentifyOptions):
        model, method = options.model, options.method
    else:
        purpose = options.purpose
        identification_run.check_purpose(purpose)

    def tell(model: str, done: int, models: int) -> None:
        progress.tell(f"Identifying {model} ({done + 1} of {models})")

    source = table.NAME if recording.file == table.DASH else recording.file
    if recording.input and recording.output:
        sign = "-" if recording.negate_output else ""
        progress.tell(
            f"Identifying {model or 'every model'} on {source}: "
            f"{', '.join(recording.input)} to {sign}{recording.output}"
        )
    loaded = identification_run.load(recording, model, method)
    if loaded.table.note:
        progress.tell(f"{source}: {loaded.table.note}")
    if loaded.skipped_rows:
        progress.tell(f"{source}: rows left out, for a number is missing: {loaded.skipped_rows}")
    began_s = time.perf_counter()
    found = identification_run.fit(loaded, tell, purpose)
    return _write_up(loaded, found, folder, time.perf_counter() - began_s)


def _write_up(
    loaded: "LoadedRecording", results: "list[FittedModel]", folder: Path, seconds: float
) -> CommandResult:
    from opensuction.report.identification import identification_page, identification_words
    from opensuction.session.identification import identification_summary
    from opensuction.settings import identification_file

    now = datetime.now(tz=UTC)
    compared = loaded.model is None
    names = {
        result.model: f"{result.model}.toml" if compared else "identification.toml"
        for result in results
    }
    paths = {model: str(folder / name) for model, name in names.items()}
    found: WorkbenchResult = (
        identification_summary.summarise_comparison(loaded, results, now, seconds, paths)
        if compared
        else identification_summary.summarise_fit(loaded, results[0], now, seconds, paths)
    )
    parameters = {
        names[result.model]: identification_file.to_toml(
            identification_summary.make_parameter_file(loaded, result, now)
        )
        for result in results
    }
    data = to_json(found)
    pair = loaded.pair
    curves = identification_page.FittedCurves(
        time_s=pair.time_s,
        driven=pair.driven,
        answer=pair.answer,
        fitted={result.model: result.fitted for result in results},
        autocorrelation={result.model: result.autocorrelation for result in results},
        fitted_samples=results[0].fitted_samples,
    )
    files = {
        "report.html": identification_page.render(found, curves),
        "comparison.json" if compared else "identification.json": to_text(data),
        **parameters,
    }
    return CommandResult(
        data,
        files,
        lambda console, folder: identification_words.print_summary(
            console, found, [folder / name for name in files]
        ),
    )


IDENTIFY = Command(
    name="identify",
    options=IdentifyOptions,
    run=delivering("identify", "Identifying", _compute),
    sentence="Fit a model of hysteresis to a recording of your own.",
    details="Fits the output to the input, with 95 % intervals, and writes identification.toml "
    "(parameters, which 'opensuction cycle --compensation' takes), report.html (loop, time and "
    "residual plots) and identification.json.",
    examples="""\b
Examples:
  opensuction identify bench.csv --input head_mm --output tip_mm
  opensuction identify bench.csv --input head_mm --output tip_mm \\
      --time time_s --holdout 0.5 --out bench
  opensuction cycle --machine bench --compensation bench/identification.toml
  opensuction identify jaw.csv --input spindle_deg --output jaw_deg \\
      --negate-output --time t_s --from 0.5
  opensuction identify run.parquet --input head_mm --output tip_mm --json \\
      | jq .parameters
  unzip -p bench.zip bench.csv \\
      | opensuction identify - --input head_mm --output tip_mm

Without --input and --output the columns of the file are listed. A recording is a table with a
header line: CSV with commas, semicolons, tabs or blanks between, decimal commas allowed; records or
columns of JSON; an Excel sheet (.xlsx, pip install 'opensuction[excel]'); Parquet (pip install
'opensuction[parquet]'); named arrays of NumPy (.npz) or MATLAB (.mat; of version 7.3: pip install
'opensuction[matlab]'). Without a header columns are called by their number: --input 1.
Units are read from the columns' names (head_mm, "Head (mm)") or from a row below the header, or
given by --input-unit and --output-unit.

In the JSON, seconds is the whole command once the recording is read, by the clock; fit_seconds is
the processor time of the fit alone with its choice of complexity, done again in the same process:
the shortest of up to 20 equal ones, of one where it takes longer than 0.1 s.""",
    ends="0 identified",
)
COMPARE = Command(
    name="compare",
    options=CompareOptions,
    run=delivering("compare", "Identifying", _compute),
    sentence="Fit every model to a recording, recommend one.",
    details="Writes report.html (ranking, and all models in the same plots), comparison.json and a "
    "parameter file for each model.",
    examples="""\b
Examples:
  opensuction compare bench.csv --input head_mm --output tip_mm
  opensuction compare bench.csv --input head_mm --output tip_mm \\
      --time time_s --holdout 0.3
  opensuction compare jaw.csv --input spindle_deg --output jaw_deg \\
      --negate-output --json | jq .models[0].model
  opensuction compare bench.csv --input head_mm --output tip_mm \\
      --purpose compensate

The recommended model is the simplest that is not surely worse than the best, for its purpose, on
strokes that were left out in turn; never one worse than modified-dahl. Recordings and units are as
in opensuction identify --help.""",
    ends="0 compared",
)
