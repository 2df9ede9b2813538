"""One threshold of the controller, and what it must bear."""

import importlib
import operator
from collections.abc import Callable
from enum import Enum
from typing import NamedTuple

from docs.generator.safety.tolerance import noise
from docs.generator.safety.tolerance.noise import Filter
from docs.generator.safety.tolerance.sensor_error import Errors, largest, worst
from opensuction.twin.fault.fault import Fault

Constant = tuple[str, str]
"""Module below `opensuction`, and its name there."""


class Chance(Enum):
    """How what is random comes."""

    FILTERED = "filtered white noise"
    EVEN = "even noise within 1.7 sigma"
    LATE = "messages that are late, each by chance"
    NONE = "nothing random"


class Borne(NamedTuple):
    """What a sound machine does towards a threshold."""

    static: float
    """All that does not change from tick to tick, in the worst way at once."""
    sigma: float
    """RMS of what does, where it is compared."""


class Threshold(NamedTuple):
    """One threshold. Lengths and times in the units of the code."""

    constants: tuple[Constant, ...]
    """It, and how long it must hold."""
    compared: str
    unit: str
    margin: float
    """From what an ideal machine shows to where it trips."""
    bear: Callable[[Errors], Borne]
    because: str
    """What the static error is made of."""
    errors: tuple[str, ...]
    """Sensor parameters that reach it."""
    chance: Chance
    behind: Filter
    ticks: int
    """In a row that are needed, of `EVEN` and `LATE`."""
    faults: tuple[Fault, ...]
    takes_s: float
    """To trip, once it is there: hold time and filters."""
    simulated: str = ""
    """Name of the hour in the measurements."""


def value_of(constant: Constant) -> float:
    """Value of a constant. Raises AttributeError for one that does not exist."""
    module = importlib.import_module(f"opensuction.{constant[0]}")
    return float(operator.attrgetter(constant[1])(module))


class Distance(NamedTuple):
    """How far a threshold is from a sound machine."""

    borne: Borne
    left: float
    """Margin less the static error."""
    sigmas: float
    per_h: float
    """False trips an hour, at most."""


def stand(threshold: Threshold, errors: Errors) -> Distance:
    """How far it is, of a machine with these errors."""
    borne = threshold.bear(errors)
    left = threshold.margin - borne.static
    sigmas = left / borne.sigma if borne.sigma > 0.0 else float("inf") * (1 if left > 0.0 else -1)
    return Distance(borne, left, sigmas, _rate_per_h(threshold, sigmas, errors))


def _rate_per_h(threshold: Threshold, sigmas: float, errors: Errors) -> float:
    if threshold.chance == Chance.FILTERED:
        return noise.crossings_per_h(threshold.behind.likeness, sigmas)
    if threshold.chance == Chance.EVEN:
        return noise.runs_per_h(noise.even_beyond(sigmas), threshold.ticks)
    if threshold.chance == Chance.LATE:
        return noise.runs_per_h(errors["late_share"], threshold.ticks)
    return 0.0 if sigmas > 0.0 else float("inf")


def stand_worst(threshold: Threshold) -> Distance:
    """How far it is in the worst machine that is drawn."""
    return stand(threshold, worst())


def stand_largest(threshold: Threshold) -> tuple[str, Distance]:
    """The error that brings a file nearest to it, alone at its largest, and how far it is then."""
    found = {name: stand(threshold, largest(name)) for name in threshold.errors}
    nearest = min(found, key=lambda name: (found[name].sigmas, -found[name].per_h))
    return nearest, found[nearest]
