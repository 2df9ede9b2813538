"""What people ask of the controller, and what its host says about itself."""

from typing import NamedTuple


class Requests(NamedTuple):
    """Buttons of one tick; each is true in the tick in which it was pressed."""

    start: bool
    """Begin a cycle (PARKED only)."""
    identify: bool
    """Bench: run the identification excitation (PARKED only)."""
    abort: bool
    """Stop and come out, whatever is going on."""
    reset: bool
    """Leave HALTED after the cause has been dealt with."""


class Host(NamedTuple):
    """What the process around the core reports of itself."""

    overrun: bool
    """The previous tick ended after its deadline."""


NO_REQUESTS = Requests(start=False, identify=False, abort=False, reset=False)
START = Requests(start=True, identify=False, abort=False, reset=False)
IDENTIFY = Requests(start=False, identify=True, abort=False, reset=False)
ABORT = Requests(start=False, identify=False, abort=True, reset=False)
RESET = Requests(start=False, identify=False, abort=False, reset=True)
HEALTHY_HOST = Host(overrun=False)
