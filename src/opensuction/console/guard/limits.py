"""Limits of a console on rates, sizes, times and connections; a page needs a tenth of them.

Token buckets for rate limits: one for each name, refilled at a constant rate.

Rate limits of a console by kind of request: for each address, connection or session.
"""

import hashlib
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from typing import NamedTuple

from opensuction.console.guard.origin import SAFE
from opensuction.console.guard.problem import Problem

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


class Rate(NamedTuple):
    """Rate limit, with the burst that it allows."""

    rate_hz: float
    most: float
    """At once."""


class Limits(NamedTuple):
    """Limits of one console on requests."""

    body_bytes: int = 65_536
    body_s: float = 10.0
    """For the whole of it."""
    place_s: float = 2.0
    """For the body of a change, which keeps later ones of its session waiting; as old as a request
    may be that the control loop obeys (`ipc.mailbox.STALE_NS`)."""
    turn_s: float = 5.0
    """A change waits no longer for its session's earlier ones: then it may mean another machine."""
    files: Rate = Rate(500.0, 4000.0)
    """Of one address: twenty pages that open at once take some hundred files each."""
    reads: Rate = Rate(100.0, 600.0)
    """Of one address, by the interface."""
    own_reads: Rate = Rate(50.0, 400.0)
    """Of one session."""
    changes: Rate = Rate(20.0, 80.0)
    """Of one address."""
    sign_ins: Rate = Rate(5.0, 20.0)
    """Of one address; each takes a slow look at a password."""
    presses: Rate = Rate(20.0, 60.0)
    """Of one connection, of whatever button, before it is known which: a flood by others, also of
    the same computer or behind the same proxy, leaves a person's first presses to stop theirs."""
    first_presses: Rate = Rate(2.0, 3.0)
    """Of these, so many wait for nobody, however much others press;"""
    new_s: float = 2.0
    new_presses: Rate = Rate(20.0, 10.0)
    """and of one address by connections younger than `new_s`, which a flood can make at will; a
    page has older ones;"""
    more_at_once: int = 4
    """so many of all that come more often are carried out at once;"""
    more_s: float = 0.02
    """each takes so long at least, and the rest waits: a person's first press does not wait for
    who presses often. Each connection has one of them on the way at a time."""
    refused_s: float = 0.5
    """Delay of the answer to who asks too often: its connection asks nothing meanwhile."""
    buttons: Rate = Rate(10.0, 40.0)
    """Of one address, of buttons that do not stop."""
    sockets: int = 96
    """Open at once, in all;"""
    sockets_here: int = 80
    """of this computer;"""
    sockets_elsewhere: int = 16
    """of another address."""


USUAL = Limits()
NO_RATE = Rate(1e6, 1e6)
UNHURRIED = USUAL._replace(
    files=NO_RATE,
    reads=NO_RATE,
    own_reads=NO_RATE,
    changes=NO_RATE,
    sign_ins=NO_RATE,
    presses=NO_RATE,
    first_presses=NO_RATE,
    new_presses=NO_RATE,
    buttons=NO_RATE,
    refused_s=0.0,
)
"""For tests that ask more often than any person: what else is limited is so still."""


PREFIX = "/api/"
PRESSES, SIGN_IN = "/api/v1/requests", "/api/v1/session"


class Rates:
    """Of one console."""

    def __init__(self, limits: Limits) -> None:
        def make(rate: Rate) -> Buckets:
            return Buckets(*rate)

        self._files, self._reads = make(limits.files), make(limits.reads)
        self._own_reads, self._changes = make(limits.own_reads), make(limits.changes)
        self._sign_ins, self._presses = make(limits.sign_ins), make(limits.presses)
        self._buttons = make(limits.buttons)
        self._first_presses = make(limits.first_presses)
        self._new_presses, self._new_s = make(limits.new_presses), limits.new_s

    def check(self, method: str, path: str, peer: str, port: int, session: str | None) -> None:
        """Raises Problem where somebody asks too often. peer, port: of the connection."""
        if not path.startswith(PREFIX):
            _take(self._files, peer)
        elif method == "POST" and path == PRESSES:
            _take(self._presses, _connection(peer, port))
        elif method == "POST" and path == SIGN_IN:
            _take(self._sign_ins, peer)
        elif method not in SAFE:
            _take(self._changes, peer)
        else:
            _take(self._reads, peer)
            if session is not None:
                _take(self._own_reads, hashlib.sha256(session.encode()).hexdigest())

    def is_a_first_press(self, peer: str, port: int, age_s: float) -> bool:
        """Decide whether a connection has pressed little lately; to be asked once a press.

        age_s: of the connection. As many as one address makes anew have pressed often together.
        """
        if self._first_presses.take(_connection(peer, port)) > 0.0:
            return False
        return age_s >= self._new_s or self._new_presses.take(peer) == 0.0

    def check_button(self, peer: str) -> None:
        """The same for a button, once it is known that it is not to stop."""
        _take(self._buttons, peer)


def _connection(peer: str, port: int) -> str:
    return f"{peer} {port}"


def _take(buckets: Buckets, name: str) -> None:
    wait_s = buckets.take(name)
    if wait_s > 0.0:
        seconds = max(round(wait_s + 0.5), 1)
        detail = f"too many requests: try again in {seconds} s"
        raise Problem(429, detail, headers={"Retry-After": str(seconds)})
