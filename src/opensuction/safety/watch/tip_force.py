"""Force of the tip on what it meets, from what the insertion drive works against.

A catheter that goes in at one speed meets one friction; what the tip presses on comes on top, and
the head bears it. It is read twice: from the motor's current, and from the volts that the servo
needs to keep the speed. Noise of one is not in the other, so the less of the two counts.

It presumes that the head has gone in at one speed since before there was anything to touch: at
each change of speed the friction is learnt anew. It sees the carina whatever the contact switch
says: in 28 drawn adults, children and neonates with a switch that never closes the tip's .11 to .17
N were told, where it went on to .27; without contact the estimate came to .031 N at most in 36
[in-silico].

Window of the contact switch: head travel and time in which it may, and must, have closed.

There is no tip sensor, only the deepest and the shallowest possible tip behind the gap
(`opensuction.safety.limits`). Closed where even the deepest possible tip has nothing to touch,
the switch is stuck or bridged. Open where even the shallowest possible tip has passed the carina,
the carina was missed, or the switch cannot close; how far the switch can be trusted depends on
whether it has been seen to close and to open again.
"""

from typing import NamedTuple

from opensuction.kernel.arithmetic import add_up_duration, drop_tiny, extend_duration
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero
from opensuction.safety.head.drive_force import DriveForce
from opensuction.safety.limits import WindowLimits

IMPOSSIBLE_S = 0.6
"""How long contact must last where there is nothing to touch: bounces take 10 ms at most, a cough
that moves the trachea, or lays its wall on the tip, 0.4 s; assumed. The head is held so long."""
RELEASE_MM = 3.0
"""Way back from where contact began, after which it must be over: tissue and catheter give way
by 0.3 N / 0.16 N/mm = 1.9 mm, and the polymer creeps by 0.5 mm [computed]."""
NOWHERE_MM = -1.0e6
"""Nothing is touched: above every tip."""


class ContactWindow(NamedTuple):
    """Watch on the contact switch."""

    touched_mm: float
    """Least depth of the tip where the present contact began."""
    impossible_s: float
    """For how long in all there has been contact where there is nothing to touch: a switch that
    chatters adds up; time without takes as much off."""
    proven: bool
    """The switch has been seen to close where it may and to open again, since the last reset."""
    met_mm: float
    """Greatest least depth of the tip with contact beyond where it must have come."""


WINDOW_START = ContactWindow(NOWHERE_MM, impossible_s=0.0, proven=False, met_mm=NOWHERE_MM)
"""At power-up."""


@compiled
def step_window(
    limits: WindowLimits,
    state: ContactWindow,
    deepest_mm: float,
    shallowest_mm: float,
    touching: bool,
    touched: bool,
    dt_s: float,
) -> ContactWindow:
    """Bring it up to this tick.

    deepest_mm, shallowest_mm: possible tip positions. touching, touched: contact now and a tick
    ago, without its bounces.
    """
    begun_mm = state.touched_mm
    if not touching:
        begun_mm = NOWHERE_MM
    elif not touched:
        begun_mm = shallowest_mm
    impossible = touching and deepest_mm < max(limits.from_mm, begun_mm - RELEASE_MM)
    released = touched and not touching and state.impossible_s == 0.0
    met_mm = state.met_mm
    if shallowest_mm <= limits.by_mm:
        met_mm = NOWHERE_MM
    elif touching:
        met_mm = max(met_mm, shallowest_mm)
    return ContactWindow(
        touched_mm=begun_mm,
        impossible_s=add_up_duration(state.impossible_s, impossible, 1.0, dt_s),
        proven=state.proven or (released and deepest_mm >= limits.from_mm),
        met_mm=met_mm,
    )


@compiled
def is_missed(
    limits: WindowLimits, state: ContactWindow, shallowest_mm: float, touching: bool
) -> bool:
    """True where contact must have come by now and has not.

    A carina that was met there is not missed by a tip that goes back from it.
    """
    return not touching and shallowest_mm > max(limits.by_mm, state.met_mm)


@compiled
def reset(state: ContactWindow) -> ContactWindow:
    """After a person's reset: the catheter may have been changed unseen."""
    return state._replace(impossible_s=0.0, proven=False, met_mm=NOWHERE_MM)


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
    return found._replace(pressing_s=extend_duration(state.pressing_s, presses, dt_s))


@compiled
def is_pressing(state: TipForce) -> bool:
    """True where the tip has pressed for long enough, and no switch has closed."""
    return state.pressing_s > PRESSED_S
