"""The drives' own watchdog: without new commands they bring the catheter out by themselves.

It is part of the drives, and all that it knows of the controller is whether a command with a new
number has come. When none comes for some time, or the mains fails, the drives close the valve,
stop the pump, vent the line and, while they have energy, draw the head home. If the head moves
inwards instead, further than it coasts, its torque is switched off. They obey no command until a
controller has started anew.

The annunciator at the bedside: what people are told, with the controller and without it.

A device with a battery of its own. It shows what the controller's last message wants shown, and
three lines reach it that need no controller: of the drives' watchdog, of their receiver, and of the
power supply. The watchdog's line and the supply's are closed while all is well: without energy they
open, and that is a sign too. What the controller wants shown is an opaque number here; which
condition each line means is `opensuction.simulation.outcome`.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Commands
from opensuction.kernel.record import make_zero
from opensuction.twin.machine.machine import Machine

LATE_S = 0.005
"""[design] A command that is older than this is late: a quarter of the watchdog's 20 ms, so that it
is told before the drives act. The head moves 0.3 mm in it at 60 mm/s, the fastest. Jitter of some
ticks is not told, and of a bus that loses each tenth message six in a row are lost once in 1,000 s
[computed]."""


class Annunciator(NamedTuple):
    """Display at the bedside in a tick."""

    said: int
    """Mask of conditions in the controller's last message; it stays while the controller is
    silent."""
    watchdog_fired: bool
    """The drives have acted on their own. It stays until a person resets a controller that runs."""
    reserve_used: bool
    """There is no mains power: the drives have their reserve energy, or nothing."""
    message_late: bool
    """The drives' commands have come late, or not at all. It stays as the watchdog's sign does."""


class Lines(NamedTuple):
    """Lines into the annunciator in a tick."""

    heard: bool
    """A new message of the controller has come."""
    wanted: int
    """What that message wants shown."""
    reset: bool
    """A person resets what has ended, at a controller that runs."""
    alone: bool
    """The drives act on their own, or have no energy."""
    mains: bool
    lag_s: float
    """Age of the command that the drives obey."""


DARK = make_zero(Annunciator)
"""Nothing has been shown yet."""


@compiled
def step_annunciator(state: Annunciator, lines: Lines, dt_s: float) -> Annunciator:
    """Advance by one tick."""
    kept = not lines.reset
    # Half a tick forgives a time that is a number of ticks. Drives that act alone obey none.
    late = not lines.alone and lines.lag_s > LATE_S + 0.5 * dt_s
    return Annunciator(
        said=lines.wanted if lines.heard else state.said,
        watchdog_fired=lines.alone or (state.watchdog_fired and kept),
        reserve_used=not lines.mains,
        message_late=late or (state.message_late and kept),
    )


@compiled
def repeat(wanted: int) -> Annunciator:
    """Display where the link is sound: the controller's conditions, and no sign of a line."""
    return Annunciator(said=wanted, watchdog_fired=False, reserve_used=False, message_late=False)


SILENCE_S = 0.02
"""[assumed] Twenty messages of 1 ms; the head moves 0.6 mm at 30 mm/s in that time."""
SPEED_SHARE = 0.5
"""[assumed] Share of the no-load speed at which the drives draw the head home."""
GAIN_V_PER_MM = 10.0
"""[paper] P of the insertion servo, here the drive's own."""
LEAD_MM = 2.0
"""[assumed] The drive's ramp is at most this far ahead of the head, which limits the voltage on a
head that is blocked."""
INWARDS_MM = 3.0
"""[computed] A head that was moving in at 30 mm/s coasts 2.3 mm at `BRAKING_MM_PER_S2`; further
than that, or than its own speed carries it, it is the drive that pushes it in, and its torque is
switched off."""
BRAKING_MM_PER_S2 = 200.0
"""[assumed] Half of what a sound drive brakes with: a head at 50 mm/s coasts 3.2 mm."""
SETTLING_S = 0.02
"""[assumed] Time constant of the speed that the drive knows of its own encoder."""
HOME_MM = 0.5
"""[assumed] This near to home the drive is done."""


class DriveWatchdog(NamedTuple):
    """Parameters of the drives' watchdog."""

    silence_s: float
    """Without a new command for longer than this the drives act on their own."""
    home_mm: float
    """Head position at which the tip is out of the patient."""
    out_mm_per_s: float


