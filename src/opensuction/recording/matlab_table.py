"""MATLAB files: variables that are rows or columns of numbers, each a column of the recording.

A matrix gives its columns by MATLAB's own names, ``x(:,1)``, or its rows where these are longer. A
structure gives its fields, ``data.x``; an array of structures each field as one column where it
holds one number in each element, ``data.x``, else the field of each element, ``data(2).x``. Cells
and tables are refused with what would do.

Versions 5 to 7 are read by SciPy, version 7.3, which is HDF5, by h5py, an optional part:
``opensuction[matlab]``.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
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
STRUCT = "struct"
CLASSES = {"float64": "double", "float32": "single", "bool": "logical"}
"""MATLAB's classes by NumPy's types, where they are called otherwise."""
MOST_PARTS = 100
"""Columns of a matrix that holds signals, and elements of an array of structures that hold some;
one with more is a picture or a table of another kind."""
MOST_LISTED = 20
"""Variables that a message names."""
MOST_VARIABLES = 10_000
"""Fields of structures in a file; one with more holds something else, or itself."""

_ELEMENT = re.compile(r"\(\d+\)(?=\.)")
"""Index of an element in an array of structures."""


class _Variable(NamedTuple):
    """A variable of a file, or a field of a structure, its values not yet read."""

    name: str
    shape: tuple[int, ...]
    kind: str
    """MATLAB's class."""
    load: Callable[[], NDArray[Any]]
    """Gives its values."""


class _Node(NamedTuple):
    """An array, or a structure, which has fields."""

    shape: tuple[int, ...]
    kind: str
    load: Callable[[], NDArray[Any]]
    fields: Mapping[str, Sequence[Any]] = MappingProxyType({})
    """Of a structure: of each field the nodes of all elements, in MATLAB's order."""


def _unfold(name: str, node: _Node) -> Iterator[_Variable]:
    """A node as variables: itself, or what its fields hold."""
    if not node.fields:
        yield _Variable(name, node.shape, node.kind, cache(node.load))
    for field, elements in node.fields.items():
        inner = f"{name}.{field}"
        if len(elements) == 1:
            yield from _unfold(inner, elements[0])
        elif all(one.kind in NUMERIC and np.prod(one.shape) == 1 for one in elements):
            load = cache(partial(_join, elements))
            yield _Variable(inner, (len(elements), 1), elements[0].kind, load)
        elif len(elements) > MOST_PARTS:
            yield _Variable(inner, node.shape, node.kind, node.load)
        else:
            for place, one in enumerate(elements, start=1):
                yield from _unfold(f"{name}({place}).{field}", one)


def _join(elements: Sequence[_Node]) -> NDArray[Any]:
    return np.array([one.load().reshape(-1)[0] for one in elements], dtype=np.float64)


def _unfold_all(path: Path, nodes: Iterator[tuple[str, _Node]]) -> list[_Variable]:
    """Variables of a file; raises InputError for too many."""
    found = []
    for name, node in nodes:
        for one in _unfold(name, node):
            found.append(one)
            if len(found) > MOST_VARIABLES:
                raise InputError(
                    f"{path}: structures in it have more than {MOST_VARIABLES} fields; "
                    f"{_remedy(path)}"
                )
    return found


