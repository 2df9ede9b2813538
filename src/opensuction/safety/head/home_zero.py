"""The zero of the sensor on the catheter head, learnt where the head stands at home.

It is mounted by hand, some tenths of a millimetre off, and the gear has play: at home after a way
out the head lies on the same side of it each time.
"""

from opensuction.kernel.compiled import compiled
from opensuction.kernel.duration import count
from opensuction.kernel.readings import Readings, is_number
from opensuction.safety.head.head_vote import HeadVote

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
    ticks = min(count(vote.zero_ticks, heard and home and still), STILL_TICKS)
    if ticks < STILL_TICKS:
        return vote._replace(zero_ticks=ticks)
    zero_mm = vote.zero_mm + (off_mm - vote.zero_mm) * (dt_s / (LEARN_S + dt_s))
    # What has been read so far is read anew with it: a zero that moves is no motion of the head.
    return vote._replace(
        zero_mm=zero_mm, zero_ticks=ticks, carriage_mm=readings.carriage_mm - zero_mm
    )
