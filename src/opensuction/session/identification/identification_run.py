"""Identification of a recording, from names of columns to results: the workbench's two commands."""

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.identification import workbench
from opensuction.identification.checked_recording import check_holdout
from opensuction.identification.judgement.diagnosis import (
    REVERSED_CORRELATION,
    UNKNOWN_UNITS,
    Labels,
)
from opensuction.identification.judgement.fitted_range import MOST_COLUMNS
from opensuction.identification.judgement.recommendation import PURPOSES, Aim
from opensuction.identification.workbench import COUPLED, METHODS, MODELS, FittedModel, Progress
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.recording import array_column, table
from opensuction.recording.array_column import Pair
from opensuction.recording.column_unit import find_unit, seconds_of_column, unit_of_column
from opensuction.recording.table import RecordedTable
from opensuction.session.choice import PredictionChoice, RecordingChoice
from opensuction.settings.validation import choose
from opensuction.settings.wording import name_source, refuse

MOST_FITS, REPEATED_S, TIMED_S = 20, 0.1, 0.25
"""How often and how long one fit is timed, and how long all of them: `time_fits`."""

MOST_LISTED = 60
"""Columns of a file that a message names."""

UNSAID = {"input": "what drives by --input", "output": "what follows by --output"}
"""What a message asks for where a column was not named."""


class LoadedRecording(NamedTuple):
    """A recording ready to be identified."""

    choice: RecordingChoice
    model: str | None
    """None: all of them are compared."""
    method: str | None
    """None: the model's own."""
    table: RecordedTable
    pair: Pair
    labels: Labels
    """Names and units, ``input`` and ``output`` for units that are not known."""
    beside: dict[str, Array]
    """Columns of the file that were not named, as far as they are numbers."""
    skipped_rows: int = 0
    """Left out, for one of the columns has no number there."""
    notes: tuple[str, ...] = ()
    """What a person should know of the choice, a sentence each."""


def check(choice: RecordingChoice, model: str | None, method: str | None) -> None:
    """Refuse unknown names and impossible numbers before a file is read; raises InputError."""
    if model is not None:
        choose(model, MODELS, "model")
    if method is not None:
        choose(method, METHODS, "method")
    check_holdout(choice.holdout, "--holdout")
    check_span(choice)
    _check_names(choice)
    if len(choice.input) > 1 and model is not None and model != COUPLED:
        raise InputError(
            f"model '{model}' follows one --input, not {len(choice.input)}: add --model "
            f"{COUPLED}, or leave out the others"
        )


def _check_names(choice: RecordingChoice) -> None:
    """Refuse a column that is named twice; raises InputError."""
    for name in choice.input:
        if choice.input.count(name) > 1:
            raise InputError(f"--input '{name}' is given twice; name each column once")
    if choice.output and choice.output in choice.input:
        raise InputError(
            f"--input and --output are both '{choice.output}'; name the column that drives and the "
            "one that follows"
        )


def check_purpose(purpose: str) -> None:
    """Refuse an unknown purpose before a file is read; raises InputError."""
    choose(purpose, PURPOSES, "purpose")


def check_span(choice: RecordingChoice | PredictionChoice) -> None:
    """Refuse a span of time that cannot be meant; raises InputError."""
    if choice.time_unit is not None:
        if choice.time is None:
            raise InputError("--time-unit needs the column of time: give --time")
        seconds_of_column(choice.time, choice.time_unit)
    for option, end_s in (("--from", choice.from_s), ("--to", choice.to_s)):
        if end_s is None:
            continue
        if choice.time is None:
            raise InputError(f"{option} needs the column of time: give --time")
        if not math.isfinite(end_s):
            raise InputError(f"{option} {end_s}: should be a time in seconds")


def load(choice: RecordingChoice, model: str | None, method: str | None) -> LoadedRecording:
    """Read the columns that were named, for one model by one method or, with None, for all.

    Raises InputError for a file that is no table, columns that it does not have, cells that are
    no numbers, a time that does not rise, and records that cannot show how one follows the other.
    """
    check(choice, model, method)
    if choice.file != table.DASH:
        return _load(choice, model, method)
    with table.spool() as file:
        loaded = _load(choice._replace(file=file), model, method)
    return loaded._replace(choice=choice._replace(file=Path(table.NAME)))


