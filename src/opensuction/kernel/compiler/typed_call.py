"""Calls by Python whose arguments are always of a few known kinds.

At every call numba asks each number of every record for its type: with records of some 300 numbers
that takes two thirds of the call, .1 ms, as long as 200 ticks. A typed call asks once a kind.
The types are those that the records declare: a whole number in a field of floats is taken as the
float that it stands for, instead of compiling everything anew.
"""

# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call, attr-defined, index"

from collections.abc import Callable, Hashable
from typing import Any, Generic, TypeVar, cast, get_args, get_type_hints

import numba
from numba.core import types

from opensuction.kernel.compiler.dispatcher import CoreFunction

Result = TypeVar("Result")
SCALARS = {float: types.float64, int: types.int64, bool: types.boolean}


def declared(hint: Any, found: Any) -> Any:
    """The type in machine code of what is declared as ``hint``.

    found: numba's type of an example; it decides where the declaration leaves a choice.
    """
    if hint in SCALARS:
        return SCALARS[hint]
    if isinstance(found, types.BaseNamedTuple):
        hints = get_type_hints(found.instance_class)
        inner = [declared(hints[name], found[i]) for i, name in enumerate(found.fields)]
        return types.BaseTuple.from_types(inner, found.instance_class)
    if isinstance(found, types.BaseTuple):
        inners = get_args(hint)
        if inners[-1] is Ellipsis:
            inners = inners[:1] * len(found)
        return types.Tuple.from_types([declared(one, found[i]) for i, one in enumerate(inners)])
    return found


class TypedCall(Generic[Result]):
    """One core function, as Python calls it often; whoever holds it declares the arguments."""

    def __init__(self, function: Callable[..., Result], kind: Callable[..., Hashable]) -> None:
        """kind: tells apart what the classes of the arguments leave open, as a union in a record.

        It takes the arguments.
        """
        self._function, self._kind = function, kind
        self._known: dict[Hashable, Callable[..., Result]] = {}

    def __call__(self, *arguments: Any) -> Result:
        """Call it."""
        return self.find(arguments)(*arguments)

    def find(self, arguments: tuple[Any, ...]) -> Callable[..., Result]:
        """Machine code for arguments of these kinds.

        Whoever calls it again and again, and with no others, need not have it looked up each time.
        """
        kind = (self._kind(*arguments), *map(type, arguments))
        code = self._known.get(kind)
        if code is None:
            code = self._known[kind] = self._resolve(arguments)
        return code

    def _resolve(self, arguments: tuple[Any, ...]) -> Callable[..., Result]:
        """Machine code for arguments of these kinds; the function itself where all is Python."""
        if not isinstance(self._function, CoreFunction):
            return self._function
        hints = get_type_hints(self._function.py_func).values()
        taken = tuple(
            declared(hint, numba.typeof(one)) for hint, one in zip(hints, arguments, strict=False)
        )
        return cast(Callable[..., Result], self._function.compile(taken))
