"""Record of refusals by role: person and attempt, rate-limited so that a flood does not fill it."""

import logging

from opensuction.console.guard.bucket import Buckets
from opensuction.kernel.errors import InputError
from opensuction.records.entry import Action
from opensuction.records.records import Records

EVERY_S = 10.0
"""The same person's same try is put on record at most so often,"""
ALL_HZ, ALL_MOST = 0.1, 30.0
"""and all of them together so often, and so many at once."""
LOG = logging.getLogger("opensuction.console")
WHAT = "refused"


class DeniedAccessLog:
    """Of one console."""

    def __init__(self, records: Records) -> None:
        self._records = records
        self._own = Buckets(1.0 / EVERY_S, 1.0)
        self._all = Buckets(ALL_HZ, ALL_MOST)

    def note(self, who: str | None, what: str, why: str) -> None:
        """Somebody tried what the role does not allow. who: None of somebody unknown."""
        name = who or "somebody"
        LOG.warning("refused: %s asks for %s: %s", name, what, why)
        if self._own.take(f"{name} {what}") or self._all.take("all"):
            return
        try:
            self._records.act(Action(name, WHAT, f"{what}: {why}"))
        except InputError as error:  # whoever asked is refused all the same
            LOG.error("a refusal was not put on record: %s", error)
