"""Mailbox of a running controller: requests as datagrams that the loop reads without waiting.

Each names its sender, its time, and a key: a request that comes twice under one key is obeyed once.
A request that is old, that comes after a later one of the same sender, or that names no sender is
refused. A stop is never refused, and has a socket of its own that no other request can fill. Every
datagram is answered among the loop's events.
"""

import json
import re
from collections import OrderedDict, deque
from pathlib import Path
from typing import Any, NamedTuple

from opensuction.host.host import Host, Inbox
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import NO_REQUESTS, STOP, Requests

LARGEST = 2048
"""Bytes of a datagram; a longer one is refused."""
MOST = 4
"""Datagrams that are taken up in a tick, and as many that ask to stop; the rest wait in the
sockets, which hold some ten each."""
PATIENCE_S = 0.2
"""How long a sender waits for room in the socket."""
WAITING_MOST = 16
"""Requests that may wait for their button to be released; more are refused."""
STALE_NS = 2_000_000_000
"""A request that was sent longer ago meant a machine that may be another one by now."""
EARLY_NS = 50_000_000
"""So much later than now it may have been sent; more is no clock of this machine."""
KEYS_KEPT = 1024
SENDERS_KEPT = 64
NAME_MOST = 64
"""Letters of a name or a key."""
SET_PROTOCOL = "set_protocol"
"""No button: the controller shall go by other settings, which lie in a file named by the key."""
ASKS = frozenset((*Requests._fields, SET_PROTOCOL))
KEY = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
"""What the key of such a request looks like."""


class MailboxAnswer(NamedTuple):
    """Answer to a datagram."""

    key: str
    """As it was sent; empty where it was not understood."""
    who: str
    ask: str
    at: str
    """When it was sent by the sender's clock, UTC; only for the record."""
    verdict: str
    """``pressed``: the button went down in this tick, and the machine's phase and counters say what
    came of it. ``twice``, ``stale``, ``early``, ``out of order``, ``nobody``, ``unknown``,
    ``too many`` or ``malformed``: not done, for that reason. Of other settings: ``set``, or why
    not."""


def _stop_path(path: Path) -> Path:
    return path.with_name(path.name + ".stop")


class MailboxRequest(NamedTuple):
    """A datagram that was understood."""

    ask: str
    who: str
    key: str
    at: str
    number: int
    sent_ns: int


def answer(asked: MailboxRequest, verdict: str) -> MailboxAnswer:
    """Answer to a request, with a verdict on it."""
    return MailboxAnswer(asked.key, asked.who, asked.ask, asked.at, verdict)


def _understand(data: bytes) -> MailboxRequest | None:
    """The datagram as it should be; None for any other."""
    if len(data) > LARGEST:
        return None
    try:
        told: Any = json.loads(data)
        found = MailboxRequest(**told)
    except (ValueError, TypeError, RecursionError):
        return None
    words = (found.ask, found.who, found.key, found.at)
    texts = all(type(word) is str and len(word) <= NAME_MOST for word in words)
    numbers = type(found.number) is int and type(found.sent_ns) is int
    return found if texts and numbers and found.key else None


