"""Recordings as a script holds them: arrays, columns of data frames, with their names where known.

Nothing of pandas or polars is imported: a series says its name, a data frame its columns, and both
become arrays by NumPy's own protocol.

Recordings from files, as columns for scripts.
"""

import hashlib
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from opensuction.identification.record import read_samples
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.recording import table
from opensuction.recording.array_column import Pair, count_seconds
from opensuction.recording.table import RecordedTable
from opensuction.session.choice import RecordingChoice
from opensuction.session.identification import identification_run
from opensuction.session.identification.identification_run import LoadedRecording
from opensuction.settings.validation import choose

SOURCE = Path("arrays")
"""What stands for the file where there is none."""
TIME = "time"
OUTPUT = "y"

Values = Any
"""Whatever `numpy.asarray` takes."""


class Given(NamedTuple):
    """Description of a recording, beside input and output."""

    time: Values = None
    """When the samples were taken, in s; dates and durations of NumPy too. None: evenly."""
    holdout: float = 0.0
    """Share from its end that is predicted instead of fitted."""
    negate_output: bool = False
    names: Sequence[str] | None = None
    """Of every input, then of the output; None: as series and data frames call them."""
    units: tuple[str, str] | None = None
    """Of input and output; None: those in their names."""


@contextmanager
def in_python() -> Iterator[None]:
    """A refusal in here speaks of keywords where the command's speaks of options."""
    try:
        yield
    except InputError as refused:
        words = re.sub("--(input|output)-unit", "units", str(refused))
        words = re.sub(r"--([a-z][a-z-]*)", lambda found: found[1].replace("-", "_"), words)
        raise InputError(words) from None


def to_row(name: str, values: Values) -> Array:
    """One quantity as a row of finite numbers; raises InputError."""
    row = np.asarray(values)
    if isinstance(values, np.ma.MaskedArray):
        row = np.ma.filled(values.astype(np.float64), np.nan)  # masked: missing
    if row.dtype.kind in "Mm" and row.ndim == 1 and row.size:
        row = count_seconds(row)
    if row.dtype.kind in "cSUV":
        raise InputError(f"{name}: not a row of numbers but of {row.dtype}")
    if row.ndim == 2 and 1 in row.shape:
        row = row.reshape(-1)
    return read_samples(name, row, 1)


def _read_table(x: Values) -> dict[str, Values] | None:
    """The columns of a mapping or a data frame; None for anything else."""
    if isinstance(x, Mapping):
        return {str(name): x[name] for name in x}
    names = getattr(x, "columns", None)
    if names is None:
        return None
    return {str(name): x[name] for name in names}


def _name(series: Values) -> str | None:
    """The name of a series; None for what has none."""
    name = getattr(series, "name", None)
    return name if isinstance(name, str) and name else None


def split_inputs(x: Values) -> dict[str, Values]:
    """Every input by its name: of a row, of the columns of a matrix, of a data frame.

    Raises InputError for another shape.
    """
    table = _read_table(x)
    if table is not None:
        if not table:
            raise InputError("x: has no columns; give at least one input")
        return table
    matrix = np.asarray(x)
    if matrix.ndim == 1:
        return {_name(x) or "x": x}
    if matrix.ndim != 2:
        raise InputError(f"x: shape {matrix.shape}, should be (samples,) or (samples, inputs)")
    samples, inputs = matrix.shape
    if inputs == 0:
        raise InputError("x: has no columns; give at least one input")
    if inputs > samples:
        raise InputError(f"x: shape {matrix.shape}, should be (samples, inputs); transpose it: x.T")
    if inputs == 1:
        return {"x": matrix[:, 0]}
    return {f"x{place + 1}": matrix[:, place] for place in range(inputs)}


def read_inputs(x: Values, count: int) -> Array:
    """Inputs for a model of ``count`` of them, shape (count, n). Raises InputError."""
    rows = [to_row(name, values) for name, values in split_inputs(x).items()]
    if len(rows) != count:
        expected = "one input" if count == 1 else f"{count} inputs, shape (samples, {count})"
        raise InputError(f"x: has {len(rows)} inputs, the model follows {expected}")
    if len({row.size for row in rows}) > 1:
        raise InputError(f"x: inputs of {', '.join(str(row.size) for row in rows)} samples")
    return np.array(rows)