def _load(choice: RecordingChoice, model: str | None, method: str | None) -> LoadedRecording:
    found = table.open_table(choice.file, choice.sheet)
    choice = _find_columns(choice, found)
    wanted = [*choice.input, choice.output]
    if choice.time is not None:
        wanted.append(choice.time)
    columns, skipped = table.read_columns(found, wanted, choice.skip_missing)
    return arrange(
        LoadedRecording(
            choice=choice,
            model=model,
            method=method,
            table=found,
            pair=Pair(columns[choice.input[0]], columns[choice.output], None),
            labels=name_columns(choice),
            beside={},
            skipped_rows=skipped,
        ),
        columns,
        lambda: _read_beside(found, wanted, columns[choice.output].size, choice.skip_missing),
    )


def _find_columns(choice: RecordingChoice, found: RecordedTable) -> RecordingChoice:
    """The choice with its columns as the file calls them.

    Raises InputError for those that it lacks, and where none was named, with those that it has.
    """
    note = f" ({found.note})" if found.note else ""
    unsaid = [words for name, words in UNSAID.items() if not getattr(choice, name)]
    if unsaid:
        raise refuse(
            choice.file,
            f"name {' and '.join(unsaid)}; its columns{note}: {list_columns(found.names)}",
        )
    known = dict.fromkeys(found.names)

    def find(name: str) -> str:
        name = table.find_name(found, name)
        choose(name, known, f"column in {choice.file}{note}:")
        return name

    choice = choice._replace(
        input=tuple(map(find, choice.input)),
        output=find(choice.output),
        time=None if choice.time is None else find(choice.time),
    )
    _check_names(choice)
    return choice


