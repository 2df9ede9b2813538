"""Prediction of a recording's output by a model that was identified before.

The 95 % interval goes by the scatter of the fitted samples alone: it holds for recordings like the
fitted one, and says nothing of inputs beyond its range.
"""

import csv
import io
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction import __version__
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.recording import array_column, table
from opensuction.recording.array_column import Pair
from opensuction.recording.column_unit import seconds_of_column
from opensuction.recording.table import RecordedTable
from opensuction.result.identification_result import PredictionError, PredictionResult
from opensuction.session.choice import PredictionChoice
from opensuction.session.identification.identification_run import (
    check_span,
    choose_unit,
    list_columns,
)
from opensuction.settings import identification_file
from opensuction.settings.identification_file import Identified
from opensuction.settings.validation import choose
from opensuction.settings.wording import name_source, refuse

NORMAL_95 = 1.959963984540054
"""Standard deviations on each side of the mean that hold 95 % of a normal distribution."""

PREDICTED, LOWER, UPPER = "predicted", "lower_95", "upper_95"
"""Columns of the table beside those of the recording."""

DIGITS = "%.15g"
"""As many as any number of a file keeps: .1 is .1."""

UNLIKE = 3.0
"""A recording with this many times the error of the fit is another kind of recording."""


class Prediction(NamedTuple):
    """A recording and its predicted output."""

    choice: PredictionChoice
    """With its columns as the file calls them."""
    identified: Identified
    table: RecordedTable
    inputs: Array
    """Shape (inputs, samples)."""
    time_s: Array | None
    measured: Array | None
    """None where the recording has no such column."""
    predicted: Array
    """In the unit and with the sign of the recorded output."""
    skipped_rows: int
    notes: tuple[str, ...]
    """What a person should know of the choice, a sentence each."""


def predict(choice: PredictionChoice) -> Prediction:
    """Read model and recording, and predict.

    Before the first sample is what the fitted recording began after. Raises InputError for files
    that are none, columns that the recording lacks, and an input in another unit than the model's.
    """
    identified = identification_file.load(choice.parameter_file)
    check_span(choice)
    if choice.file != table.DASH:
        return _predict(choice, identified)
    with table.spool() as file:
        found = _predict(choice._replace(file=file), identified)
    return found._replace(choice=found.choice._replace(file=Path(table.NAME)))


def _predict(choice: PredictionChoice, identified: Identified) -> Prediction:
    parts = identification_file.to_model(identified, choice.parameter_file)
    found = table.open_table(choice.file, choice.sheet)
    choice = _find_columns(choice, identified, found)
    _check_unit(choice, identified)
    wanted = [*choice.driven, *(one for one in (choice.measured, choice.time) if one is not None)]
    columns, skipped = table.read_columns(found, wanted, choice.skip_missing)
    time_s, notes = None, tuple[str, ...]()
    with name_source(choice.file):
        if choice.time is not None:
            time_s = columns[choice.time] * seconds_of_column(choice.time, choice.time_unit)
            array_column.check_time(choice.time, time_s)
            notes = array_column.find_idle_ends(time_s, choice.from_s, choice.to_s)
        driven, *others = (columns[name] for name in choice.driven)
        measured = driven if choice.measured is None else columns[choice.measured]
        pair = Pair(driven, measured, time_s, tuple(others))
        pair = array_column.cut(pair, choice.from_s, choice.to_s)
        if pair.driven.size == 0:
            raise InputError("has no samples")
    inputs = np.array([pair.driven, *pair.others])
    return Prediction(
        choice=choice,
        identified=identified,
        table=found,
        inputs=inputs,
        time_s=pair.time_s,
        measured=None if choice.measured is None else pair.answer,
        predicted=identification_file.predict(identified, parts, inputs),
        skipped_rows=skipped,
        notes=notes,
    )


def _find_columns(
    choice: PredictionChoice, identified: Identified, found: RecordedTable
) -> PredictionChoice:
    """The choice with its columns as the file calls them.

    Raises InputError for those that it lacks.
    """
    known = dict.fromkeys(found.names)
    own = identification_file.input_names(identified)

    def find(name: str) -> str:
        name = table.find_name(found, name)
        choose(name, known, f"column in {choice.file}:")
        return name

    if not choice.driven and any(table.find_name(found, name) not in known for name in own):
        raise refuse(
            choice.file,
            f"the model's {'input is' if len(own) == 1 else 'inputs are'} {', '.join(own)}; name "
            f"{'its column' if len(own) == 1 else 'their columns'} by --input; columns: "
            f"{list_columns(found.names)}",
        )
    named = choice.driven or own
    if len(named) != len(own):
        raise InputError(
            f"--input is given {len(named)} times, the model of {choice.parameter_file} follows "
            f"{len(own)}: {', '.join(own)}"
        )
    output = choice.measured
    if output is None:
        usual = table.find_name(found, identified.about.recording.output.column)
        output = usual if usual in known else None
    return choice._replace(
        driven=tuple(map(find, named)),
        measured=find(output) if output else None,
        time=None if choice.time is None else find(choice.time),
    )


