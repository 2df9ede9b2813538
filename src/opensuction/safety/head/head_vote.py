"""Position of the catheter head by a vote of its two sensors and the motor's model.

The encoder sits on the motor, the second sensor on the head itself, behind gear and rack. The
third voice is the motor: volts less the drop of the current in the winding are its back-EMF, which
gives its speed. None of the three decides alone. A reading that no head can have come to is bridged
by those that agree; a sensor that stays odd is voted out, and named, until a person resets. What
both sensors say against all expectation is believed after some ticks: readings that begin to come
late do that.

Speed of the insertion motor from its voltage and its current: a head sensor of its own.

Volts less the drop of the current in the winding are the back-EMF, which is proportional to speed.

The zero of the sensor on the catheter head, learnt where the head stands at home.

It is mounted by hand, some tenths of a millimetre off, and the gear has play: at home after a way
out the head lies on the same side of it each time.
"""

from typing import NamedTuple

from opensuction.kernel.arithmetic import count_ticks, drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings, is_number
from opensuction.kernel.record import make_zero
from opensuction.safety.invalid_ticks import INVALID_TICKS, NEVER_TICKS
from opensuction.safety.limits import DriveLimits

SATURATED_SHARE = 0.55
"""Share of the drive's highest force from which its current limit, not its voltage, rules: of the
limit that is a fault, which is 1.3 times its own; the limit may be 7 % lower, the force for an
ampere 10 % more, and the current sensor read 4 % less [computed]."""


@compiled
def is_limited(limits: DriveLimits, current_a: float) -> bool:
    """True where the drive's current limit rules, so that its voltage says nothing of its speed."""
    return abs(limits.newton_per_a * current_a) >= SATURATED_SHARE * limits.force_n


@compiled
def turn(
    limits: DriveLimits,
    before_mm_per_s: float,
    driven_v: float,
    current_a: float,
    measured_mm_per_s: float,
    dt_s: float,
) -> float:
    """Speed of the motor after volts were put on it.

    While the drive's current limit rules, its voltage says nothing: then it gains speed as such a
    drive can at least and at most, and within that as fast as was measured of the head.
    """
    fastest = limits.mm_per_s_per_v * limits.supply_v
    least = limits.gaining_least_mm_per_s2 * dt_s
    most = limits.gaining_most_mm_per_s2 * dt_s
    gained = measured_mm_per_s - before_mm_per_s
    if not is_limited(limits, current_a):
        speed = limits.mm_per_s_per_v * (driven_v - limits.volts_per_a * current_a)
        gained = min(max(speed - before_mm_per_s, -most), most)
    elif current_a > 0.0:
        gained = min(max(gained, least), most)
    else:
        gained = max(min(gained, -least), -most)
    return min(max(before_mm_per_s + gained, -fastest), fastest)


JUMP_MM = 0.15
"""Further than that no head is from where it was expected a tick ago: 1.25 times the fastest 62
mm/s, stopped or begun at once, are 0.08 mm; encoder steps and wear on top [computed]."""
CARRIAGE_MM = 0.35
"""How far the second sensor is from the encoder in a sound machine: play to either side up to 0.25
mm, half of its step 0.1 mm [computed]; its zero is learnt at home."""
DRAW_SHARE = 0.02
"""Share of what lies between them by which a position that goes on by the motor is drawn to the
second sensor in a tick: within 50 ms it is where that has it, to its steps [design]."""
BAD_TICKS = 4
"""What an odd tick counts against one that agrees: a fifth of them, and no more than that, is
ridden out for ever [design]."""
OUT_TICKS = 40
"""Ten odd ticks in a row vote a sensor out: longer than a contact bounces, and at 62 mm/s the head
moves 0.6 mm meanwhile [design]."""
SURPRISED_TICKS = 3
"""For how many ticks both sensors, or the only one left, must tell the unexpected; assumed."""
FORGET_S = 0.3
"""Time over which a sensor's motion is held against the motor's: at 10 mm/s it has gone 3 mm, three
times what both may be apart [computed]."""
LEAD_MM = 0.3
"""Difference between motor and sensor that decides: three steps of the second sensor; a motor 3 %
faster than it should be is 0.1 mm off at 10 mm/s [computed]."""
DECIDED_RATIO = 2.0
"""And how much nearer to the motor the other sensor must be [design]."""


