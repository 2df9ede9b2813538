"""Limits of a console on rates, sizes, times and connections; a page needs a tenth of them."""

from typing import NamedTuple


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
