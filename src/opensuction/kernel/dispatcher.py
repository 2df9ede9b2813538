"""One core function, compiled apart for the two who call it: Python and compiled code.

A function that Python can call needs a wrapper which takes every record apart and puts it together
again, field by field. With records of some 300 numbers that wrapper is more machine code than the
function itself, and nearly all core functions are called by compiled code alone. So the wrapper is
compiled only for those that Python really calls.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import config
from numba.core.registry import CPUDispatcher

CACHE_SETTING = "CACHE_DIR"
"""Numba's setting; changed only while a dispatcher is made, so other users keep theirs."""

OPTIONS: dict[str, bool] = {
    "nopython": True,
    "nogil": True,
    "boundscheck": True,
    "forceinline": True,
    "no_cfunc_wrapper": True,
}
"""For every core function: see `compiled.compiled`."""


def _cached(dispatcher: CPUDispatcher, folder: Path) -> None:
    """Keep its machine code in ``folder``."""
    folder.mkdir(exist_ok=True)
    previous = getattr(config, CACHE_SETTING)
    setattr(config, CACHE_SETTING, str(folder))
    try:
        dispatcher.enable_caching()
    finally:
        setattr(config, CACHE_SETTING, previous)


class Inner(CPUDispatcher):
    """A function as compiled code calls it; Python must not: there is no wrapper to call."""

    def __call__(self, *_: object, **__: object) -> object:
        """Refuse: a call without its wrapper would be the end of the process."""
        raise TypeError(f"{self.py_func.__name__} is compiled for compiled callers only")


class Outer(CPUDispatcher):
    """A function as Python calls it. To compiled callers it hands out its inner one."""

    def keep(self, folder: Path) -> None:
        """Keep machine code in ``folder``; both kinds have the same key, so apart.

        Private functions are not kept: whoever calls them is.
        """
        _cached(self, folder)
        if not self.py_func.__name__.startswith("_"):
            self.inner_folder = folder / "inner"

    inner_folder: Path | None = None

    @property
    def inner(self) -> Any:
        """The `Inner` one; made when the first compiled caller asks."""
        found = self.__dict__.get("_inner")
        if found is None:
            options = {**self.targetoptions, "no_cpython_wrapper": True}
            found = Inner(self.py_func, self.locals, options)
            if self.inner_folder is not None:
                _cached(found, self.inner_folder)
            self.__dict__["_inner"] = found
        return found

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """What numba's type inference learns of a call of this function."""
        return self.inner.get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        """What numba's lowering calls."""
        return self.inner.get_overload(sig)


def made(function: Callable[..., object], folder: Path) -> Outer:
    """A dispatcher of a core function that keeps its machine code in ``folder``."""
    dispatcher = Outer(function, {}, dict(OPTIONS, error_model="python"))
    dispatcher.keep(folder)
    return dispatcher
