"""Rate limits of a console by kind of request: for each address, connection or session."""

import hashlib

from opensuction.console.guard.bucket import Buckets
from opensuction.console.guard.limits import Limits, Rate
from opensuction.console.guard.origin import SAFE
from opensuction.console.guard.problem import Problem

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