def _check_unit(choice: PredictionChoice, identified: Identified) -> None:
    """Refuse an input in another unit than the fitted one; raises InputError."""
    unit = choose_unit(choice.input_unit, choice.driven[0], "--input-unit")
    fitted = identified.about.recording.input.unit
    if unit and fitted not in {"", "input", unit}:
        raise refuse(
            choice.file,
            f"'{choice.driven[0]}' is in {unit}, and the model of {choice.parameter_file} was "
            f"fitted in {fitted}: give the column in {fitted}",
        )


def summarise(found: Prediction, now: datetime, file: Path) -> PredictionResult:
    """The result. file: of the table that `to_table` gives."""
    about, choice = found.identified.about, found.choice
    half = _half_width(found)
    span, driven = about.recording.input, found.inputs[0]
    beyond = (driven < span.lowest) | (driven > span.highest)
    error = _error(found, half)
    return PredictionResult(
        model=about.model,
        parameter_file=str(choice.parameter_file),
        file=choice.file.name,
        sha256=found.table.sha256,
        samples=int(driven.size),
        skipped_rows=found.skipped_rows,
        inputs=choice.driven,
        output=choice.measured,
        unit=about.rmse_unit,
        lowest=float(found.predicted.min()),
        highest=float(found.predicted.max()),
        beyond_range=int(beyond.sum()),
        interval_half_width=half,
        error=error,
        warnings=(*found.notes, *_warn(found, beyond, error)),
        version=__version__,
        date_utc=now.isoformat(timespec="seconds"),
        prediction_file=str(file),
    )


def _half_width(found: Prediction) -> float | None:
    return NORMAL_95 * found.identified.about.rmse if found.choice.with_interval else None


def _error(found: Prediction, half: float | None) -> PredictionError | None:
    if found.measured is None:
        return None
    signed = found.measured - found.predicted
    rest = np.abs(signed)
    rmse, span = float(np.sqrt(np.mean(rest**2))), float(np.ptp(found.measured))
    return PredictionError(
        rmse=rmse,
        rmse_percent_of_range=100.0 * rmse / span if span > 0.0 else None,
        mean=float(signed.mean()),
        largest=float(rest.max()),
        inside_interval_ratio=None if half is None else float(np.mean(rest <= half)),
    )


def _warn(found: Prediction, beyond: Array, error: PredictionError | None) -> Iterator[str]:
    """Reasons to doubt the prediction, a sentence each."""
    about = found.identified.about
    span = about.recording.input
    if beyond.any():
        first = int(np.argmax(beyond))
        where = f"sample {first}" if found.time_s is None else f"{found.time_s[first]:.10g} s"
        unit = "" if span.unit in {"", "input"} else f" {span.unit}"
        yield (
            f"{int(beyond.sum())} of {beyond.size} samples, the first at {where}, lie outside of "
            f"the inputs that the model was fitted to, {span.lowest:.6g} to {span.highest:.6g}"
            f"{unit}; what is predicted there is a guess."
        )
    if error is not None and about.rmse > 0.0 and error.rmse > UNLIKE * about.rmse:
        unit = "" if about.rmse_unit == "output" else f" {about.rmse_unit}"
        yield (
            f"The error is {error.rmse / about.rmse:.3g} times that of the fit, and its mean is "
            f"{error.mean:.3g}{unit}: the recording is unlike the fitted one (another offset, "
            "gain or path), or begins after another past."
        )


def to_table(found: Prediction) -> str:
    """CSV of a header and a row for each sample: time, inputs, measured and predicted output."""
    choice, half = found.choice, _half_width(found)
    named: list[tuple[str, Array]] = []
    if choice.time is not None and found.time_s is not None:
        named.append(("time_s", found.time_s))
    named += zip(choice.driven, found.inputs, strict=True)
    if choice.measured is not None and found.measured is not None:
        named.append((choice.measured, found.measured))
    named.append((PREDICTED, found.predicted))
    if half is not None:
        named += [(LOWER, found.predicted - half), (UPPER, found.predicted + half)]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow([name for name, _ in named])
    np.savetxt(text, np.column_stack([one for _, one in named]), DIGITS, ",")
    return text.getvalue()
