"""A person's hand at the catheter head of a twin that plays, while its drive has let go.

It pushes until it feels something and holds there; it draws back, or lets go, when it is told to:
whoever teaches the travel length confirms in between. Once the drive has torque again it lets go,
and stays away. See `twin.machine.hand`; asked for by
`twin_faults.hold`.
"""

import math
from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.machine.port import HandTask
from opensuction.twin.machine import hand
from opensuction.twin.machine.hand import AWAY, NOBODY, PUSHING, Hand, HandStage, HandState

HOLDS_S = 600.0
"""It holds the head until it is told what to do next; nobody has that much patience."""
PERSON = 5
"""Number of the person; those who teach in simulated runs have others."""


class Held(NamedTuple):
    """A hand and what it does now."""

    hand: Hand
    state: HandState


def held(task: HandTask, park_head_mm: float, quick_mm: float, seed: int) -> Held:
    """The hand that does it.

    park_head_mm: where it lets go on the way back. quick_mm: length of the way inside the tube.
    seed: draws the person. Raises InputError for what is no place.
    """
    if not (math.isfinite(park_head_mm) and math.isfinite(quick_mm)):
        raise InputError(f"a hand at {park_head_mm:g} mm, {quick_mm:g} mm quickly: no places")
    person = hand.draw(park_head_mm, quick_mm, seed, PERSON)
    if task == HandTask.PUSH:
        return Held(person._replace(hold_s=HOLDS_S), PUSHING)
    if task == HandTask.DRAW:
        return Held(person, AWAY._replace(stage=HandStage.PULLING.value))
    return Held(NOBODY, AWAY)
