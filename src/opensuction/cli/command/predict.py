"""``predict``: a recording and a fitted model in, the model's output out."""

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli.delivery import CommandResult, OutputChoice, delivering, to_text
from opensuction.cli.entry import Command
from opensuction.result.plain import to_json
from opensuction.session.choice import PredictionChoice

if TYPE_CHECKING:
    from opensuction.cli.progress import ProgressTeller

TABLE, RESULT = "prediction.csv", "prediction.json"


class PredictOptions(NamedTuple):
    """Options of ``predict``."""

    prediction: PredictionChoice
    results: OutputChoice = OutputChoice()


def _predict(options: PredictOptions, progress: "ProgressTeller", folder: Path) -> CommandResult:
    from opensuction.report.identification import identification_words
    from opensuction.session.identification import prediction_run

    found = prediction_run.predict(options.prediction)
    if found.table.note:
        progress.tell(f"{found.choice.file}: {found.table.note}")
    if found.skipped_rows:
        progress.tell(
            f"{found.choice.file}: rows left out, for a number is missing: {found.skipped_rows}"
        )
    result = prediction_run.summarise(found, datetime.now(tz=UTC), folder / TABLE)
    data = to_json(result)
    files = {TABLE: prediction_run.to_table(found), RESULT: to_text(data)}
    return CommandResult(
        data,
        files,
        lambda console, folder: identification_words.print_prediction(
            console, result, [folder / name for name in files]
        ),
    )


COMMAND = Command(
    name="predict",
    options=PredictOptions,
    run=delivering("predict", "Predicting", _predict),
    sentence="Predict the output of a recording by a fitted model.",
    details="Writes prediction.csv (a row for each sample: inputs, the measured output where there "
    "is one, and the predicted one) and prediction.json. Where the recording has the output, the "
    "error is told.",
    examples="""\b
Examples:
  opensuction identify bench.csv --input head_mm --output tip_mm --out bench
  opensuction predict next.csv --model bench/identification.toml
  opensuction predict next.csv --model bench/identification.toml \\
      --time time_s --with-interval --out next
  opensuction predict other.csv --model bench/identification.toml \\
      --input motor_mm --output laser_mm --json | jq .error.rmse

Before the first sample the model has the past that the fitted recording began after. The interval
goes by the scatter of the fitted samples: recordings of another kind, and inputs beyond the fitted
range (which is told), may scatter more. Recordings and units are as in opensuction identify
--help.""",
    ends="0 predicted",
)
