"""The only place that flattens a record to columns.

Trace, recorder, replay and plots name a column by the dotted path of its field. The writer of a
record type is generated once as straight-line code: no loop over fields survives compilation.
"""

import keyword
from collections.abc import Callable
from typing import Any, get_type_hints

import numpy as np
import numpy.typing as npt

from opensuction.kernel.compiled import compiled_generated

Row = npt.NDArray[np.float64]
SCALARS = (float, int, bool)


def columns(record_type: type) -> tuple[str, ...]:
    """Dotted paths of every scalar in a record type, in order; arrays are left out.

    record_type: a NamedTuple whose fields are scalars, arrays or NamedTuples of these.
    Raises TypeError for a field of any other type.
    """
    names: list[str] = []
    for name, kind in get_type_hints(record_type).items():
        if keyword.iskeyword(name):
            raise TypeError(f"{record_type.__name__}.{name} is a keyword")
        if kind in SCALARS:
            names.append(name)
        elif hasattr(kind, "_fields"):
            names.extend(f"{name}.{inner}" for inner in columns(kind))
        elif getattr(kind, "__origin__", None) is not np.ndarray:
            raise TypeError(f"{record_type.__name__}.{name} is {kind}: not a scalar, array, record")
    return tuple(names)


def writer(record_type: type) -> Callable[[Row, Any], None]:
    """Compiled ``write(row, record)`` that puts every scalar of a record into its column.

    row: array of at least ``len(columns(record_type))`` numbers.
    """
    names = columns(record_type)
    lines = [
        "def write(row, record):",
        f"    if row.size < {len(names)}:",
        f"        raise IndexError('a row of {record_type.__name__} has {len(names)} columns')",
        *(f"    row[{i}] = record.{name}" for i, name in enumerate(names)),
    ]
    source = "\n".join(lines) + "\n"
    scope: dict[str, Any] = {}
    exec(compile(source, f"<row of {record_type.__name__}>", "exec"), scope)  # noqa: S102
    write: Callable[[Row, Any], None] = compiled_generated(scope["write"])
    return write
