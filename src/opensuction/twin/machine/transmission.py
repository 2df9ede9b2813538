"""Catheter in its conduit: head travel in, free tip travel out.

Clearance is distributed along the bends, so the tip answers as many plays of different width
side by side; friction against elastic stretch is one more narrow play in series; the polymer
creeps for seconds after the catheter has moved; and the gain changes slightly with depth. Width
is bend angle times diametral clearance: re-routing the conduit changes it. Transmissions of other
classes (`twin.conduit`) put something else in the place of plays and stretch; gain and creep are
behind it all the same.

Creep of the catheter's polymer: what its motion draws out comes back over seconds.

Two modes, ``tau dz/dt = A v / (|v| + v0) - z`` with v the catheter's own speed.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import play
from opensuction.hysteresis.play import PLAYS, Bundle
from opensuction.kernel.arithmetic import drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array
from opensuction.twin.conduit import play_line, rate_friction
from opensuction.twin.conduit.play_line import PlayLines, TransmissionKind
from opensuction.twin.conduit.rate_friction import BoucWenLag, RateFriction

VELOCITY_MM_PER_S = 3.0
"""Speed of the catheter at which half of the amplitude is drawn; assumed."""


class Creep(NamedTuple):
    """Amplitudes and inverse time constants of the two modes."""

    fast_mm: float
    fast_per_s: float
    slow_mm: float
    slow_per_s: float


class CreepState(NamedTuple):
    """Lag of the tip, in either mode."""

    fast_mm: float
    slow_mm: float


NONE = CreepState(0.0, 0.0)


@compiled
def step_creep(creep: Creep, state: CreepState, speed_mm_per_s: float, dt_s: float) -> CreepState:
    """Advance by one tick with the catheter at some speed."""
    drawn = 0.0
    if speed_mm_per_s != 0.0:
        drawn = speed_mm_per_s / (abs(speed_mm_per_s) + VELOCITY_MM_PER_S)
    # Each mode relaxes towards what the motion draws; a tick is a 300th of any time constant.
    fast = state.fast_mm + creep.fast_per_s * dt_s * (creep.fast_mm * drawn - state.fast_mm)
    slow = state.slow_mm + creep.slow_per_s * dt_s * (creep.slow_mm * drawn - state.slow_mm)
    return CreepState(fast_mm=drop_tiny(fast), slow_mm=drop_tiny(slow))


@compiled
def lag_mm(creep: Creep, behind_mm: Array, dt_s: float) -> Array:
    """Lag of a tip behind a catheter's own positions; shape (n,), from rest."""
    lags, state = np.empty(behind_mm.size), CreepState(0.0, 0.0)
    before_mm = behind_mm[0]
    for tick in range(behind_mm.size):
        state = step_creep(creep, state, (behind_mm[tick] - before_mm) / dt_s, dt_s)
        before_mm = behind_mm[tick]
        lags[tick] = state.fast_mm + state.slow_mm
    return lags


class Transmission(NamedTuple):
    """Parameters of the catheter and its conduit."""

    kind: int
    """Its class, a `TransmissionKind`."""
    widths_mm: Bundle
    """Full widths of the plays."""
    stretch_mm: float
    """Friction-limited elastic stretch: full width of the play in series."""
    gain: float
    """Tip travel for each mm of head travel, half-way down."""
    gain_per_mm: float
    """Change of that gain with depth, as a share of it."""
    middle_mm: float
    """Depth at which ``gain`` holds."""
    offset_mm: float
    """Tip position at depth 0."""
    creep: Creep
    lag_ratio: float
    """Of a lag or stretch of another class to what its parameters say: laid otherwise."""
    bouc_wen: BoucWenLag
    friction: RateFriction
    lines: PlayLines


class TransmissionState(NamedTuple):
    """State of the catheter in its conduit."""

    plays_mm: Bundle
    behind_mm: float
    """Position behind clearances and stretch, or what is in their place."""
    lag_mm: float
    """Memory of a class that has one beside its plays."""
    head_mm: float
    creep: CreepState
    tip_mm: float
    """Where the tip would be, were nothing in its way."""


def bundle(values: Iterable[float]) -> Bundle:
    """A number for each play. Raises ValueError for more or fewer."""
    found = tuple(float(value) for value in values)
    if len(found) != PLAYS:
        raise ValueError(f"a conduit has {PLAYS} plays, not {len(found)}")
    return found


