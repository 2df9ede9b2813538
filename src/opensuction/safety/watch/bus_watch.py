"""Detection of sensor messages that repeat the last readings instead of new ones.

A sensor as sold has noise: its last digits change from tick to tick. Where those of the vacuum have
gone up and down so far and now all sensors repeat themselves to the last digit, nothing is read any
more, whatever the head does. Sensors without noise show nothing of the kind while all of them rest;
with a head that must move, repetition is detected with them, too.
"""

from typing import NamedTuple

from opensuction.kernel.arithmetic import count_ticks, drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero

STALE_TICKS = 50
"""For how long all sensors must repeat themselves to tell nothing of a head that should move: a
sixth of what a withdrawal may pull on what holds it."""
DEAD_TICKS = 150
"""For how long to be no readings where noise was. A vacuum that tells the same in 4 of 5 ticks
turns in a tenth; by chance it does so for 150 ticks once in 1e14 [computed]."""
RESTLESS_SHARE = 0.1
"""Share of ticks in which noise turns the vacuum, at least: white noise does so in 2 of 3."""
RESTLESS_S = 0.1
"""Window over which that share is averaged; assumed."""


class BusWatch(NamedTuple):
    """Watch on the sensors' messages, up to this tick."""

    stale_ticks: int
    """For how long every sensor has told the same to the last digit, with vacuum in the line."""
    rising: bool
    """The vacuum rose when it last changed."""
    restless_share: float
    """Share of ticks in which it turned, averaged; kept while all stay the same."""


START = make_zero(BusWatch)


@compiled
def step(state: BusWatch, change_mmhg: float, same: bool, dt_s: float) -> BusWatch:
    """Bring it up to this tick.

    change_mmhg: of the raw vacuum since the last tick. same: all sensors tell the same as then,
    with vacuum in the line.
    """
    if same:
        return state._replace(stale_ticks=count_ticks(state.stale_ticks, True))
    turned = change_mmhg != 0.0 and (change_mmhg > 0.0) != state.rising
    gained = ((1.0 if turned else 0.0) - state.restless_share) * (dt_s / (RESTLESS_S + dt_s))
    return BusWatch(
        stale_ticks=0,
        rising=change_mmhg > 0.0 if change_mmhg != 0.0 else state.rising,
        restless_share=drop_tiny(state.restless_share + gained),
    )


@compiled
def is_stale(state: BusWatch) -> bool:
    """True where nothing is told of a head that should move."""
    return state.stale_ticks >= STALE_TICKS


@compiled
def is_dead(state: BusWatch) -> bool:
    """True where no sensor is read any more, whatever the head does."""
    return state.stale_ticks >= DEAD_TICKS and state.restless_share >= RESTLESS_SHARE
