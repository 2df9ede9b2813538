"""Parameters of a request for signals: its channels, and how much of the past to send."""

import math

from opensuction.console.guard.problem import FieldError, Problem
from opensuction.console.signals.channel import CHANNELS, Channel
from opensuction.console.signals.feed import PAST_MOST_S

CHANNELS_MOST = 16
SHOWN = 60
"""Letters of an unknown name that are said again."""


def read_channels(asked: str) -> tuple[Channel, ...]:
    """Channels by their names, with commas between; raises Problem 422."""
    names = [name.strip() for name in asked.split(",", CHANNELS_MOST)] if asked.strip() else []
    if not names:
        raise _problem("channels", f"name 1 to {CHANNELS_MOST} channels, with commas between")
    if len(names) > CHANNELS_MOST:
        raise _problem("channels", f"{CHANNELS_MOST} channels at most at once")
    if len(set(names)) < len(names):
        raise _problem("channels", "a channel is named twice")
    for name in names:
        if name not in CHANNELS:
            shown = "".join(one if one.isprintable() else "?" for one in name[:SHOWN])
            raise _problem("channels", f"no channel '{shown}': see /api/v1/signals/channels")
    return tuple(CHANNELS[name] for name in names)


def read_past_s(asked: str | None) -> float:
    """Duration of past signals that is asked for, in s; raises Problem 422."""
    if asked is None:
        return 0.0
    try:
        wanted_s = float(asked) if len(asked) < SHOWN else math.nan
    except ValueError:
        wanted_s = math.nan
    if not 0.0 <= wanted_s <= PAST_MOST_S:
        raise _problem("past_s", f"should be a number of seconds from 0 to {PAST_MOST_S:g}")
    return wanted_s


def _problem(field: str, detail: str) -> Problem:
    return Problem(422, detail, [FieldError(field, detail)])
