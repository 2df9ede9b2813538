"""People's requests to the controller, and the reports of its host process."""

from typing import NamedTuple

from opensuction.kernel.record import make_zero


class Requests(NamedTuple):
    """Buttons of one tick; each is true as long as it is pressed.

    It acts once (`opensuction.procedure.cycle.button`); only `abort` acts as long as it is held.
    """

    start: bool
    """Begin a cycle (PARKED only)."""
    identify: bool
    """Bench: run the identification excitation (PARKED only)."""
    abort: bool
    """Stop and come out, whatever is going on."""
    reset: bool
    """Leave HALTED after the cause has been dealt with; clear alarms that have ended."""
    teach: bool
    """Let a person move the catheter (PARKED only)."""
    confirm: bool
    """Teaching: the tip is at the carina."""
    home: bool
    """Teaching: the drive shall bring the head home."""
    service: bool
    """Everything off for catheter change or cleaning (PARKED, or HALTED with the head home; locked
    out, wherever it is)."""
    changed: bool
    """Out of service: the catheter is a new one."""
    return_to_service: bool
    """Out of service: hands are off, the machine may be used."""
    not_needed: bool
    """The assessment that was due found nothing to suction."""
    acknowledge: bool
    """Alarms: silence what is shown now."""
    audio_pause: bool
    """Alarms: begin an audio pause, or end the one that runs."""
    assessed: bool
    """A person has looked at the patient: passes are counted anew (at rest only)."""
    oxygenated: bool
    """The pre-oxygenation that was asked for has been given (PARKED only)."""
    oxygen_skipped: bool
    """A person decides to go without it; takes nothing back that was confirmed (PARKED only)."""


STOP = "abort"
"""The button that stops: it acts as long as it is held, and waits for nothing."""


class Host(NamedTuple):
    """Reports of the process around the core on itself."""

    overrun: bool
    """The previous tick ended after its deadline."""
    conditions: int
    """What only the host can see, as a mask of alarm conditions (`condition_mask`): a late
    message, a recorder or console that is lost, reserve energy in use. It can only add alarms."""


NO_REQUESTS = make_zero(Requests)
START = NO_REQUESTS._replace(start=True, oxygen_skipped=True)
"""Begin at once: the pre-oxygenation that a patient needs is skipped, on record, unless it has been
confirmed before."""
IDENTIFY = NO_REQUESTS._replace(identify=True)
ABORT = NO_REQUESTS._replace(abort=True)
RESET = NO_REQUESTS._replace(reset=True)
TEACH = NO_REQUESTS._replace(teach=True)
CONFIRM = NO_REQUESTS._replace(confirm=True)
HOME = NO_REQUESTS._replace(home=True)
SERVICE = NO_REQUESTS._replace(service=True)
CHANGED = NO_REQUESTS._replace(changed=True)
RETURN_TO_SERVICE = NO_REQUESTS._replace(return_to_service=True)
ASSESSED = NO_REQUESTS._replace(assessed=True)
OXYGENATED = NO_REQUESTS._replace(oxygenated=True)
OXYGEN_SKIPPED = NO_REQUESTS._replace(oxygen_skipped=True)
