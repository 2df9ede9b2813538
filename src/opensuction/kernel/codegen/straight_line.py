"""Functions that a loop writes out as straight-line code, for the compiled core.

Compiled code builds a tuple only of elements that are written out, and a tuple indexed by a
variable is kept in memory as a whole: what is done for each element of a tuple, or for each field
of a record, is therefore written out here, by whoever knows the elements.
"""

from collections.abc import Iterable
from typing import Any

from opensuction.kernel.compiled import compiled_generated


def define(lines: Iterable[str], about: str, **scope: Any) -> Any:
    """The function that some lines of source define, compiled into whoever calls it.

    lines: of one ``def``. about: names the source in messages. scope: what the lines refer to.
    """
    names: dict[str, Any] = dict(scope)
    known = set(names)
    exec(compile("\n".join(lines) + "\n", f"<{about}>", "exec"), names)  # noqa: S102
    (name,) = set(names) - known - {"__builtins__"}
    return compiled_generated(names[name])


def chooser(count: int) -> Any:
    """``choose(values, index)``: one of so many numbers of a tuple, index from 0 to below count.

    A chain of comparisons: a tuple that is indexed by a variable is kept in memory as a whole.
    """
    lines = ["def choose(values, index):", "    value = values[0]"]
    lines += [f"    value = values[{i}] if index == {i} else value" for i in range(1, count)]
    return define([*lines, "    return value"], "one of some numbers")


def tuple_of(elements: Iterable[str]) -> str:
    """Source of a tuple of these elements."""
    return f"({', '.join(elements)},)"
