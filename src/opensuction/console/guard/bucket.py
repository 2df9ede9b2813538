"""Token buckets for rate limits: one for each name, refilled at a constant rate."""

import threading
import time
from collections import OrderedDict
from collections.abc import Callable

KEPT = 4096
"""Buckets that are remembered; one that was not used for long is full again anyway."""


class Buckets:
    """One bucket for each name. May be asked by several threads."""

    def __init__(
        self, rate_hz: float, most: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """rate_hz: how fast each fills. most: what it holds when it is full."""
        self.rate_hz, self.most, self._clock = rate_hz, most, clock
        self._lock = threading.Lock()
        self._kept: OrderedDict[str, tuple[float, float]] = OrderedDict()

    def take(self, name: str) -> float:
        """Take a token. Returns 0, or how long to wait, in s, where there is none."""
        with self._lock:
            now_s = self._clock()
            left, since_s = self._kept.get(name, (self.most, now_s))
            left = min(left + (now_s - since_s) * self.rate_hz, self.most)
            wait_s = 0.0 if left >= 1.0 else (1.0 - left) / self.rate_hz
            self._kept[name] = (left if wait_s else left - 1.0, now_s)
            self._kept.move_to_end(name)
            if len(self._kept) > KEPT:
                self._kept.popitem(last=False)
            return wait_s
