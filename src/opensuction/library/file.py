"""Recordings from files, as columns for scripts."""

from os import PathLike
from pathlib import Path

from opensuction.kernel.record import Array
from opensuction.library.columns import in_python
from opensuction.recording import table
from opensuction.settings.choice import choose


class Table(dict[str, Array]):
    """Columns of a file by name, each of shape (samples,)."""

    def __repr__(self) -> str:
        samples = next(iter(self.values())).size if self else 0
        return f"Table({samples} samples of {', '.join(self)})"


def read(path: str | PathLike[str], *names: str, skip_missing: bool = False) -> Table:
    """Columns of a recording by name: of CSV, Parquet, NumPy's ``.npz`` or MATLAB's ``.mat``.

    names: of the columns that are wanted; none: all of them. skip_missing: rows in which one of
    them has no number are left out instead of refused. Raises InputError for what is no such file,
    a column that it lacks, and cells that are no numbers.
    """
    with in_python():
        found = table.open_table(Path(path))
        wanted = {name: table.find_name(found, name) for name in names or found.names}
        for name in wanted.values():
            choose(name, dict.fromkeys(found.names), f"column in {path}:")
        columns, _ = table.read_columns(found, [*wanted.values()], skip_missing)
    return Table({name: columns[full] for name, full in wanted.items()})