class HeadVote(NamedTuple):
    """Vote of encoder, carriage sensor and motor on the head's position, with their deviations."""

    head_mm: float
    """Where the head is taken to be."""
    least_mm: float
    most_mm: float
    """How far in it is at least and at most by either sensor that is heard: the same number where
    both are sound."""
    jumped_mm: float
    """How far that moved in this tick other than the head can have: taken over, not travelled."""
    driven_v: float
    """Volts that the motor had in the last tick."""
    motor_mm_per_s: float
    """Speed of the motor by volts and current."""
    encoder_lead_mm: float
    """How far the encoder has run ahead of the motor over the last `FORGET_S`."""
    carriage_lead_mm: float
    """The same of the sensor on the head."""
    encoder_mm: float
    """Last numbers of both."""
    carriage_mm: float
    encoder_odd: int
    """Odd ticks of the encoder, as `BAD_TICKS` counts them."""
    surprised_ticks: int
    """For how long all that is heard has told what was not expected."""
    encoder_out: bool
    """Voted out: not used until a person resets."""
    carriage_out: bool
    switched: bool
    """In this tick it was taken from the other sensor, this one being voted out."""
    unseen_ticks: int
    """For how long neither sensor has told where the head is."""
    zero_mm: float
    """What the sensor on the head reads more than the encoder at home: see `home_zero`."""
    zero_ticks: int
    """For how long the head has stood there."""


def start(head_mm: float, *, read: bool) -> HeadVote:
    """At power-up, the head read or assumed at ``head_mm``."""
    return make_zero(
        HeadVote,
        head_mm=head_mm,
        least_mm=head_mm,
        most_mm=head_mm,
        encoder_mm=head_mm,
        carriage_mm=head_mm,
        unseen_ticks=0 if read else NEVER_TICKS,
    )


def first_mm(readings: Readings) -> float:
    """Position of the head by the first readings after power-up; not a number where none tells.

    Of two that differ the deeper one: what may be inside is drawn out.
    """
    told = [
        value
        for value, valid in (
            (readings.head_mm, readings.head_valid),
            (readings.carriage_mm, readings.carriage_valid),
        )
        if valid and is_number(value)
    ]
    if len(told) == 2 and abs(told[0] - told[1]) <= CARRIAGE_MM:
        return told[0]  # the encoder is the finer one
    return max(told, default=float("nan"))


@compiled
def bear_out(head_mm: float, carriage_mm: float) -> float:
    """A position as far as the second sensor bears it out."""
    return min(max(head_mm, carriage_mm - CARRIAGE_MM), carriage_mm + CARRIAGE_MM)


@compiled
def is_fine(state: HeadVote) -> bool:
    """True where the encoder has the head's position, to its step: forces can be told from that."""
    return state.head_mm == state.encoder_mm and state.unseen_ticks == 0


@compiled
def _count_odd(odd: int, agrees: bool) -> int:
    return max(odd - 1, 0) if agrees else min(odd + BAD_TICKS, OUT_TICKS)


@compiled
def _follow(lead_mm: float, moved_mm: float, motor_mm: float, dt_s: float) -> float:
    """A sensor's lead over the motor a tick on."""
    return drop_tiny(lead_mm + moved_mm - motor_mm - lead_mm * (dt_s / FORGET_S))


@compiled
def _is_clearly_odd(lead_mm: float, other_mm: float) -> bool:
    """True where a sensor is further from the motor than the other one, by far."""
    return abs(lead_mm) > LEAD_MM and abs(lead_mm) > DECIDED_RATIO * abs(other_mm)


