"""Force of the tip on what it meets, from what the insertion drive works against.

A catheter that goes in at one speed meets one friction; what the tip presses on comes on top, and
the head bears it. It is read twice: from the motor's current, and from the volts that the servo
needs to keep the speed. Noise of one is not in the other, so the less of the two counts.

It presumes that the head has gone in at one speed since before there was anything to touch: at
each change of speed the friction is learnt anew. It sees the carina whatever the contact switch
says: in 28 drawn adults, children and neonates with a switch that never closes the tip's .11 to .17
N were told, where it went on to .27; without contact the estimate came to .031 N at most in 36
[in-silico].
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.denormals import drop_tiny
from opensuction.kernel.duration import extend
from opensuction.kernel.record import make_zero
from opensuction.safety.head.drive_force import DriveForce

SPEED_S = 0.1
"""Time constant of the speed that the present one is held against."""
STEADY_MM_PER_S = 3.0
"""Off that speed by less than this the head keeps it: noise and the servo's ripple are 1."""
GOING_MM_PER_S = 5.0
"""A head that is slower searches for nothing; the search is at 10 mm/s [design]."""
SETTLING_S = 0.3
"""After a change of speed friction is learnt from then on: ten time constants of the resistance."""
FORCE_S = 0.05
"""Time constant of what the drive works against now: at 10 mm/s the tip has pressed for 0.5 mm."""
FREE_S = 1.0
"""Time constant of what it works against without the tip's force."""
PRESSED_N = 0.08
"""Force that is one of the tip: more than twice what friction and sensors make of none, and less
than any catheter buckles at (.125 N) [in-silico]. What it really is then is less than .18 N."""
PRESSED_S = 0.02
"""How long it must last."""


class Load(NamedTuple):
    """Of the drive, N."""

    now_n: float
    free_n: float
    """Without the tip's force."""


class TipForce(NamedTuple):
    """Watch on the force at the tip, up to this tick."""

    usual_mm_per_s: float
    """Speed of the head, averaged over `SPEED_S`."""
    steady_s: float
    """How long it has kept that, going in, without contact."""
    measured: Load
    """By the motor's current."""
    asked: Load
    """By its volts."""
    pressing_s: float
    """How long the tip has pressed on something where the carina may be."""


START = make_zero(TipForce)


@compiled
def force_n(state: TipForce) -> float:
    """Least force at the tip that both current and volts bear out; the error is 0.03 N."""
    measured, asked = state.measured, state.asked
    return max(min(measured.now_n - measured.free_n, asked.now_n - asked.free_n), 0.0)


@compiled
def _follow(load: Load, drive_n: float, steady_s: float, pressed: bool, dt_s: float) -> Load:
    """A load after another tick at one speed; what is pressed with is none of the friction's."""
    share = dt_s / (min(max(steady_s, 0.0), FORCE_S) + dt_s)
    now_n = load.now_n + (drive_n - load.now_n) * share
    if steady_s < SETTLING_S:
        return Load(now_n, now_n)
    if pressed:
        return Load(drop_tiny(now_n), load.free_n)
    known_s = min(steady_s - SETTLING_S, FREE_S) + FORCE_S
    free_n = load.free_n + (now_n - load.free_n) * (dt_s / (known_s + dt_s))
    return Load(drop_tiny(now_n), drop_tiny(free_n))


@compiled
def step(
    state: TipForce,
    drive: DriveForce,
    speed_mm_per_s: float,
    touching: bool,
    may_touch: bool,
    dt_s: float,
) -> TipForce:
    """Bring it up to this tick.

    speed_mm_per_s: of the head, averaged. touching: the contact switch is closed. may_touch: there
    may be a carina where the tip can be.
    """
    usual = state.usual_mm_per_s
    usual = drop_tiny(usual + (speed_mm_per_s - usual) * (dt_s / (SPEED_S + dt_s)))
    keeps = abs(speed_mm_per_s - usual) < STEADY_MM_PER_S and usual > GOING_MM_PER_S
    if touching or not keeps:
        return START._replace(usual_mm_per_s=usual)
    pressed = force_n(state) > 0.5 * PRESSED_N
    steady_s = state.steady_s + dt_s
    found = TipForce(
        usual_mm_per_s=usual,
        steady_s=steady_s,
        measured=_follow(state.measured, drive.resistance_n, state.steady_s, pressed, dt_s),
        asked=_follow(state.asked, drive.borne_n, state.steady_s, pressed, dt_s),
        pressing_s=0.0,
    )
    presses = may_touch and force_n(found) > PRESSED_N
    return found._replace(pressing_s=extend(state.pressing_s, presses, dt_s))


@compiled
def is_pressing(state: TipForce) -> bool:
    """True where the tip has pressed for long enough, and no switch has closed."""
    return state.pressing_s > PRESSED_S
