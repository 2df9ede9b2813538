"""A data set of the leaderboard: where it is from, which part is fitted and which is held out.

Nothing is fetched. A file lies in a folder that the user names and is known by its checksum; a data
set that equations describe is computed instead (`DataSet.generate`).
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.recording import table
from opensuction.settings.validation import choose

THERE, NOT_THERE, OTHER_FILE, GENERATED = "there", "not there", "other file", "generated"
"""States of a data set: what was found of it."""
SHOWN_DIGITS = 12
"""Digits of a checksum in a message."""

Columns = Mapping[str, Array]


class Split(NamedTuple):
    """Parts of a recording, as numbers of samples from its beginning, counted from 0."""

    first: int
    """First sample that is fitted; those before it are left out."""
    fitted_end: int
    """The sample after the last one that is fitted."""
    held_out: int
    """First sample whose error counts."""
    end: int
    """The sample after the last one whose error counts."""
    words: str
    """The same in words."""


class Published(NamedTuple):
    """An error that others published for the same held-out samples."""

    by: str
    rrse: float
    """Root relative squared error, as `HeldOutError.rrse`."""
    source: str
    """Tag of ``docs/sources.md``."""


class DataSet(NamedTuple):
    """Description of a recording, and of what is asked of a model on it."""

    name: str
    title: str
    inputs: tuple[str, ...]
    """Columns of what drives, the first one the one that a model of one input follows."""
    output: str
    """Column of what follows."""
    split: Split
    sampling: str
    """In words: the rate, and how the samples were thinned where they were."""
    licence: str
    source: str
    """Repository, or the article that gives the equations."""
    units: tuple[str, ...] = ()
    """Of the inputs and the output, as far as they are known."""
    file: str = ""
    """Name of the file; empty for a data set that is generated."""
    sha256: str = ""
    generate: Callable[[], Columns] | None = None
    """Computes the columns of a data set that equations describe; None: they are in the file."""
    simulated: bool = False
    """True where no laboratory measured it."""
    period_s: float | None = None
    """Between samples; None: unknown or uneven."""
    negate_output: bool = False
    skip_missing: bool = False
    """Leave out rows in which a column has no number."""
    published: tuple[Published, ...] = ()


class Samples(NamedTuple):
    """A data set as models take it, from its first fitted sample to its last held-out one."""

    data_set: DataSet
    inputs: Array
    """Shape (inputs, n)."""
    output: Array
    """Shape (n,); a model sees the first ``fitted`` of them alone."""
    fitted: int
    """Number of samples, from the first, that a model is fitted to."""
    held_out: int
    """The first sample whose error counts."""

    @property
    def time_s(self) -> Array | None:
        """Instants of the samples, shape (n,); None where the period is not known."""
        period_s = self.data_set.period_s
        return (
            None if period_s is None else period_s * np.arange(self.output.size, dtype=np.float64)
        )


class Found(NamedTuple):
    """A data set as it was found."""

    data_set: DataSet
    state: str
    note: str
    """Where it was found, or the sentence that says why it cannot be used."""
    samples: Samples | None
    """None where it cannot be used."""


def halves(first: int, samples: int) -> Split:
    """The first half of a recording fitted, the second held out. first: as in `Split`."""
    middle = first + (samples - first) // 2
    left = f"; the first {first} left out" if first else ""
    return Split(first, middle, middle, samples, f"first half fitted, second held out{left}")


def select(names: tuple[str, ...], known: Mapping[str, DataSet]) -> tuple[DataSet, ...]:
    """Data sets by name, each once; all of them where no name is given. Raises InputError."""
    for name in names:
        choose(name, known, "data set")
    return tuple(known[name] for name in dict.fromkeys(names or known))


def find(data_set: DataSet, folder: Path | None) -> Found:
    """Look for a data set in a folder, or one below it, and read it.

    folder: None: none was named, so that only what is generated can be used. Raises InputError for
    a folder that is none, and for a file that cannot be read although its checksum is right.
    """
    if data_set.generate is not None:
        return Found(data_set, GENERATED, data_set.source, cut(data_set, data_set.generate()))
    if folder is None:
        return _miss(data_set, "no folder of data was named")
    if not folder.is_dir():
        raise InputError(f"--data {folder}: no such folder; name the one that the files lie in")
    candidates = [folder / data_set.file, *sorted(folder.glob(f"*/{data_set.file}"))]
    files = [one for one in candidates if one.is_file()]
    if not files:
        return _miss(data_set, f"no {data_set.file} in {folder}")
    opened = [table.open_table(one) for one in files]
    right = next((one for one in opened if one.sha256 == data_set.sha256), None)
    if right is None:
        given = opened[0].sha256[:SHOWN_DIGITS]
        note = (
            f"{opened[0].path}: its sha256 begins with {given}, not "
            f"{data_set.sha256[:SHOWN_DIGITS]}: another version of the file"
        )
        return Found(data_set, OTHER_FILE, note, None)
    return Found(data_set, THERE, str(right.path), cut(data_set, _read(data_set, right)))


def _miss(data_set: DataSet, why: str) -> Found:
    return Found(data_set, NOT_THERE, f"{why}; it is published at {data_set.source}", None)


def _read(data_set: DataSet, found: table.RecordedTable) -> Columns:
    """Columns of a file by the names of the data set."""
    wanted = {name: table.find_name(found, name) for name in (*data_set.inputs, data_set.output)}
    columns, _ = table.read_columns(found, [*wanted.values()], data_set.skip_missing)
    return {name: columns[full] for name, full in wanted.items()}


def cut(data_set: DataSet, columns: Columns) -> Samples:
    """The samples that count. Raises InputError for fewer samples than the split needs."""
    split = data_set.split
    inputs = np.array([columns[name] for name in data_set.inputs], dtype=np.float64)
    output = np.asarray(columns[data_set.output], dtype=np.float64)
    if output.size < split.end:
        raise InputError(
            f"data set '{data_set.name}': {output.size} samples, its split needs {split.end}"
        )
    kept = slice(split.first, split.end)
    return Samples(
        data_set,
        np.ascontiguousarray(inputs[:, kept]),
        np.ascontiguousarray((-1.0 if data_set.negate_output else 1.0) * output[kept]),
        split.fitted_end - split.first,
        split.held_out - split.first,
    )