def _name_columns(
    x: Values, y: Values, names: Sequence[str] | None
) -> tuple[dict[str, Array], str]:
    """Inputs by name, the output among them as the last, and the output's name."""
    inputs = split_inputs(x)
    called = [*inputs, _name(y) or OUTPUT]
    if names is not None:
        if isinstance(names, str) or len(names) != len(called):
            raise InputError(
                f"names: {names!r}, should be {len(called)} names: of each input, then of the "
                "output"
            )
        called = list(names)
    if len(set(called)) < len(called):
        raise InputError(f"names: {', '.join(called)}: each should be another; give names=")
    rows = {
        name: to_row(name, values)
        for name, values in zip(called, [*inputs.values(), y], strict=True)
    }
    return rows, called[-1]


def _read_units(units: Values) -> tuple[str | None, str | None]:
    """Units of input and output; raises InputError for anything but two texts."""
    if units is None:
        return None, None
    if isinstance(units, str) or len(units) != 2 or not all(isinstance(u, str) for u in units):
        raise InputError(f"units: {units!r}, should be those of input and output: ('mm', 'mm')")
    first, last = units
    return first, last


def load(
    x: Values, y: Values, given: Given, model: str | None, method: str | None
) -> LoadedRecording:
    """A recording of arrays, ready to be identified; see `identification_run.load`.

    Raises InputError for what cannot be identified.
    """
    columns, output = _name_columns(x, y, given.names)
    units = _read_units(given.units)
    time = None if given.time is None else (TIME if TIME not in columns else f"{TIME} (s)")
    choice = RecordingChoice(
        file=SOURCE,
        input=tuple(name for name in columns if name != output),
        output=output,
        time=time,
        negate_output=given.negate_output,
        holdout=given.holdout,
        input_unit=units[0],
        output_unit=units[1],
    )
    identification_run.check(choice, model, method)
    if time is not None:
        columns[time] = to_row(time, given.time)
    sizes = {name: row.size for name, row in columns.items()}
    if len(set(sizes.values())) > 1:
        listed = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise InputError(f"samples of {listed}: they should be as many")
    digest = hashlib.sha256()
    for row in columns.values():
        digest.update(row.astype("<f8").tobytes())
    bare = LoadedRecording(
        choice=choice,
        model=model,
        method=method,
        table=RecordedTable(
            path=SOURCE,
            names=tuple(columns),
            read=lambda _, wanted, __: {name: columns[name] for name in wanted},
            size_bytes=sum(row.nbytes for row in columns.values()),
            sha256=digest.hexdigest(),
        ),
        pair=Pair(columns[choice.input[0]], columns[output], None),
        labels=identification_run.name_columns(choice),
        beside={},
    )
    return identification_run.arrange(bare, columns, dict)


class Table(dict[str, Array]):
    """Columns of a file by name, each of shape (samples,)."""

    def __repr__(self) -> str:
        samples = next(iter(self.values())).size if self else 0
        return f"Table({samples} samples of {', '.join(self)})"


def read(
    path: str | PathLike[str], *names: str, skip_missing: bool = False, sheet: str | None = None
) -> Table:
    """Columns of a recording by name: of CSV, JSON, Excel, Parquet, NumPy's or MATLAB's files.

    names: of the columns that are wanted; none: all of them. skip_missing: rows in which one of
    them has no number are left out instead of refused. sheet: of an Excel workbook; None: the one
    that has rows of numbers. Raises InputError for what is no such file, a column or sheet that it
    lacks, and cells that are no numbers.
    """
    with in_python():
        found = table.open_table(Path(path), sheet)
        wanted = {name: table.find_name(found, name) for name in names or found.names}
        for name in wanted.values():
            choose(name, dict.fromkeys(found.names), f"column in {path}:")
        columns, _ = table.read_columns(found, [*wanted.values()], skip_missing)
    return Table({name: columns[full] for name, full in wanted.items()})


def write_text(rows: Sequence[Sequence[str]]) -> str:
    """A table in columns of even width, a line for each row."""
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
    lines = (
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )
    return "\n".join(lines)


def write_html(rows: Sequence[Sequence[str]]) -> str:
    """A table as a notebook shows it."""
    cells = (f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table>{''.join(cells)}</table>"