def list_columns(names: Sequence[str]) -> str:
    """Columns of a file, as a message names them."""
    more = len(names) - MOST_LISTED
    return ", ".join(names[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")


def arrange(
    loaded: LoadedRecording,
    columns: Mapping[str, Array],
    read_beside: Callable[[], dict[str, Array]],
) -> LoadedRecording:
    """The recording with the part of its columns that is used, as it is identified.

    columns: those that were named. read_beside: gives the others, once these are fit to be used.
    Raises InputError for a time that does not rise, and records that cannot show how one follows
    the other.
    """
    choice, time_s = loaded.choice, None
    notes: tuple[str, ...] = ()
    with name_source(choice.file):
        if choice.time is not None:
            time_s = columns[choice.time] * seconds_of_column(choice.time, choice.time_unit)
            array_column.check_time(choice.time, time_s)
            notes = array_column.find_idle_ends(time_s, choice.from_s, choice.to_s)
        answer = -columns[choice.output] if choice.negate_output else columns[choice.output]
        driven, *others = (columns[name] for name in choice.input)
        beside = read_beside()
        pair = Pair(driven, answer, time_s, (*others, *beside.values()))
        pair = array_column.cut(pair, choice.from_s, choice.to_s)
        rest = dict(zip(beside, pair.others[len(others) :], strict=True))
        pair = pair._replace(others=pair.others[: len(others)])
        array_column.check(pair, choice.input[0], choice.output, choice.input[1:])
    return loaded._replace(pair=pair, beside=rest, notes=notes)


def _read_beside(
    found: RecordedTable, wanted: list[str], samples: int, skip_missing: bool
) -> dict[str, Array]:
    """The other columns of the file, those left out that are not as many numbers."""
    others = [name for name in found.names if name not in wanted and found.names.count(name) == 1]
    # Rows that are left out are known by the columns that were named.
    same_rows = tuple(wanted) if skip_missing else ()
    columns: dict[str, Array] = {}
    while others and len(columns) < MOST_COLUMNS:
        tried = tuple(others[: MOST_COLUMNS - len(columns)])
        others = others[len(tried) :]
        for name, values in _read_numbers(found, tried, same_rows).items():
            if values.size == samples and np.isfinite(values).all():
                columns[name] = values
    return columns


def _read_numbers(
    found: RecordedTable, names: tuple[str, ...], same_rows: tuple[str, ...]
) -> dict[str, Array]:
    """Those columns that hold no text, in one pass over the file if all are such, else by halves.

    Without the rows in which one of ``same_rows`` has no number; NaN for other missing ones.
    """
    try:
        read = found.read(found.path, (*same_rows, *names), True)
    except InputError:
        if len(names) == 1:
            return {}
        middle = len(names) // 2
        halves = names[:middle], names[middle:]
        return {
            name: values
            for half in halves
            for name, values in _read_numbers(found, half, same_rows).items()
        }
    if not same_rows:
        return read
    whole = np.isfinite([read[name] for name in same_rows]).all(axis=0)
    return {name: read[name][whole] for name in names if read[name].size == whole.size}


def name_columns(choice: RecordingChoice) -> Labels:
    """Names and units of the columns, as estimators and reports call them."""
    units = [
        choose_unit(given, column, option)
        for given, column, option in (
            (choice.input_unit, choice.input[0], "--input-unit"),
            (choice.output_unit, choice.output, "--output-unit"),
        )
    ]
    return Labels(
        input_name=choice.input[0],
        other_names=choice.input[1:],
        output_name=f"-{choice.output}" if choice.negate_output else choice.output,
        input_unit=units[0] or UNKNOWN_UNITS[0],
        output_unit=units[1] or UNKNOWN_UNITS[1],
    )


def choose_unit(given: str | None, column: str, option: str) -> str:
    """The unit that was given, else the one in the column's name; "" where there is none.

    Raises InputError, with the option that settles it, for brackets that hold no known unit.
    """
    if given is not None:
        return find_unit(given) or given
    unit = unit_of_column(column)
    if unit is None:
        raise InputError(
            f"column '{column}': what stands in brackets is no known unit; give {option}, '' for "
            "none"
        )
    return unit


def fit(
    loaded: LoadedRecording, progress: Progress | None = None, purpose: str = "predict"
) -> list[FittedModel]:
    """The chosen model, fitted, or every model, the recommended one first.

    progress: called before each of them. purpose: what the recommended one is for.

    Raises InputError where the recording does not allow it.
    """
    choice, labels = loaded.choice, loaded.labels
    _check_direction(loaded)
    pair = loaded.pair
    inputs = np.array([pair.driven, *pair.others]) if pair.others else pair.driven
    recording = inputs, pair.answer, pair.time_s
    with name_source(choice.file):
        if loaded.model is None:
            found = workbench.compare(
                *recording,
                choice.holdout,
                labels,
                progress,
                loaded.beside,
                Aim(purpose),
            )
        else:
            found = [
                workbench.identify(
                    *recording,
                    loaded.model,
                    loaded.method,
                    choice.holdout,
                    labels,
                    loaded.beside,
                )
            ]
    return [each._replace(warnings=(*loaded.notes, *each.warnings)) for each in found]


def time_fits(results: Iterable[FittedModel]) -> dict[str, float]:
    """Seconds of processor time that the fit of each model takes by itself, warm.

    Each is done again up to `MOST_FITS` times or for `REPEATED_S`, at least once; the shortest
    counts. Processor time, for a fit waits for nothing but the processor, and what other programs
    take of it is not the fit's. Not a number for models, in the catalogue's order, whose turn comes
    when `TIMED_S` are over.
    """
    began_s, found = time.process_time(), {}
    for result in sorted(results, key=lambda each: [*MODELS].index(each.model)):
        took_s: list[float] = []
        while not took_s or (len(took_s) < MOST_FITS and sum(took_s) < REPEATED_S):
            at_s = time.process_time()
            if at_s - began_s > TIMED_S:
                break
            result.refit()
            took_s.append(time.process_time() - at_s)
        found[result.model] = min(took_s, default=math.nan)
    return found


def _check_direction(loaded: LoadedRecording) -> None:
    """Refuse an output that runs against its input, with the option that turns it round."""
    slope, _ = fit_line(loaded.pair)
    choice = loaded.choice
    if slope < 0.0:
        correlation = float(np.corrcoef(loaded.pair.driven, loaded.pair.answer)[0, 1])
        if correlation > REVERSED_CORRELATION:
            raise InputError(
                f"{choice.file}: '{loaded.labels.output_name}' does not follow '{choice.input[0]}' "
                f"(correlation {correlation:.2f}): see that these columns belong together; where "
                "it should fall as the input rises, add or leave out --negate-output"
            )
        remedy = "leave out" if choice.negate_output else "add"
        raise InputError(
            f"{choice.file}: '{loaded.labels.output_name}' falls where '{choice.input[0]}' rises, "
            f"and should follow it: {remedy} --negate-output"
        )


def fit_line(pair: Pair) -> tuple[float, float]:
    """Slope of the straight line through a recording, and the RMSE that it leaves.

    What any model of hysteresis has to beat.
    """
    driven = pair.driven - pair.driven.mean()
    answer = pair.answer - pair.answer.mean()
    slope = float(driven @ answer / (driven @ driven))
    rest = answer - slope * driven
    return slope, float(np.sqrt(rest @ rest / rest.size))
