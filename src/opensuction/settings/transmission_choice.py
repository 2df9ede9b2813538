"""A transmission by the name of its class."""

from opensuction.settings import conduit_file
from opensuction.settings.choice import choose
from opensuction.twin.conduit import transmission_class
from opensuction.twin.conduit.transmission_class import TransmissionClass

BUILT = {
    one.name: one
    for one in (
        transmission_class.PLAYS,
        transmission_class.BOUC_WEN,
        transmission_class.RUBBING,
    )
}
"""Classes that the machine's parameters describe whole."""
NAMES = (*BUILT, *conduit_file.NAMES)
MACHINES = {f"bench-{name}": name for name in NAMES if name != transmission_class.PLAYS.name}
"""Machines by name that are the bench with a transmission of another class."""


def find(name: object) -> TransmissionClass:
    """A class by name; raises InputError with the nearest for one that is not known."""
    known = choose(name, {one: one for one in NAMES}, "transmission")
    return BUILT[known] if known in BUILT else conduit_file.smoothed(known)[0]