def after_retract(transmission: Transmission, head_mm: float) -> TransmissionState:
    """State at rest after a long retract that ended with the head at ``head_mm``."""
    plays = bundle(head_mm + 0.5 * width_mm for width_mm in transmission.widths_mm)
    behind, lag = float(np.mean(plays)) + 0.5 * transmission.stretch_mm, 0.0
    if transmission.kind == TransmissionKind.BOUC_WEN:
        lag = -float(rate_friction.saturation_mm(transmission.bouc_wen))
        behind = head_mm + transmission.lag_ratio * transmission.bouc_wen.share * lag
    elif transmission.kind == TransmissionKind.RUBBING:
        lag = -transmission.lag_ratio * float(rate_friction.steady_mm(transmission.friction, 0.0))
        behind = float(np.mean(plays)) - lag
    elif transmission.kind == TransmissionKind.RECORDED:
        behind = float(play_line.read_out_mm(transmission.lines, plays))
    return TransmissionState(
        plays_mm=plays,
        behind_mm=behind,
        lag_mm=lag,
        head_mm=head_mm,
        creep=NONE,
        tip_mm=float(depth_mm(transmission, behind)),
    )


@compiled
def widen(transmission: Transmission, ratio: float) -> Transmission:
    """The same with its gap, or what is in its place, so many times as wide; stretch as it was."""
    return transmission._replace(
        widths_mm=play.scale_bundle(transmission.widths_mm, ratio),
        lag_ratio=transmission.lag_ratio * ratio,
    )


@compiled
def depth_mm(transmission: Transmission, behind_mm: float) -> float:
    """Tip position for a catheter position behind all clearance, without creep.

    The integral of ``gain * (1 + gain_per_mm * (depth - middle_mm))`` from depth 0.
    """
    change = transmission.gain_per_mm * (0.5 * behind_mm - transmission.middle_mm)
    return transmission.gain * behind_mm * (1.0 + change) + transmission.offset_mm


@compiled
def _follow_otherwise(
    transmission: Transmission, state: TransmissionState, head_mm: float, dt_s: float
) -> tuple[Bundle, float, float]:
    """Plays, position behind it all and lag of the other classes, once the head has moved."""
    ratio = transmission.lag_ratio
    if transmission.kind == TransmissionKind.BOUC_WEN:
        # Of a loop so many times as wide both the travel and the lag are so many times as long.
        move_mm = (head_mm - state.head_mm) / ratio
        lag = rate_friction.step_bouc_wen_lag(transmission.bouc_wen, state.lag_mm, move_mm)
        return state.plays_mm, head_mm + ratio * transmission.bouc_wen.share * lag, lag
    plays, mean = play.step_bundle(transmission.widths_mm, state.plays_mm, head_mm)
    if transmission.kind == TransmissionKind.RUBBING:
        move_mm = mean - (state.behind_mm + state.lag_mm)
        lag = rate_friction.step(transmission.friction, state.lag_mm, move_mm, ratio, dt_s)
        return plays, mean - lag, lag
    return plays, play_line.read_out_mm(transmission.lines, plays), 0.0


@compiled
def step(
    transmission: Transmission, state: TransmissionState, head_mm: float, dt_s: float
) -> TransmissionState:
    """Advance by one tick in which the head went to ``head_mm``."""
    plays, behind, lag = state.plays_mm, state.behind_mm, state.lag_mm
    speed = 0.0
    if head_mm != state.head_mm:
        if transmission.kind == TransmissionKind.PLAYS:
            plays, mean = play.step_bundle(transmission.widths_mm, plays, head_mm)
            behind = play.step(transmission.stretch_mm, behind, mean)
        else:
            plays, behind, lag = _follow_otherwise(transmission, state, head_mm, dt_s)
        # Crossing the clearance strains nothing: only the catheter's own motion counts.
        speed = (behind - state.behind_mm) / dt_s
    crept = step_creep(transmission.creep, state.creep, speed, dt_s)
    return TransmissionState(
        plays_mm=plays,
        behind_mm=behind,
        lag_mm=lag,
        head_mm=head_mm,
        creep=crept,
        tip_mm=depth_mm(transmission, behind) - crept.fast_mm - crept.slow_mm,
    )


@compiled
def simulate(
    transmission: Transmission, state: TransmissionState, heads_mm: Array, dt_s: float
) -> Array:
    """Free tip positions for a head position each tick, both of shape (n,)."""
    tips = np.empty(heads_mm.size)
    for tick in range(heads_mm.size):
        state = step(transmission, state, heads_mm[tick], dt_s)
        tips[tick] = state.tip_mm
    return tips
