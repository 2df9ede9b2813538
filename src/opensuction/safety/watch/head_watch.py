"""Motion of the head, tick by tick: its speed, the forces on it, its obedience to the commands."""

from opensuction.kernel.arithmetic import count_ticks, drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings, Setpoints
from opensuction.safety.head import drive_force, head_vote
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.invalid_ticks import INVALID_TICKS, InvalidTicks
from opensuction.safety.limits import Limits, follow, step
from opensuction.safety.watch.watch_state import Watch

SPEED_WINDOW_S = 0.01
"""Time constant over which the measured head speed is averaged."""
APART_MM = 1.0
"""Distance between motor and catheter head that no sound gear has: play to either side up to 0.25
mm, half of the carriage sensor's step 0.1 mm, and the rest for wear; assumed."""
APART_SUCKING_MM = 0.3
"""The same with the valve open, where a head that goes in strips mucosa: play to either side 0.1
mm, half of the sensor's step 0.05 mm, 0.06 mm for messages 1 ms apart at 62 mm/s, and the rest for
wear. The head goes in by less than the 0.5 mm that are allowed until a frozen, drifting or reversed
encoder is told."""
PARTING_MM = 0.2
"""Way that the encoder has gone in more than the second sensor within the vote's memory: play from
one side to the other 0.1 mm, and the sensor's step 0.1 mm [computed]."""
OVERSPEED_RATIO = 1.25
"""Measured head speed over its limit that no sound machine reaches: the limit is the no-load speed
of the fastest one, and the encoder's step adds 0.5 mm/s to the average [computed]."""
ADRIFT_MM = 0.2
"""Way of both sensors within the vote's memory that the motor cannot have gone: 0.7 mm/s at rest
[computed]."""
MODEL_LAG_S = 0.01
"""And more for each mm/s of the motor: one that is 3 % too fast is as far off [computed]."""
RUNAWAY_MM = 1.0
"""Advance of the head against its command, beyond what it needs to brake: servo and backlash."""
RUNAWAY_SUCKING_MM = 0.3
"""And while the valve is not closed: only the servo's ripple, for no cycle turns inwards then; the
tip may advance by 0.5 mm."""


@compiled
def is_disagreeing(
    readings: Readings, vote: HeadVote, invalid: InvalidTicks, sucking: bool
) -> bool:
    """True where motor and catheter head are further apart than the gear's play lets them be.

    An encoder that has been voted out tells nothing of the motor any more.
    """
    off_mm = abs(readings.head_mm - (readings.carriage_mm - vote.zero_mm))
    apart_mm = APART_SUCKING_MM if sucking else APART_MM
    both = invalid.head == 0 and invalid.carriage == 0 and not vote.encoder_out
    return both and off_mm > apart_mm


@compiled
def is_adrift(vote: HeadVote) -> bool:
    """True where both sensors run away from the motor together, as their common zero would."""
    adrift_mm = ADRIFT_MM + MODEL_LAG_S * abs(vote.motor_mm_per_s)
    encoder_mm, carriage_mm = vote.encoder_lead_mm, vote.carriage_lead_mm
    inwards = encoder_mm > adrift_mm and carriage_mm > adrift_mm
    return inwards or (encoder_mm < -adrift_mm and carriage_mm < -adrift_mm)


@compiled
def _is_parting(seen: Watch) -> bool:
    """True where the encoder is going in without the head: the two sensors will show it.

    Less than they may be apart bears no runaway out, and no more is needed while the valve is open.
    """
    vote = seen.vote
    both = seen.invalid.head + seen.invalid.carriage == 0
    heard = both and not (vote.encoder_out or vote.carriage_out)
    return heard and vote.encoder_lead_mm - vote.carriage_lead_mm > PARTING_MM


@compiled
def move(
    limits: Limits,
    before: Watch,
    seen: Watch,
    last: Setpoints,
    current_a: float,
    sucking: bool,
    dt_s: float,
) -> Watch:
    """Speed, force and advance of the head, and where the tip can be behind it.

    Of the forces nothing is known without torque, nor right after the head was not seen.
    """
    head_mm, ticks = seen.head_mm, before.vote.unseen_ticks
    unseen = ticks >= INVALID_TICKS
    share = dt_s / (SPEED_WINDOW_S + dt_s)
    moved_mm = head_mm - before.head_mm - seen.vote.jumped_mm
    gained = share * (moved_mm / (dt_s * (1 + ticks)) - before.speed_mm_per_s)  # mean of a dropout
    drive = drive_force.rest(before.drive)
    if not last.insertion_on and not unseen:
        drive = drive_force.learn(
            limits.drive, before.drive, current_a, before.speed_mm_per_s, dt_s
        )
    elif head_vote.is_fine(before.vote) and head_vote.is_fine(seen.vote):
        drive = drive_force.step(
            limits.drive,
            before.drive,
            current_a,
            seen.vote.driven_v,
            before.speed_mm_per_s,
            gained,
            share,
            dt_s,
        )
    advance = step(
        limits.braking_mm_per_s2,
        # A servo on a wrong reading may have brought the head to any speed that it has.
        limits.head_speed_mm_per_s if seen.vote.switched else 0.0,
        before.advance,
        last,
        seen.vote.most_mm,
        seen.vote.jumped_mm,
        unseen or seen.vote.switched,
        dt_s,
    )
    speed = drop_tiny(before.speed_mm_per_s + gained)
    fastest = OVERSPEED_RATIO * limits.head_speed_mm_per_s
    too_fast = seen.vote.encoder_odd == 0 and abs(speed) > fastest  # what jumps has no speed
    # Under vacuum counts what it has gone in since: a servo that rings may be beyond its command
    # by more when the valve opens, and comes back.
    beyond_mm = seen.vote.least_mm - advance.head_mm
    under_vacuum_mm = seen.vote.least_mm - max(advance.head_mm, seen.suction_start_mm)
    far = beyond_mm > RUNAWAY_MM or (sucking and under_vacuum_mm > RUNAWAY_SUCKING_MM)
    too_far = far and not _is_parting(seen)
    return seen._replace(
        speed_mm_per_s=speed,
        tip=follow(limits.tip, before.tip, head_mm),
        advance=advance,
        runaway_ticks=count_ticks(before.runaway_ticks, too_far),
        overspeed_ticks=count_ticks(before.overspeed_ticks, too_fast),
        drive=drive,
    )
