"""The annunciator at the bedside: what people are told, with the controller and without it.

A device with a battery of its own. It shows what the controller's last message wants shown, and
three lines reach it that need no controller: of the drives' watchdog, of their receiver, and of the
power supply. The watchdog's line and the supply's are closed while all is well: without energy they
open, and that is a sign too. What the controller wants shown is an opaque number here; which
condition each line means is `opensuction.simulation.annunciation`.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero

LATE_S = 0.005
"""[design] A command that is older than this is late: a quarter of the watchdog's 20 ms, so that it
is told before the drives act. The head moves 0.3 mm in it at 60 mm/s, the fastest. Jitter of some
ticks is not told, and of a bus that loses each tenth message six in a row are lost once in 1,000 s
[computed]."""


class Annunciator(NamedTuple):
    """Display at the bedside in a tick."""

    said: int
    """Mask of conditions in the controller's last message; it stays while the controller is
    silent."""
    watchdog_fired: bool
    """The drives have acted on their own. It stays until a person resets a controller that runs."""
    reserve_used: bool
    """There is no mains power: the drives have their reserve energy, or nothing."""
    message_late: bool
    """The drives' commands have come late, or not at all. It stays as the watchdog's sign does."""


class Lines(NamedTuple):
    """Lines into the annunciator in a tick."""

    heard: bool
    """A new message of the controller has come."""
    wanted: int
    """What that message wants shown."""
    reset: bool
    """A person resets what has ended, at a controller that runs."""
    alone: bool
    """The drives act on their own, or have no energy."""
    mains: bool
    lag_s: float
    """Age of the command that the drives obey."""


DARK = make_zero(Annunciator)
"""Nothing has been shown yet."""


@compiled
def step(state: Annunciator, lines: Lines, dt_s: float) -> Annunciator:
    """Advance by one tick."""
    kept = not lines.reset
    # Half a tick forgives a time that is a number of ticks. Drives that act alone obey none.
    late = not lines.alone and lines.lag_s > LATE_S + 0.5 * dt_s
    return Annunciator(
        said=lines.wanted if lines.heard else state.said,
        watchdog_fired=lines.alone or (state.watchdog_fired and kept),
        reserve_used=not lines.mains,
        message_late=late or (state.message_late and kept),
    )


@compiled
def repeat(wanted: int) -> Annunciator:
    """Display where the link is sound: the controller's conditions, and no sign of a line."""
    return Annunciator(said=wanted, watchdog_fired=False, reserve_used=False, message_late=False)
