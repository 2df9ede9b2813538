"""Verification of the whole trail of the records, in a thread: a long trail takes a while."""

import logging
import threading
from datetime import datetime
from typing import Any

from opensuction.kernel.errors import InputError
from opensuction.records.database import utc_time
from opensuction.records.records import Records

LOG = logging.getLogger("opensuction.console")
FAILED = "the trail could not be read; the console's log says why"


class Verification:
    """The last look at the whole trail, and the one that goes on."""

    def __init__(self, records: Records) -> None:
        self._records = records
        self._lock = threading.Lock()
        self._is_running = False
        self._known: dict[str, Any] | None = None
        self._checked_at: datetime | None = None
        self._failure: str | None = None

    def tell(self) -> dict[str, Any]:
        """Present head of the trail, and the result of the last audit."""
        head = self._records.head()
        with self._lock:
            state = "running" if self._is_running else "none" if self._known is None else "done"
            if state == "none" and self._failure is not None:
                state = "failed"
            return {
                "state": state,
                "entries": head.sequence,
                "head": head.hash,
                "checked_at": self._checked_at,
                "verdict": self._known,
                "failure": self._failure,
            }

    def begin(self, expected: str | None) -> None:
        """Read the whole trail, unless that goes on already. expected: the hash of a head."""
        with self._lock:
            if self._is_running:
                return
            self._is_running = True
        threading.Thread(target=self._read_trail, args=(expected,), daemon=True).start()

    def _read_trail(self, expected: str | None) -> None:
        known: dict[str, Any] | None = None
        failure: str | None = FAILED
        try:
            found = self._records.audit(expected)
            known = {**found._asdict(), "is_whole": found.broken is None, "expected": expected}
            failure = None
        except InputError as error:
            failure = str(error)
        except Exception:
            LOG.exception("reading the trail failed")
        finally:
            with self._lock:
                self._is_running = False
                self._known, self._failure = known, failure
                self._checked_at = utc_time.now()
