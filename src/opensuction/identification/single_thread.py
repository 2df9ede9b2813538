"""One thread for the linear algebra of a fit.

A fit solves thousands of problems of some hundred unknowns. The linear-algebra library shares each
of them among as many threads as there are cores, and all wait for the last: on a quiet machine
that gains nothing, beside another busy process it costs several times the fit itself.
"""

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

Given = ParamSpec("Given")
Result = TypeVar("Result")


@functools.cache
def _controller() -> ThreadpoolController:
    """The libraries that are loaded; they are looked for once."""
    import scipy.linalg  # noqa: F401 - brings its own, which must be there to be found

    return ThreadpoolController()


def single_threaded(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """A function whose linear algebra runs in one thread; afterwards it is as it was before."""

    @functools.wraps(function)
    def limited(*args: Given.args, **named: Given.kwargs) -> Result:
        with _controller().limit(limits=1, user_api="blas"):
            return function(*args, **named)

    return limited
