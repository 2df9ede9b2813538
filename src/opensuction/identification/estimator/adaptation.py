"""What is believed of a changed transmission: evidence of a cycle, weighed, bounded and recorded.

Two witnesses: the contact with the carina tells the scale of the gap (`gap_scale`), the passages
of the light barrier tell scale and offset (`mouth_passage`). They are weighed by their errors. Two
that contradict each other are both left alone. What is trusted is what the governor's bounds on the
tip hold for: see docs/decisions/0007 and 0036.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from opensuction.identification.estimator import gap_scale
from opensuction.identification.estimator.gap_scale import ScaleLimits
from opensuction.identification.estimator.mouth_passage import (
    AS_IDENTIFIED,
    UNKNOWN,
    Missed,
    Shift,
)

MOUTH_ERROR = 0.01
"""Of a scale from the passages of the barrier: on the twin up to .011, .005 RMS."""
CONTACT_ERROR = gap_scale.MEASURING_ERROR
"""Of a scale from a contact, the patient lying still; a cough at the carina makes it .3."""
DEVIATIONS = 3.0
"""Two scales so many standard deviations apart contradict each other."""


class Finding(IntEnum):
    """What came of the evidence of a cycle."""

    NOTHING_SEEN = 0
    LEARNED = 1
    CONTRADICTION = 2
    """Contact and barrier do not tell the same: neither is believed."""
    OUT_OF_RANGE = 3
    """An alarm condition: the transmission has left what the bounds hold for, or was misread."""


class Evidence(NamedTuple):
    """What a cycle showed; nan where it showed nothing."""

    contact_scale: float
    mouth: Shift
    missed: Missed
    """Why the barrier told nothing."""


NO_EVIDENCE = Evidence(float("nan"), UNKNOWN, Missed.NO_BARRIER)


class Change(NamedTuple):
    """One change of what the compensation goes by, for the record."""

    old: Shift
    seen: Evidence
    found: Shift
    """From the evidence, before the bounds; nan where there was none or it contradicts itself."""
    new: Shift
    """What is used from now on: what was found, or the old where that cannot be believed."""
    limits: ScaleLimits
    finding: Finding

    @property
    def in_range(self) -> bool:
        """False is an alarm condition."""
        return self.finding != Finding.OUT_OF_RANGE


def unchanged(limits: ScaleLimits) -> Change:
    """Before the first cycle."""
    return Change(AS_IDENTIFIED, NO_EVIDENCE, UNKNOWN, AS_IDENTIFIED, limits, Finding.NOTHING_SEEN)


def branch_scales(shift: Shift, gap_mm: float) -> tuple[float, float]:
    """Scales of the gap that would put the way in, and the way out, where a shift puts them.

    gap_mm: identified, mm of tip between both. Inwards the tip lags by half of the gap, outwards it
    leads by that: an offset moves both, a scale moves them apart.
    """
    aside = 2.0 * shift.offset_mm / gap_mm
    return shift.scale - aside, shift.scale + aside


def is_trusted(shift: Shift, gap_mm: float, limits: ScaleLimits) -> bool:
    """Whether both ways are where the governor takes them to be possible."""
    return all(limits.least <= one <= limits.most for one in branch_scales(shift, gap_mm))


def weigh(seen: Evidence, old: Shift) -> Shift | None:
    """One shift from all that was seen; None where that contradicts itself.

    old: what is not seen stays as it is. Weights are inverse variances.
    """
    if math.isnan(seen.mouth.scale):
        return old if math.isnan(seen.contact_scale) else old._replace(scale=seen.contact_scale)
    if math.isnan(seen.contact_scale):
        return seen.mouth
    error = math.sqrt(MOUTH_ERROR * MOUTH_ERROR + CONTACT_ERROR * CONTACT_ERROR)
    if abs(seen.contact_scale - seen.mouth.scale) > DEVIATIONS * error:
        return None
    by_mouth, by_contact = (1.0 / (error * error) for error in (MOUTH_ERROR, CONTACT_ERROR))
    scale = (by_mouth * seen.mouth.scale + by_contact * seen.contact_scale) / (
        by_mouth + by_contact
    )
    return seen.mouth._replace(scale=scale)


def update(old: Shift, seen: Evidence, gap_mm: float, limits: ScaleLimits) -> Change:
    """What to use from now on, and what came of the evidence.

    old: in use. gap_mm: identified, mm of tip. Nothing seen is no alarm. A witness that is out of
    range by itself is one, whatever another says: neither that nor a bound of the range was
    measured, so the old stays.
    """
    alone = [AS_IDENTIFIED._replace(scale=seen.contact_scale), seen.mouth]
    told = [shift for shift in alone if not math.isnan(shift.scale)]
    if not told:
        return Change(old, seen, UNKNOWN, old, limits, Finding.NOTHING_SEEN)
    for shift in told:
        if not is_trusted(shift, gap_mm, limits):
            return Change(old, seen, shift, old, limits, Finding.OUT_OF_RANGE)
    found = weigh(seen, old)
    if found is None:
        return Change(old, seen, UNKNOWN, old, limits, Finding.CONTRADICTION)
    if not is_trusted(found, gap_mm, limits):
        return Change(old, seen, found, old, limits, Finding.OUT_OF_RANGE)
    return Change(old, seen, found, found, limits, Finding.LEARNED)
