"""Force that resists the head, estimated from the insertion motor's current.

The current is the force at the head. The part of it that does not accelerate the moving mass works
against friction, the catheter and whatever holds it. Speed and current go through the same average,
so that a start or a stop leaves no trace; contact of the tip (0.3 N) is less than friction varies,
so only a jam shows.

A current is believed as far as the motor bears it out: volts less back-EMF drive it through the
winding. At a standstill there is no back-EMF, and what the sensor reads beyond the volts' current
is its offset; without torque there are no volts, and the whole reading is offset.
"""

from typing import NamedTuple

from opensuction.kernel.arithmetic import drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import is_number
from opensuction.kernel.record import make_zero
from opensuction.safety.limits import DriveLimits

SETTLING_S = 0.03
"""Time constant of the resistance: an encoder step of 5 um on 16.4 kg is then 0.2 N [computed]."""
OFFSET_S = 0.5
"""Time constant over which the current sensor's offset is taken at rest; assumed."""
STILL_MM_PER_S = 0.1
"""Averaged speed below which the head stands still: an encoder step of 5 um adds 0.5 at first."""
BORNE_SHARE = 0.75
"""Share of a force that the motor's volts must bear out: 3 % of speed at 60 mm/s are 0.7 V, in the
bedside's drive as many newtons as 2.3; at the standstill of a jam there is no such error
[computed]."""
MOST_RATIO = 1.5
"""No more than this of the force that is a fault counts, of what is read or of what the volts ask
for: a spike is over when it is over [design]."""
AGAINST_N = 1.0
"""Force either way from which current and volts can be told to be against each other: a motor 3 %
faster than it should be is 0.7 N off at 30 mm/s [computed]."""
INERTIA_SHARE = 0.7
"""Share by which the inertia may be other than the machine's profile has it: what is on the rack,
and the gear's efficiency, either way; assumed."""
SLACK_N = 0.3
"""Less force is that of a motor without current: what is left of the sensor's offset is 0.2, its
noise a tenth [computed]; friction takes four times that."""
MM_PER_M = 1000.0


class DriveForce(NamedTuple):
    """Forces at the head, N, positive inwards; zeros while the drive is off."""

    force_n: float
    """Of the motor, averaged as the speed is."""
    resistance_n: float
    """What it works against: friction and load."""
    borne_n: float
    """Force that its volts ask for, averaged as the speed is."""
    offset_a: float
    """What the current sensor reads at rest beyond the current that the volts drive."""
    inertia_n: float
    """What of the force changes the head's speed, averaged as the resistance is."""


REST = make_zero(DriveForce)


@compiled
def rest(state: DriveForce) -> DriveForce:
    """With the drive off: what is known of its sensor stays."""
    return REST._replace(offset_a=state.offset_a)


@compiled
def learn(
    limits: DriveLimits, state: DriveForce, current_a: float, speed_mm_per_s: float, dt_s: float
) -> DriveForce:
    """With the drive off: a head that stands still has no current, so what is read is offset."""
    if not is_number(current_a) or abs(speed_mm_per_s) >= STILL_MM_PER_S:
        return rest(state)
    most_a = MOST_RATIO * limits.force_n / limits.newton_per_a
    left_a = min(max(current_a - state.offset_a, -most_a), most_a)
    gained_a = left_a * (dt_s / OFFSET_S)
    return REST._replace(offset_a=drop_tiny(state.offset_a + gained_a))


@compiled
def step(
    limits: DriveLimits,
    state: DriveForce,
    current_a: float,
    driven_v: float,
    speed_mm_per_s: float,
    gained_mm_per_s: float,
    share: float,
    dt_s: float,
) -> DriveForce:
    """Bring all up to this tick.

    driven_v: on the motor in the last tick. speed_mm_per_s, gained_mm_per_s: the averaged speed,
    and its change. share: of a new value in that average.
    ``r' = (F - r - m v') / T``, with the change of speed taken whole, so that no noise adds up.
    """
    told = is_number(current_a)
    most_a = MOST_RATIO * limits.force_n / limits.newton_per_a
    current = min(max(current_a - state.offset_a, -most_a), most_a) if told else 0.0
    driving_v = driven_v - speed_mm_per_s / limits.mm_per_s_per_v
    borne_a = min(max(driving_v / limits.volts_per_a, -most_a), most_a)
    offset = state.offset_a
    still = abs(speed_mm_per_s) < STILL_MM_PER_S
    if told and still and abs(borne_a) < 0.5 * most_a / MOST_RATIO:
        offset += (current - borne_a) * (dt_s / OFFSET_S)
    force = state.force_n + share * (limits.newton_per_a * current - state.force_n)
    inertia = limits.moving_mass_kg / (MM_PER_M * SETTLING_S) * gained_mm_per_s
    share_settled = dt_s / SETTLING_S
    resistance = state.resistance_n + (force - state.resistance_n) * share_settled - inertia
    speeding = state.inertia_n - state.inertia_n * share_settled + inertia
    return DriveForce(
        force_n=drop_tiny(force),
        resistance_n=drop_tiny(resistance),
        borne_n=drop_tiny(state.borne_n + share * (limits.newton_per_a * borne_a - state.borne_n)),
        offset_a=drop_tiny(offset),
        inertia_n=drop_tiny(speeding),
    )


@compiled
def is_against(state: DriveForce) -> bool:
    """True where the motor's force is against its volts', as with swapped wires."""
    measured_n, asked_n = state.force_n, state.borne_n
    inwards = measured_n > AGAINST_N and asked_n < -AGAINST_N
    return inwards or (measured_n < -AGAINST_N and asked_n > AGAINST_N)


@compiled
def is_yielding(state: DriveForce) -> bool:
    """True where the motor is told to pull and does, or has no current, and the head slows by it.

    What it pulls beyond what slows the head works against friction; a reading that goes in although
    the motor pulls would have it helped.
    """
    pulling = state.borne_n < -AGAINST_N and state.force_n < SLACK_N
    return pulling and state.resistance_n > -(AGAINST_N + unsure_n(state))


@compiled
def unsure_n(state: DriveForce) -> float:
    """Uncertainty of the resistance: the inertia is known to `INERTIA_SHARE`."""
    return INERTIA_SHARE * abs(state.inertia_n)


@compiled
def is_above(state: DriveForce, force_n: float, limit_n: float) -> bool:
    """True where a force is above a limit, either way, and the motor's volts bear it out."""
    borne_n = state.borne_n if force_n >= 0.0 else -state.borne_n
    return abs(force_n) > limit_n and borne_n > BORNE_SHARE * limit_n