class Mailbox:
    """The loop's end."""

    def __init__(self, path: Path, host: Host = THIS_COMPUTER) -> None:
        """Listen at a path that only the same user may write to; what was there before goes.

        Raises InputError where that cannot be.
        """
        self._clock = host.clock
        self._inboxes: list[Inbox] = []
        try:
            for one in (_stop_path(path), path):
                self._inboxes.append(host.datagrams.listen(one))
        except OSError as error:
            self.close()
            raise InputError(f"no requests can be taken at {path}: {error}") from None
        self._seen: OrderedDict[str, None] = OrderedDict()
        self._last: OrderedDict[str, int] = OrderedDict()
        self._waiting: deque[MailboxRequest] = deque()
        self._down: frozenset[str] = frozenset()
        self.setting: MailboxRequest | None = None
        """A request of other settings, for the loop to take and to answer."""

    @property
    def is_quiet(self) -> bool:
        """True while nobody's button is down or waits, but for what may lie in the sockets."""
        return not (self._waiting or self._down or self.setting)

    def close(self) -> None:
        """Stop listening."""
        for own in self._inboxes:
            own.close()

    def receive(self) -> tuple[Requests, list[MailboxAnswer]]:
        """The buttons of this tick, and what became of the datagrams that came or waited.

        A button that was down in the last tick is up in this one: two that press it press twice.
        """
        answers: list[MailboxAnswer] = []
        down: set[str] = set()
        waiting, self._waiting = self._waiting, deque()
        for asked in waiting:
            self._press(asked, down, answers)
        for own in self._inboxes:
            for _ in range(MOST):
                if (data := own.receive(LARGEST + 1)) is None:
                    break
                self._take(data, down, answers)
        self._down = frozenset(down)
        if not down:
            return NO_REQUESTS, answers
        return NO_REQUESTS._replace(**dict.fromkeys(down, True)), answers

    def _take(self, data: bytes, down: set[str], answers: list[MailboxAnswer]) -> None:
        """Obey a datagram, or say why not."""
        asked = _understand(data)
        if asked is None:
            answers.append(MailboxAnswer("", "", "", "", "malformed"))
            return
        reason = self._refuse(asked)
        if not reason and asked.ask == SET_PROTOCOL:
            if self.setting is None:
                self.setting = asked
                return
            reason = "too many"
        if reason:
            answers.append(answer(asked, reason))
        else:
            self._press(asked, down, answers)

    def _press(self, asked: MailboxRequest, down: set[str], answers: list[MailboxAnswer]) -> None:
        """Put its button down, or keep it for the next tick.

        Whoever stops in a tick in which another one does, too, has stopped with it.
        """
        is_stop = asked.ask == STOP
        if asked.ask in self._down or (asked.ask in down and not is_stop):
            if is_stop or len(self._waiting) < WAITING_MOST:
                self._waiting.append(asked)
                return
            verdict = "too many"
        else:
            down.add(asked.ask)
            verdict = "pressed"
        answers.append(answer(asked, verdict))

    def _refuse(self, asked: MailboxRequest) -> str:
        """Reason for refusing a request; empty where it is obeyed. A stop is refused to nobody."""
        late = asked.number <= self._last.get(asked.who, -1)
        if asked.ask != STOP:
            if reason := self._refuse_button(asked, late):
                return reason
            # However often somebody stops, what others have asked stays known.
            _keep(self._seen, asked.key, None, KEYS_KEPT)
        if not late:
            _keep(self._last, asked.who, asked.number, SENDERS_KEPT)
        return ""

    def _refuse_button(self, asked: MailboxRequest, late: bool) -> str:
        now_ns = self._clock.monotonic_ns()
        if asked.key in self._seen:
            return "twice"
        if asked.ask not in ASKS:
            return "unknown"
        if asked.ask == SET_PROTOCOL and not KEY.fullmatch(asked.key):
            return "malformed"
        if not asked.who.strip():
            return "nobody"
        if asked.sent_ns > now_ns + EARLY_NS:
            return "early"
        if now_ns - asked.sent_ns > STALE_NS:
            return "stale"
        return "out of order" if late else ""


def _keep(kept: OrderedDict[str, Any], key: str, value: int | None, most: int) -> None:
    kept[key] = value
    kept.move_to_end(key)
    if len(kept) > most:
        kept.popitem(last=False)


class Sender:
    """One who asks."""

    def __init__(
        self,
        path: Path,
        who: str,
        patience_s: float = PATIENCE_S,
        host: Host = THIS_COMPUTER,
    ) -> None:
        """Ask the loop that listens at a path.

        who: the person's name, for the record. patience_s: longest wait for room; 0: none.
        """
        self._path, self._who, self._clock = path, who, host.clock
        self._number = self._clock.monotonic_ns()
        self._outbox = host.datagrams.sender(patience_s)

    def close(self) -> None:
        """Ask no more."""
        self._outbox.close()

    def ask(self, ask: str, key: str, at: str) -> None:
        """Send a request. ask: a field of `Requests`. key: its own. at: UTC, for the record.

        Raises InputError where nobody listens, or does not come round to it.
        """
        self._number += 1
        now_ns = self._clock.monotonic_ns()
        asked = MailboxRequest(ask, self._who, key, at, self._number, now_ns)
        data = json.dumps(asked._asdict()).encode()
        path = _stop_path(self._path) if ask == STOP else self._path
        try:
            self._outbox.send(path, data)
        except OSError as error:
            reason = error.strerror or str(error)
            raise InputError(f"no controller takes requests at {self._path}: {reason}") from None
