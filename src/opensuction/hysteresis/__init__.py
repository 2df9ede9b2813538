"""Hysteresis models between the catheter's head and its tip, one model a file.

``opensuction.hysteresis.model("play", width_mm=2.0, gain=1.0, offset_mm=0.0)`` is one with its
numbers; ``CATALOGUE`` lists them. ``HystereticOscillator`` has a mass, too: force in, displacement
out. Each is loaded when it is asked for: the core's own modules need none.
"""

from importlib import import_module
from typing import Any

_MODULES = {
    "CATALOGUE": "catalogue.catalogue",
    "HystereticOscillator": "oscillator.motion",
    "Model": "named_model",
    "OscillatorFit": "oscillator.output_error",
    "fit_oscillator": "oscillator.output_error",
    "model": "named_model",
}
"""Where each name is; `__init__.pyi` tells type checkers the same."""

__all__ = [
    "CATALOGUE",
    "HystereticOscillator",
    "Model",
    "OscillatorFit",
    "fit_oscillator",
    "model",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'opensuction.hysteresis' has no attribute {name!r}")
    return getattr(import_module(f"opensuction.hysteresis.{_MODULES[name]}"), name)
