"""Buttons act when they are pressed, not as long as they are held."""

from opensuction.kernel.compiled import compiled
from opensuction.kernel.requests import Requests


@compiled
def press_once(now: Requests, before: Requests) -> Requests:
    """The buttons that were pressed in this tick; an abort also while it is held.

    before: the buttons of the last tick. A button that sticks, or a thumb that stays on it, asks
    for one cycle, one reset, one answer.
    """
    return Requests(
        start=now.start and not before.start,
        identify=now.identify and not before.identify,
        abort=now.abort,
        reset=now.reset and not before.reset,
        teach=now.teach and not before.teach,
        confirm=now.confirm and not before.confirm,
        home=now.home and not before.home,
        service=now.service and not before.service,
        changed=now.changed and not before.changed,
        return_to_service=now.return_to_service and not before.return_to_service,
        not_needed=now.not_needed and not before.not_needed,
        acknowledge=now.acknowledge and not before.acknowledge,
        audio_pause=now.audio_pause and not before.audio_pause,
        assessed=now.assessed and not before.assessed,
        oxygenated=now.oxygenated and not before.oxygenated,
        oxygen_skipped=now.oxygen_skipped and not before.oxygen_skipped,
    )