@compiled
def _hold_against_motor(
    limits: DriveLimits,
    state: HeadVote,
    readings: Readings,
    driven: bool,
    driven_v: float,
    speed_mm_per_s: float,
    dt_s: float,
) -> HeadVote:
    """Both sensors' motion held against the motor's. Without torque nothing is known of that."""
    encoder_mm, carriage_mm = state.encoder_mm, state.carriage_mm
    if readings.head_valid and is_number(readings.head_mm):
        encoder_mm = readings.head_mm
    if readings.carriage_valid and is_number(readings.carriage_mm):
        carriage_mm = readings.carriage_mm - state.zero_mm
    speed, encoder_lead_mm, carriage_lead_mm = 0.0, 0.0, 0.0
    if driven:
        current = readings.insertion_current_a if is_number(readings.insertion_current_a) else 0.0
        speed = turn(limits, state.motor_mm_per_s, driven_v, current, speed_mm_per_s, dt_s)
        encoder_moved_mm = encoder_mm - state.encoder_mm
        carriage_moved_mm = carriage_mm - state.carriage_mm
        motor_mm = speed * dt_s
        if is_limited(limits, current):
            # Its speed is the measured one then, and would bear out the sensor that was taken
            # from: what the two differ by counts against both alike.
            motor_mm += 0.5 * (carriage_moved_mm - encoder_moved_mm)
        encoder_lead_mm = _follow(state.encoder_lead_mm, encoder_moved_mm, motor_mm, dt_s)
        carriage_lead_mm = _follow(state.carriage_lead_mm, carriage_moved_mm, motor_mm, dt_s)
    return state._replace(
        driven_v=driven_v,
        motor_mm_per_s=speed,
        encoder_lead_mm=encoder_lead_mm,
        carriage_lead_mm=carriage_lead_mm,
        encoder_mm=encoder_mm,
        carriage_mm=carriage_mm,
    )


@compiled
def _vote_out(state: HeadVote, readings: Readings, apart: bool) -> HeadVote:
    """Vote one of the two out: odd for too long, or further from the motor than the other by far.

    apart: both have not been at the same place for too long.
    """
    both = not (state.encoder_out or state.carriage_out)
    if not both or not (apart or state.encoder_odd >= OUT_TICKS):
        return state
    encoder_mm, carriage_mm = state.encoder_lead_mm, state.carriage_lead_mm
    odd = state.encoder_odd >= OUT_TICKS or _is_clearly_odd(encoder_mm, carriage_mm)
    out = odd and readings.carriage_valid and is_number(readings.carriage_mm)
    return state._replace(
        encoder_out=out,
        carriage_out=not odd and _is_clearly_odd(carriage_mm, encoder_mm),
        switched=out,
    )


@compiled
def _find(state: HeadVote, encoder: bool, carriage: bool) -> HeadVote:
    """Position of the head after it was not seen for long: of two that differ the deeper one.

    What it moved meanwhile it has travelled; from one sensor to the other it has not.
    """
    head_mm = state.encoder_mm if encoder else state.carriage_mm
    if encoder and carriage and abs(state.encoder_mm - state.carriage_mm) > CARRIAGE_MM:
        head_mm = max(state.encoder_mm, state.carriage_mm)
    jumped_mm = head_mm - state.head_mm if state.switched else 0.0
    return state._replace(
        head_mm=head_mm, least_mm=head_mm, most_mm=head_mm, jumped_mm=jumped_mm, unseen_ticks=0
    )


@compiled
def _locate(
    state: HeadVote, encoder: bool, carriage: bool, expected_mm: float, reach_mm: float
) -> HeadVote:
    """Position of the head in this tick, of the sensors that are heard, one at least.

    expected_mm: where it should be by its last speed. reach_mm: further from it it cannot be.
    """
    encoder_mm, carriage_mm = state.encoder_mm, state.carriage_mm
    likely = encoder and abs(encoder_mm - expected_mm) <= reach_mm
    near = carriage and abs(carriage_mm - expected_mm) <= reach_mm + CARRIAGE_MM
    unopposed = encoder != carriage or abs(encoder_mm - carriage_mm) <= CARRIAGE_MM
    surprised = unopposed and not likely and (encoder or not near)
    surprised_ticks = count_ticks(state.surprised_ticks, surprised)
    convinced = surprised_ticks >= SURPRISED_TICKS
    odd = _count_odd(state.encoder_odd, likely or not encoder)
    travelled = likely and odd + state.encoder_odd == 0
    head_mm = expected_mm
    if encoder and (convinced or (likely and odd == 0)):
        head_mm = encoder_mm
    elif convinced or (near and not surprised):
        # Alone, the second sensor has it to its steps; an encoder that is odd may come back.
        drawn_mm = 0.0 if encoder else DRAW_SHARE * (carriage_mm - expected_mm)
        head_mm = bear_out(expected_mm + drawn_mm, carriage_mm)
    return state._replace(
        head_mm=head_mm,
        jumped_mm=0.0 if travelled else head_mm - expected_mm,
        encoder_odd=odd,
        surprised_ticks=0 if convinced else surprised_ticks,
        unseen_ticks=0,
    )


