"""Buttons act when they are pressed, not as long as they are held."""

from opensuction.kernel.compiled import compiled
from opensuction.kernel.requests import Requests


@compiled
def _is_new(now: bool, before: bool) -> bool:
    return now and not before


@compiled
def press_once(now: Requests, before: Requests) -> Requests:
    """The buttons that were pressed in this tick; an abort also while it is held.

    before: the buttons of the last tick. A button that sticks, or a thumb that stays on it, asks
    for one cycle, one reset, one answer.
    """
    return Requests(
        start=_is_new(now.start, before.start),
        identify=_is_new(now.identify, before.identify),
        abort=now.abort,
        reset=_is_new(now.reset, before.reset),
        teach=_is_new(now.teach, before.teach),
        confirm=_is_new(now.confirm, before.confirm),
        home=_is_new(now.home, before.home),
        service=_is_new(now.service, before.service),
        changed=_is_new(now.changed, before.changed),
        return_to_service=_is_new(now.return_to_service, before.return_to_service),
        not_needed=_is_new(now.not_needed, before.not_needed),
        acknowledge=_is_new(now.acknowledge, before.acknowledge),
        audio_pause=_is_new(now.audio_pause, before.audio_pause),
        assessed=_is_new(now.assessed, before.assessed),
        oxygenated=_is_new(now.oxygenated, before.oxygenated),
        oxygen_skipped=_is_new(now.oxygen_skipped, before.oxygen_skipped),
    )
