"""Core functions that a test calls tick by tick.

Numba looks through every number of the records that it is handed to find out their types. Settled
at the first call, a tick takes a third of the time.
"""

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

from opensuction.kernel.compiler.dispatcher import TypedCall

Given = ParamSpec("Given")
Result = TypeVar("Result")


def settled(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """The same function, its types settled by what it declares; arguments by place only.

    All calls must be alike in what a declaration leaves open, as the length of a tuple.
    """
    return cast(Callable[Given, Result], TypedCall(function, lambda *_: 0))