@compiled
def step(
    limits: DriveLimits,
    before: HeadVote,
    readings: Readings,
    driven: bool,
    driven_v: float,
    speed_mm_per_s: float,
    apart: bool,
    dt_s: float,
) -> HeadVote:
    """Bring it up to this tick.

    driven: the drive had torque in the last tick, and ``driven_v`` on its motor. speed_mm_per_s:
    averaged, of the head. apart: both sensors have not been at the same place for too long.
    """
    state = _hold_against_motor(limits, before, readings, driven, driven_v, speed_mm_per_s, dt_s)
    state = _vote_out(state._replace(switched=False), readings, apart)
    encoder = readings.head_valid and is_number(readings.head_mm) and not state.encoder_out
    carriage = (
        readings.carriage_valid and is_number(readings.carriage_mm) and not state.carriage_out
    )
    if not encoder and not carriage:
        return state._replace(jumped_mm=0.0, unseen_ticks=count_ticks(state.unseen_ticks, True))
    if state.switched or state.unseen_ticks >= INVALID_TICKS:
        return _find(state, encoder, carriage)
    ticks = 1 + state.unseen_ticks
    sound = encoder and state.encoder_odd == 0
    expected_mm_per_s = speed_mm_per_s if sound else state.motor_mm_per_s
    expected_mm = state.head_mm + expected_mm_per_s * dt_s * ticks
    state = _locate(state, encoder, carriage, expected_mm, JUMP_MM * ticks)
    head_mm = state.head_mm
    return state._replace(
        least_mm=min(head_mm, state.carriage_mm + CARRIAGE_MM) if carriage else head_mm,
        most_mm=max(head_mm, state.carriage_mm - CARRIAGE_MM) if carriage else head_mm,
    )


@compiled
def reset(state: HeadVote) -> HeadVote:
    """After a person's reset both sensors are heard again; where they differ the deeper one."""
    return state._replace(
        encoder_lead_mm=0.0,
        carriage_lead_mm=0.0,
        encoder_odd=0,
        surprised_ticks=0,
        encoder_out=False,
        carriage_out=False,
        unseen_ticks=max(state.unseen_ticks, INVALID_TICKS),
    )


MOST_MM = 0.6
"""More than that is no zero: mounting 0.4 mm, play 0.08, half of the sensor's step and its noise
0.1 [computed]."""
HOME_MM = 1.0
"""Nearer than this to its park position the head is home; a servo settles within 0.25; assumed."""
STILL_TICKS = 20
"""For how long the encoder must stand still."""
LEARN_S = 0.02
"""Time constant over which it is learnt: the pre-use test is at home for longer."""


@compiled
def learn(
    vote: HeadVote, before: HeadVote, readings: Readings, park_head_mm: float, dt_s: float
) -> HeadVote:
    """The vote with the zero learnt further. before: of the last tick. readings: of this one."""
    read = readings.carriage_valid and is_number(readings.carriage_mm)
    off_mm = readings.carriage_mm - vote.encoder_mm
    heard = vote.unseen_ticks == 0 and not (vote.encoder_out or vote.carriage_out) and read
    home = abs(vote.encoder_mm - park_head_mm) <= HOME_MM and abs(off_mm) <= MOST_MM
    still = vote.encoder_mm == before.encoder_mm
    ticks = min(count_ticks(vote.zero_ticks, heard and home and still), STILL_TICKS)
    if ticks < STILL_TICKS:
        return vote._replace(zero_ticks=ticks)
    zero_mm = vote.zero_mm + (off_mm - vote.zero_mm) * (dt_s / (LEARN_S + dt_s))
    # What has been read so far is read anew with it: a zero that moves is no motion of the head.
    return vote._replace(
        zero_mm=zero_mm, zero_ticks=ticks, carriage_mm=readings.carriage_mm - zero_mm
    )