class WatchdogState(NamedTuple):
    """State of the drives' watchdog."""

    silent_s: float
    """Since the last new command."""
    alone: bool
    """Whether they act on their own."""
    alone_s: float
    """For how long they have."""
    ramp_mm: float
    """Set point of the head while they do."""
    from_mm: float
    """Where the head was when they began."""
    head_mm: float
    """Where it was a tick ago."""
    speed_ratio: float
    """How fast it moved in, of the no-load speed; one that is not known yet counts as the highest.
    """
    coast_mm: float
    """How far it may coast inwards since they began."""
    astray: bool
    """It has moved in instead of out: no torque any more."""


LISTENING = make_zero(WatchdogState)._replace(speed_ratio=1.0)
"""As after the start of a controller."""
IDLE = make_zero(Commands)
"""No torque, no pump; the valve shut by its spring, and the line vented."""


def of(machine: Machine, home_mm: float) -> DriveWatchdog:
    """The watchdog of a machine's drives, the head being parked at ``home_mm``."""
    axis = machine.insertion_axis
    return DriveWatchdog(
        silence_s=SILENCE_S,
        home_mm=home_mm,
        out_mm_per_s=SPEED_SHARE * axis.speed_per_v * axis.voltage_limit_v,
    )


@compiled
def _speed_ratio(
    watchdog: DriveWatchdog, state: WatchdogState, head_mm: float, dt_s: float
) -> float:
    """Speed of the head inwards as a ratio, by the drive's own encoder."""
    moved = (head_mm - state.head_mm) / dt_s * SPEED_SHARE / watchdog.out_mm_per_s
    now = min(max(moved, 0.0), 1.0)
    return state.speed_ratio + (now - state.speed_ratio) * dt_s / (SETTLING_S + dt_s)


@compiled
def _coast_mm(watchdog: DriveWatchdog, speed_ratio: float) -> float:
    """Travel for which a sound drive lets a head of this speed go on before it turns."""
    speed_mm_per_s = speed_ratio * watchdog.out_mm_per_s / SPEED_SHARE
    return max(INWARDS_MM, 0.5 * speed_mm_per_s * speed_mm_per_s / BRAKING_MM_PER_S2)


@compiled
def step(
    watchdog: DriveWatchdog,
    state: WatchdogState,
    heard: bool,
    mains: bool,
    head_mm: float,
    dt_s: float,
) -> WatchdogState:
    """Advance by one tick.

    heard: whether a new command came. mains: whether there is mains power. head_mm: the drive's
    own encoder.
    """
    silent = 0.0 if heard else state.silent_s + dt_s
    # Half a tick forgives a time that is a sum of ticks.
    alone = state.alone or not mains or silent > watchdog.silence_s + 0.5 * dt_s
    if not alone:
        return LISTENING._replace(
            silent_s=silent,
            ramp_mm=head_mm,
            from_mm=head_mm,
            head_mm=head_mm,
            speed_ratio=_speed_ratio(watchdog, state, head_mm, dt_s),
        )
    # Never inwards, and never far ahead of the head.
    wanted = max(state.ramp_mm - watchdog.out_mm_per_s * dt_s, head_mm - LEAD_MM)
    ramp = min(max(wanted, watchdog.home_mm), max(head_mm, watchdog.home_mm))
    from_mm = state.from_mm if state.alone else head_mm
    coast_mm = state.coast_mm if state.alone else _coast_mm(watchdog, state.speed_ratio)
    return WatchdogState(
        silent_s=silent,
        alone=True,
        alone_s=state.alone_s + dt_s,
        ramp_mm=ramp,
        from_mm=from_mm,
        head_mm=head_mm,
        speed_ratio=state.speed_ratio,
        coast_mm=coast_mm,
        astray=state.astray or head_mm > from_mm + coast_mm,
    )


@compiled
def commands(
    watchdog: DriveWatchdog, state: WatchdogState, powered: bool, head_mm: float, cam_rad: float
) -> Commands:
    """Commands of the drives themselves. powered: by the mains or by reserve energy."""
    pulling = powered and not state.astray and head_mm > watchdog.home_mm + HOME_MM
    return IDLE._replace(
        head_mm=state.ramp_mm,
        insertion_v=GAIN_V_PER_MM * (state.ramp_mm - head_mm) if pulling else 0.0,
        insertion_on=pulling,
        cam_rad=cam_rad,
    )
