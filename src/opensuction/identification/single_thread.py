"""One thread for the linear algebra of a fit.

A fit solves thousands of problems of some hundred unknowns. The linear-algebra library shares each
of them among as many threads as there are cores, and all wait for the last: on a quiet machine
that gains nothing, beside another busy process it costs several times the fit itself.

NumPy has such a library and SciPy one of its own. SciPy is loaded by the fits that need it alone,
for that takes as long as all else of a fit: by `load`, which limits its library too.
"""

import functools
import sys
from collections.abc import Callable
from contextlib import ExitStack
from importlib import import_module
from typing import Any, ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

Given = ParamSpec("Given")
Result = TypeVar("Result")

OWN_LIBRARY = "scipy.linalg"
"""Brings SciPy's library with it, whichever part of SciPy asks for it."""

_limited: list[ExitStack] = []
"""Limits of the calls that run, the outermost first: it ends last."""


@functools.cache
def _controller(with_scipy: bool) -> ThreadpoolController:
    """The libraries that are loaded; they are looked for once, and once more with SciPy's."""
    del with_scipy
    return ThreadpoolController()


def _limit(limits: ExitStack) -> None:
    controller = _controller(OWN_LIBRARY in sys.modules)
    limits.enter_context(controller.limit(limits=1, user_api="blas"))


def single_threaded(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """A function whose linear algebra runs in one thread; afterwards it is as it was before."""

    @functools.wraps(function)
    def limited(*args: Given.args, **named: Given.kwargs) -> Result:
        with ExitStack() as limits:
            _limit(limits)
            _limited.append(limits)
            limits.callback(_limited.remove, limits)
            return function(*args, **named)

    return limited


def load(name: str) -> Any:
    """A module of SciPy, loaded when it is first asked for; within a fit it has one thread too."""
    was_there = OWN_LIBRARY in sys.modules
    module = import_module(name)
    if not was_there and OWN_LIBRARY in sys.modules:
        for limits in _limited[:1]:
            _limit(limits)
    return module
