"""MATLAB files: variables that are rows or columns of numbers, each a column of the recording.

Versions 5 to 7 are read by SciPy, version 7.3, which is HDF5, by h5py, an optional part:
``opensuction[matlab]``. Structures, cells, tables and matrices are refused with what would do.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.array_column import check_shape, is_row, read_numbers, write_shape

MAGIC = b"MATLAB 5.0"
MAGIC_73 = b"MATLAB 7.3"
"""How MATLAB's files begin, the first of versions 5 to 7."""

NUMERIC = frozenset(
    (
        *("double", "single", "logical"),
        *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)),
    )
)
"""Classes of variables whose values are numbers."""


class _Variable(NamedTuple):
    """A variable of a file, its values not yet read."""

    name: str
    shape: tuple[int, ...]
    kind: str
    """MATLAB's class."""


def _remedy(path: Path) -> str:
    return (
        "in MATLAB, give each column a name of its own and save them: x = data.x; "
        f"save('{path.name}', 'x', 'y')"
    )


@contextmanager
def _whole(path: Path) -> Iterator[None]:
    """Whatever a reader raises in here says that the file is damaged."""
    try:
        yield
    except InputError:
        raise
    except Exception:  # both readers raise almost anything for bytes that are not what they seem
        raise InputError(f"{path}: is a damaged or incomplete MATLAB file; save it again") from None


def _list(variables: Sequence[_Variable]) -> str:
    return ", ".join(f"{one.name} ({write_shape(one.shape)} {one.kind})" for one in variables)


def _names(path: Path, variables: Sequence[_Variable]) -> tuple[str, ...]:
    """Names of all variables. Raises InputError where none is a row of numbers."""
    if not any(one.kind in NUMERIC and is_row(one.shape) for one in variables):
        held = f"holds {_list(variables)}" if variables else "holds no variables"
        raise InputError(f"{path}: {held}, no row or column of numbers; {_remedy(path)}")
    return tuple(one.name for one in variables)


def _check(path: Path, name: str, variables: Sequence[_Variable]) -> None:
    """Refuse a variable that is no row of numbers; raises InputError."""
    one = next(one for one in variables if one.name == name)
    if one.kind not in NUMERIC:
        raise InputError(
            f"{path}: {name!r} is a {one.kind} of {write_shape(one.shape)}, should be a row or "
            f"column of numbers; the file has {_list(variables)}: {_remedy(path)}"
        )
    check_shape(path, name, one.shape)


def _variables_5(path: Path) -> list[_Variable]:
    from scipy.io import whosmat

    with _whole(path):
        return [_Variable(*one) for one in whosmat(path)]


def read_names(path: Path) -> tuple[str, ...]:
    """Names of the variables. Raises InputError for a damaged file, and one without numbers."""
    return _names(path, _variables_5(path))


def read_columns(
    path: Path, wanted: Sequence[str], allow_missing: bool = False
) -> dict[str, NDArray[np.float64]]:
    """Numbers of the columns that are wanted; see `table.read_columns`."""
    from scipy.io import loadmat

    variables = _variables_5(path)
    for name in wanted:
        _check(path, name, variables)
    with _whole(path):
        found = loadmat(path, variable_names=list(wanted))
        return {name: read_numbers(path, name, found[name], allow_missing) for name in wanted}


@contextmanager
def _open_73(path: Path) -> Iterator[Any]:
    """The file, open. Raises InputError where h5py is not installed or cannot make it out."""
    try:
        import h5py
    except ImportError:
        raise InputError(
            f"{path}: is a MATLAB 7.3 file, which needs h5py: pip install 'opensuction[matlab]', "
            "or save it in MATLAB with '-v7'"
        ) from None
    with _whole(path), h5py.File(path, "r") as file:
        yield file


def _variables_73(file: Any) -> list[_Variable]:
    """The variables of an open file; what lies in other files is none."""
    import h5py

    found = []
    for name in file:
        if name.startswith("#") or not isinstance(file.get(name, getlink=True), h5py.HardLink):
            continue
        item = file[name]
        kind = item.attrs.get("MATLAB_class", b"unknown class")
        words = kind.decode() if isinstance(kind, bytes) else str(kind)
        if not isinstance(item, h5py.Dataset):
            found.append(_Variable(name, (1, 1), words))
        elif not item.external:
            # Axes come in reverse.
            found.append(_Variable(name, item.shape[::-1], words))
    return found


def read_names_73(path: Path) -> tuple[str, ...]:
    """As `read_names`, of a file of version 7.3."""
    with _open_73(path) as file:
        return _names(path, _variables_73(file))


def read_columns_73(
    path: Path, wanted: Sequence[str], allow_missing: bool = False
) -> dict[str, NDArray[np.float64]]:
    """As `read_columns`, of a file of version 7.3."""
    with _open_73(path) as file:
        variables = _variables_73(file)
        for name in wanted:
            _check(path, name, variables)
        return {name: read_numbers(path, name, file[name][()], allow_missing) for name in wanted}
