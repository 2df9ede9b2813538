"""Identification of a recording, from names of columns to results: the workbench's two commands."""

import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.identification import workbench
from opensuction.identification.checked_recording import check_holdout
from opensuction.identification.judgement.coupling import MOST_COLUMNS
from opensuction.identification.judgement.diagnosis import REVERSED_CORRELATION, Labels
from opensuction.identification.judgement.recommendation import PURPOSES, Aim
from opensuction.identification.method import COUPLED, METHODS, MODELS
from opensuction.identification.workbench import FittedModel, Progress
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.recording import pair as recorded
from opensuction.recording import standard_input, table
from opensuction.recording.pair import Pair
from opensuction.recording.table import RecordedTable
from opensuction.session.choice import RecordingChoice
from opensuction.settings.choice import choose
from opensuction.settings.unit import unit_of_column
from opensuction.settings.wording import name_source, refuse

SECONDS = {"us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0}
"""Units of time that a column's name may carry; without one it is in seconds."""

MOST_FITS, REPEATED_S, TIMED_S = 20, 0.1, 0.25
"""How often and how long one fit is timed, and how long all of them: `time_fits`."""

MOST_LISTED = 60
"""Columns of a file that a message names."""

UNSAID = {"input": "what drives by --input", "output": "what follows by --output"}
"""What a message asks for where a column was not named."""

UNKNOWN_UNITS = ("input", "output")
"""What units are called where a column's name has none: a slope is then in output/input."""


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


def check(choice: RecordingChoice, model: str | None, method: str | None) -> None:
    """Refuse unknown names and impossible numbers before a file is read; raises InputError."""
    if model is not None:
        choose(model, MODELS, "model")
    if method is not None:
        choose(method, METHODS, "method")
    check_holdout(choice.holdout, "--holdout")
    _check_span(choice)
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


def _check_span(choice: RecordingChoice) -> None:
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
    if choice.file != standard_input.DASH:
        return _load(choice, model, method)
    with standard_input.spool() as file:
        loaded = _load(choice._replace(file=file), model, method)
    return loaded._replace(choice=choice._replace(file=Path(standard_input.NAME)))


def _load(choice: RecordingChoice, model: str | None, method: str | None) -> LoadedRecording:
    found = table.open_table(choice.file)
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
        listed = ", ".join(found.names[:MOST_LISTED])
        more = len(found.names) - MOST_LISTED
        rest = f" and {more} more" if more > 0 else ""
        raise refuse(choice.file, f"name {' and '.join(unsaid)}; its columns{note}: {listed}{rest}")
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
    with name_source(choice.file):
        if choice.time is not None:
            time_s = columns[choice.time] * SECONDS.get(unit_of_column(choice.time), 1.0)
            recorded.check_time(choice.time, time_s)
        answer = -columns[choice.output] if choice.negate_output else columns[choice.output]
        driven, *others = (columns[name] for name in choice.input)
        beside = read_beside()
        pair = Pair(driven, answer, time_s, (*others, *beside.values()))
        pair = recorded.cut(pair, choice.from_s, choice.to_s)
        rest = dict(zip(beside, pair.others[len(others) :], strict=True))
        pair = pair._replace(others=pair.others[: len(others)])
        recorded.check(pair, choice.input[0], choice.output, choice.input[1:])
    return loaded._replace(pair=pair, beside=rest)


def _read_beside(
    found: RecordedTable, wanted: list[str], samples: int, skip_missing: bool
) -> dict[str, Array]:
    """The other columns of the file, those left out that are not as many numbers."""
    columns: dict[str, Array] = {}
    # Rows that are left out are known by the columns that were named.
    same_rows = wanted if skip_missing else []
    for name in found.names:
        if name not in wanted and len(columns) < MOST_COLUMNS:
            with suppress(InputError):
                read, _ = table.read_columns(found, [*same_rows, name], skip_missing)
                columns |= {name: read[name]} if read[name].size == samples else {}
    return columns


def name_columns(choice: RecordingChoice) -> Labels:
    """Names and units of the columns, as estimators and reports call them."""
    return Labels(
        input_name=choice.input[0],
        other_names=choice.input[1:],
        output_name=f"-{choice.output}" if choice.negate_output else choice.output,
        input_unit=choose_unit(choice.input_unit, choice.input[0]) or UNKNOWN_UNITS[0],
        output_unit=choose_unit(choice.output_unit, choice.output) or UNKNOWN_UNITS[1],
    )


def choose_unit(given: str | None, column: str) -> str:
    """The unit that was given, else the one in the column's name; "" where there is none."""
    return unit_of_column(column) if given is None else given


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
            return workbench.compare(
                *recording,
                choice.holdout,
                labels,
                progress,
                loaded.beside,
                Aim(purpose),
            )
        return [
            workbench.identify(
                *recording,
                loaded.model,
                loaded.method,
                choice.holdout,
                labels,
                loaded.beside,
            )
        ]


def time_fits(results: list[FittedModel]) -> dict[str, float]:
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
