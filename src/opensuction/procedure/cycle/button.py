"""Buttons act when they are pressed, not as long as they are held."""

from opensuction.kernel.arithmetic import flag
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Requests

NONE = 0
"""No button is held."""
FIELDS = Requests._fields
(
    START,
    IDENTIFY,
    ABORT,
    RESET,
    TEACH,
    CONFIRM,
    HOME,
    SERVICE,
    CHANGED,
    RETURN_TO_SERVICE,
    NOT_NEEDED,
    ACKNOWLEDGE,
    AUDIO_PAUSE,
    ASSESSED,
    OXYGENATED,
    OXYGEN_SKIPPED,
) = range(len(Requests._fields))
"""Bits of the buttons, in the order of `Requests`."""


@compiled
def hold(now: Requests) -> int:
    """Mask of the buttons that are down in this tick."""
    return (
        flag(now.start, START)
        | flag(now.identify, IDENTIFY)
        | flag(now.abort, ABORT)
        | flag(now.reset, RESET)
        | flag(now.teach, TEACH)
        | flag(now.confirm, CONFIRM)
        | flag(now.home, HOME)
        | flag(now.service, SERVICE)
        | flag(now.changed, CHANGED)
        | flag(now.return_to_service, RETURN_TO_SERVICE)
        | flag(now.not_needed, NOT_NEEDED)
        | flag(now.acknowledge, ACKNOWLEDGE)
        | flag(now.audio_pause, AUDIO_PAUSE)
        | flag(now.assessed, ASSESSED)
        | flag(now.oxygenated, OXYGENATED)
        | flag(now.oxygen_skipped, OXYGEN_SKIPPED)
    )


@compiled
def _is_new(down: bool, held: int, bit: int) -> bool:
    return down and held >> bit & 1 == 0


@compiled
def press_once(now: Requests, held: int) -> Requests:
    """The buttons that were pressed in this tick; an abort also while it is held.

    held: mask of those that were down in the last tick. A button that sticks, or a thumb that stays
    on it, asks for one cycle, one reset, one answer.
    """
    if held == NONE:
        return now
    return Requests(
        start=_is_new(now.start, held, START),
        identify=_is_new(now.identify, held, IDENTIFY),
        abort=now.abort,
        reset=_is_new(now.reset, held, RESET),
        teach=_is_new(now.teach, held, TEACH),
        confirm=_is_new(now.confirm, held, CONFIRM),
        home=_is_new(now.home, held, HOME),
        service=_is_new(now.service, held, SERVICE),
        changed=_is_new(now.changed, held, CHANGED),
        return_to_service=_is_new(now.return_to_service, held, RETURN_TO_SERVICE),
        not_needed=_is_new(now.not_needed, held, NOT_NEEDED),
        acknowledge=_is_new(now.acknowledge, held, ACKNOWLEDGE),
        audio_pause=_is_new(now.audio_pause, held, AUDIO_PAUSE),
        assessed=_is_new(now.assessed, held, ASSESSED),
        oxygenated=_is_new(now.oxygenated, held, OXYGENATED),
        oxygen_skipped=_is_new(now.oxygen_skipped, held, OXYGEN_SKIPPED),
    )