def short_names(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Names that fields may also be asked for by, each with the full ones that it may mean.

    ``x`` and, in an array of structures, ``data.x`` stand for ``data(2).x``.
    """
    found: dict[str, dict[str, None]] = {}
    for name in names:
        steps = name.split(".")
        shorter = {".".join(steps[place:]) for place in range(1, len(steps))}
        for one in (*shorter, *(_ELEMENT.sub("", each) for each in (name, *shorter))):
            if one not in names:
                found.setdefault(one, {})[name] = None
    return {short: tuple(full) for short, full in found.items()}


def _name_parts(one: _Variable) -> list[str]:
    """Names of what is read of a variable: of itself, or of a matrix the columns or the rows."""
    if one.kind not in NUMERIC or len(one.shape) != 2 or is_row(one.shape):
        return [one.name]
    rows, columns = one.shape
    if rows == columns or min(one.shape) > MOST_PARTS:
        return [one.name]
    places = range(1, min(one.shape) + 1)
    return [f"{one.name}(:,{at})" if rows > columns else f"{one.name}({at},:)" for at in places]


def _read_part(path: Path, name: str, variables: Sequence[_Variable]) -> NDArray[Any]:
    """Values of a variable, or of a part of it, as `_name_parts` calls it; raises InputError."""
    for one in variables:
        parts = _name_parts(one)
        if name in parts and len(parts) > 1:
            values, place = one.load(), parts.index(name)
            return values[:, place] if one.shape[0] > one.shape[1] else values[place]
    return _check(path, name, variables).load()


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
    listed = [f"{one.name} ({write_shape(one.shape)} {one.kind})" for one in variables]
    more = len(listed) - MOST_LISTED
    return ", ".join(listed[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")


def _names(path: Path, variables: Sequence[_Variable]) -> tuple[str, ...]:
    """Names of all variables. Raises InputError where none is a row of numbers."""
    parts = [_name_parts(one) for one in variables]
    if not any(
        len(names) > 1 or (one.kind in NUMERIC and is_row(one.shape))
        for names, one in zip(parts, variables, strict=True)
    ):
        held = f"holds {_list(variables)}" if variables else "holds no variables"
        raise InputError(f"{path}: {held}, no row or column of numbers; {_remedy(path)}")
    return tuple(name for names in parts for name in names)


def _check(path: Path, name: str, variables: Sequence[_Variable]) -> _Variable:
    """The variable, if it is a row of numbers; raises InputError for any other."""
    one = next(one for one in variables if one.name == name)
    if one.kind not in NUMERIC:
        raise InputError(
            f"{path}: {name!r} is a {one.kind} of {write_shape(one.shape)}, should be a row or "
            f"column of numbers; the file has {_list(variables)}: {_remedy(path)}"
        )
    check_shape(path, name, one.shape)
    return one


def _read(
    path: Path, wanted: Sequence[str], allow_missing: bool, variables: Sequence[_Variable]
) -> dict[str, NDArray[np.float64]]:
    parts = {name: _read_part(path, name, variables) for name in wanted}
    return {name: read_numbers(path, name, row, allow_missing) for name, row in parts.items()}


def _variables_5(path: Path) -> list[_Variable]:
    from scipy.io import loadmat, whosmat

    def nodes() -> Iterator[tuple[str, _Node]]:
        for name, shape, kind in whosmat(path):
            load = cache(lambda name=name: loadmat(path, variable_names=[name])[name])
            yield name, _to_node_5(load()) if kind == STRUCT else _Node(shape, kind, load)

    with _whole(path):
        return _unfold_all(path, nodes())


def _to_node_5(values: Any) -> _Node:
    """A node of what SciPy has read: an array, or a structure as an array of records."""
    from scipy.io.matlab import MatlabFunction, MatlabObject, MatlabOpaque

    if isinstance(values, MatlabFunction | MatlabObject | MatlabOpaque):
        return _Node(values.shape, "object", lambda: values)
    if not isinstance(values, np.ndarray):  # of a sparse matrix
        return _Node(getattr(values, "shape", ()), "sparse matrix", lambda: values)
    if values.dtype.names:
        elements = values.ravel(order="F")
        fields = {
            name: [_to_node_5(one) for one in elements[name]]
            for name in values.dtype.names
            if elements.size
        }
        return _Node(values.shape, STRUCT, lambda: values, fields)
    kinds = {"U": "char", "O": "cell", "c": "complex"}
    kind = kinds.get(values.dtype.kind) or CLASSES.get(values.dtype.name, values.dtype.name)
    return _Node(values.shape, kind, lambda: values)


def read_names(path: Path) -> tuple[str, ...]:
    """Names of the variables. Raises InputError for a damaged file, and one without numbers."""
    return _names(path, _variables_5(path))


def read_columns(
    path: Path, wanted: Sequence[str], allow_missing: bool = False
) -> dict[str, NDArray[np.float64]]:
    """Numbers of the columns that are wanted; see `table.read_columns`."""
    variables = _variables_5(path)
    with _whole(path):
        return _read(path, wanted, allow_missing, variables)


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


def _items_73(group: Any) -> Iterator[tuple[str, Any]]:
    """Members of a group of HDF5, without those that lie in other files."""
    import h5py

    for name in group:
        if name.startswith("#") or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue
        item = group[name]
        if not isinstance(item, h5py.Dataset) or not item.external:
            yield name, item


def _variables_73(path: Path, file: Any) -> list[_Variable]:
    """The variables of an open file."""
    return _unfold_all(path, ((name, _to_node_73(item)) for name, item in _items_73(file)))


def _to_node_73(item: Any) -> _Node:
    """A node of a data set, or of a group, which is a structure."""
    import h5py

    kind = item.attrs.get("MATLAB_class", b"unknown class")
    words = kind.decode() if isinstance(kind, bytes) else str(kind)
    if isinstance(item, h5py.Dataset):
        if item.attrs.get("MATLAB_empty", 0):  # its values are its shape
            return _Node(tuple(map(int, item[()].flat)), words, lambda: np.empty(0))
        # Axes come in reverse.
        return _Node(item.shape[::-1], words, lambda: item[()].T)
    if words != STRUCT:
        return _Node((1, 1), words, lambda: np.empty(0))
    fields, shape = {}, (1, 1)
    for name, field in _items_73(item):
        fields[name] = [field]
        if isinstance(field, h5py.Dataset) and "MATLAB_class" not in field.attrs:
            shape = field.shape[::-1]  # of an array of structures: references to each element's
            fields[name] = [item.file[one] for one in field[()].flat]
    nodes = {name: [_to_node_73(one) for one in found] for name, found in fields.items()}
    return _Node(shape, words, lambda: np.empty(0), nodes)


def read_names_73(path: Path) -> tuple[str, ...]:
    """As `read_names`, of a file of version 7.3."""
    with _open_73(path) as file:
        return _names(path, _variables_73(path, file))


def read_columns_73(
    path: Path, wanted: Sequence[str], allow_missing: bool = False
) -> dict[str, NDArray[np.float64]]:
    """As `read_columns`, of a file of version 7.3."""
    with _open_73(path) as file:
        return _read(path, wanted, allow_missing, _variables_73(path, file))
