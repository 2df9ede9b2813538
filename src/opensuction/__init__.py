"""Control software and digital twin for automated tracheal suctioning.

Research software: not a medical device, not for use on people or animals. Every performance
claim is in-silico.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_MODULES = {
    "Configuration": "controller.configuration",
    "Controller": "runtime.embedded_controller",
    "InputError": "kernel.errors",
    "Monitor": "kernel.readings",
    "NO_MONITOR": "kernel.readings",
    "NO_REQUESTS": "kernel.requests",
    "Readings": "kernel.readings",
    "Requests": "kernel.requests",
    "controller_settings": "session.embedding",
}
"""Where each name is; `__init__.pyi` tells type checkers the same. A name is loaded when it is
asked for: help and completion need none of them."""

__all__ = ["__version__", *_MODULES]  # noqa: PLE0604 - all of them are names


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'opensuction' has no attribute {name!r}")
    return getattr(import_module(f"opensuction.{_MODULES[name]}"), name)
