"""Control software and digital twin for automated tracheal suctioning.

Research software: not a medical device, not for use on people or animals. Every performance
claim is in-silico.
"""

from importlib import import_module
from typing import Any

__version__ = "0.3.0"

_MODULES = {
    "Commands": "kernel.interface",
    "Comparison": "library.workbench",
    "Configuration": "controller.configuration",
    "Controller": "runtime.embedded_controller",
    "Fit": "library.fit",
    "IDLE": "twin.machine.fail_safe",
    "InputError": "kernel.errors",
    "Leaderboard": "library.leaderboard",
    "Monitor": "kernel.interface",
    "NO_MONITOR": "kernel.interface",
    "NO_REQUESTS": "kernel.interface",
    "Readings": "kernel.interface",
    "Requests": "kernel.interface",
    "Run": "library.run",
    "TrialRun": "library.trial_run",
    "Twin": "library.twin",
    "compare": "library.workbench",
    "controller_settings": "session.embedding",
    "cycle": "library.run",
    "identify": "library.workbench",
    "leaderboard": "library.leaderboard",
    "load": "library.fit",
    "read": "library.columns",
    "trial": "library.trial_run",
}
"""Where each name is; `__init__.pyi` tells type checkers the same. A name is loaded when it is
asked for: help and completion need none of them."""

_ROOMS = ("hysteresis",)
"""Rooms that are used by their own names."""

__all__ = ["__version__", *_MODULES, *_ROOMS]  # noqa: PLE0604 - all of them are names


def __getattr__(name: str) -> Any:
    if name in _ROOMS:
        return import_module(f"opensuction.{name}")
    if name not in _MODULES:
        raise AttributeError(f"module 'opensuction' has no attribute {name!r}")
    return getattr(import_module(f"opensuction.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
