"""A log that nobody can flood: so many lines, then one that says how many were left out."""

import logging
import threading

from opensuction.console.guard.bucket import Buckets

RATE_HZ, MOST = 5.0, 100.0


class Throttle(logging.Filter):
    """Of a handler."""

    def __init__(self, buckets: Buckets | None = None) -> None:
        super().__init__()
        self._buckets = buckets or Buckets(RATE_HZ, MOST)
        self._left_out = 0
        self._lock = threading.Lock()

    def filter(self, record: logging.LogRecord) -> bool:
        """See `logging.Filter`."""
        with self._lock:
            if self._buckets.take("line"):
                self._left_out += 1
                return False
            if self._left_out:
                record.msg = f"{record.getMessage()} ({self._left_out} lines before it left out)"
                record.args = ()
                self._left_out = 0
            return True
