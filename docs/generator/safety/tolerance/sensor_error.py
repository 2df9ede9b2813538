"""Largest error of each machine parameter: in the worst machine drawn, and in a parameter file."""

from opensuction.twin.parameter import CLINICAL, SENSORS, SPREAD_LIMIT

Errors = dict[str, float]
"""Distance of each parameter of `SENSORS` from a sensor without error."""
IDEAL = {"vacuum_gain": 1.0, "current_gain": 1.0}
"""What has no error, where that is not 0."""


def worst() -> Errors:
    """In the worst machine that a seed draws: nominal, and 2.5 standard deviations."""
    return {
        name: row.value - IDEAL.get(name, 0.0) + SPREAD_LIMIT * row.spread
        for name, row in SENSORS.items()
    }


def largest(name: str) -> Errors:
    """With one of them as large as a file may set it, and the others as in the worst machine."""
    return worst() | {name: SENSORS[name].high - IDEAL.get(name, 0.0)}


def spread(name: str) -> float:
    """How far a part of the bedside machine is from its nominal value at most."""
    return SPREAD_LIMIT * CLINICAL[name].spread


def most(name: str) -> float:
    """Largest value of a part of the bedside machine that is drawn."""
    return CLINICAL[name].value + spread(name)


def least(name: str) -> float:
    """Smallest value of a part of the bedside machine that is drawn."""
    return CLINICAL[name].value - spread(name)
