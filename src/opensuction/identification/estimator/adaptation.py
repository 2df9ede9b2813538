"""Adaptation to a changed transmission: the evidence of a cycle, weighed, bounded and recorded.

There are two witnesses: contact with the carina shows the scale of the gap (`gap_scale`), the
passages of the light barrier show scale and offset (`mouth_passage`). They are weighted by their
errors. A patient who coughs or is moved while the tip touches spoils the contact, never the
barrier: where the two differ, the one that agrees with what was known before is believed. A finding
of one witness alone that no move of the patient explains is dropped, and believed once the next
cycle repeats it. Scale and offset are trusted only where the governor's bounds on the tip hold: see
docs/decisions/0007, 0036 and 0037.

The gap of a conduit over a day: what the patient's postures make of it, and what a hand did.

A patient who is moved bends the conduit: its gap is another one until the next move, around the
same mean. A conduit that was laid otherwise has another mean. So the gap of the next cycle is
expected between the one that was measured last, for the patient may lie as before, and the mean
over the postures so far. How often the patient is moved is not known: it is counted in the
measurements that are alike. Without that, following the last one alone, a patient who is moved
before each cycle is tracked worse by 1.4 than by the identified gap.
Source: [calc-gap-course].
"""

import math
from enum import IntEnum
from typing import NamedTuple

from opensuction.identification.estimator import gap_measurement
from opensuction.identification.estimator.gap_measurement import (
    AS_IDENTIFIED,
    UNKNOWN,
    Missed,
    ScaleLimits,
    Shift,
)

POSTURE_RATIO = 0.04
"""[assumed] Standard deviation of the gap over a patient's postures, as a share of it."""
POSTURE_MOST = 0.14
"""What no posture changes the gap by: ten thirds of its deviation, and an error of measurement."""
LAID_RATIO = 0.06
"""Difference from which on the conduit was laid otherwise, in the first cycle and where the patient
lies still: one and a half deviations of a posture [design]."""
QUIET = 0.83
"""Share of cycles before which the patient had not moved, from which on he lies still [design]."""
ALIKE = 0.02
"""Two measurements as near as that are of one posture: two errors of the barrier."""
IDENTIFIED_POSTURES = 6.0
"""What the gap that was identified, or found anew, counts as in the mean over postures [design]."""
MOST_POSTURES = 20.0
"""The mean is over no more: a gap that wears is followed."""
STILL, COMPARED = 1.0, 2.0
"""Patients lie as before in one of two cycles, before anything is known of them [design]."""
SHIFTED_POSTURES = 3
"""So many postures on one side tell of a conduit that was laid otherwise."""
SHIFTED_DEVIATIONS = 2.5
"""Their mean is off by more standard deviations of a mean than chance brings [design]."""


class GapCourse(NamedTuple):
    """Course of the gap over a day, as a multiple of the identified one."""

    usual: float = 1.0
    """Mean over the postures since the conduit was laid as it is."""
    postures: float = IDENTIFIED_POSTURES
    """How many that mean counts as."""
    last: float = math.nan
    """Measured last; nan before the first."""
    still: float = STILL
    """Measurements that were as the one before."""
    compared: float = COMPARED
    recent: tuple[float, ...] = ()
    """The last postures, at most `SHIFTED_POSTURES`, since the mean was begun anew."""


def is_by_posture(course: GapCourse, scale: float) -> bool:
    """True where a move of the patient can have made the gap that wide."""
    return abs(scale - course.usual) <= POSTURE_MOST


def _begin_anew(course: GapCourse, usual: float, postures: float) -> GapCourse:
    return course._replace(usual=usual, postures=postures, recent=())


def follow(course: GapCourse, scale: float) -> GapCourse:
    """The course after another measured scale."""
    first = math.isnan(course.last)
    alike = not first and abs(scale - course.last) <= ALIKE
    quiet = course.still >= QUIET * course.compared
    most = LAID_RATIO if first or quiet else POSTURE_MOST
    laid_otherwise = abs(scale - course.usual) > most
    course = course._replace(
        last=scale,
        still=course.still + alike,
        compared=course.compared + (not first),
    )
    if laid_otherwise:
        return _begin_anew(course, scale, IDENTIFIED_POSTURES)
    if alike:
        return course
    recent = (*course.recent, scale)[-SHIFTED_POSTURES:]
    mean = sum(recent) / len(recent)
    chance = POSTURE_RATIO / math.sqrt(SHIFTED_POSTURES)
    shifted = abs(mean - course.usual) > SHIFTED_DEVIATIONS * chance
    if len(recent) == SHIFTED_POSTURES and shifted:
        return _begin_anew(course, mean, float(SHIFTED_POSTURES))
    usual = course.usual + (scale - course.usual) / (course.postures + 1.0)
    postures = min(course.postures + 1.0, MOST_POSTURES)
    return course._replace(usual=usual, postures=postures, recent=recent)


def expected(course: GapCourse) -> float:
    """The scale to go by in the next cycle."""
    if math.isnan(course.last):
        return course.usual
    still = course.still / course.compared
    return still * course.last + (1.0 - still) * course.usual


MOUTH_ERROR = 0.01
"""Of a scale from the passages of the barrier: on the twin up to .011, .005 RMS."""
CONTACT_ERROR = gap_measurement.MEASURING_ERROR
"""Of a scale from a contact, the patient lying still; a move at the carina makes it anything."""
DEVIATIONS = 3.0
"""Two scales so many standard deviations apart contradict each other."""
SAID_AGAIN_MM = 1.0
"""Two offsets as near as that say the same: the barrier errs by .08 mm [design]."""


class Finding(IntEnum):
    """Finding on the evidence of a cycle."""

    NOTHING_SEEN = 0
    LEARNED = 1
    CONTRADICTION = 2
    """Contact and barrier do not tell the same, and nothing tells who is right: neither is
    believed."""
    OUT_OF_RANGE = 3
    """An alarm condition: the transmission has left what the bounds hold for, or was misread."""
    DOUBTED = 4
    """One witness alone says what no move of the patient explains: dropped, unless it says so
    again."""


class Spoilt(IntEnum):
    """Reason why a contact that was felt tells nothing of the gap; `SPOILT` has the words."""

    NOTHING = 0
    """It tells of the gap."""
    COUGHED = 1
    UNSTEADY = 2
    MOVED = 3


SPOILT = {
    Spoilt.NOTHING: "",
    Spoilt.COUGHED: "the patient coughed while the tip touched",
    Spoilt.UNSTEADY: "the switch opened and closed again while the tip touched",
    Spoilt.MOVED: "the light barrier and the cycles before say otherwise: the patient moved while "
    "the tip touched",
}


class Evidence(NamedTuple):
    """Evidence of a cycle; nan where it showed nothing."""

    contact_scale: float
    mouth: Shift
    missed: Missed
    """Why the barrier told nothing."""
    spoilt: Spoilt = Spoilt.NOTHING
    """Why the contact tells nothing, as far as it shows that by itself."""


NO_EVIDENCE = Evidence(float("nan"), UNKNOWN, Missed.NO_BARRIER)


class AdaptationChange(NamedTuple):
    """One change of what the compensation goes by, for the record."""

    old: Shift
    seen: Evidence
    """As it was weighed: `spoilt` also where only the barrier shows it."""
    found: Shift
    """From the evidence, before the bounds; nan where there was none or it contradicts itself."""
    new: Shift
    """What is used from now on: by what was found, or the old where that cannot be believed."""
    limits: ScaleLimits
    finding: Finding
    course: GapCourse = GapCourse()
    doubted: Shift = UNKNOWN
    """What was dropped in this cycle and would be believed in the next."""

    @property
    def in_range(self) -> bool:
        """False is an alarm condition."""
        return self.finding != Finding.OUT_OF_RANGE


def unchanged(limits: ScaleLimits) -> AdaptationChange:
    """Before the first cycle."""
    return AdaptationChange(
        AS_IDENTIFIED, NO_EVIDENCE, UNKNOWN, AS_IDENTIFIED, limits, Finding.NOTHING_SEEN
    )


def branch_scales(shift: Shift, gap_mm: float) -> tuple[float, float]:
    """Scales of the gap that would put the way in, and the way out, where a shift puts them.

    gap_mm: identified, mm of tip between both. Inwards the tip lags by half of the gap, outwards it
    leads by that: an offset moves both, a scale moves them apart.
    """
    aside = 2.0 * shift.offset_mm / gap_mm
    return shift.scale - aside, shift.scale + aside


def is_trusted(shift: Shift, gap_mm: float, limits: ScaleLimits) -> bool:
    """True where both ways are within the range that the governor takes to be possible."""
    return all(limits.least <= one <= limits.most for one in branch_scales(shift, gap_mm))


def _is_told(shift: Shift) -> bool:
    return not math.isnan(shift.scale)


def _look_closer(course: GapCourse, seen: Evidence, limits: ScaleLimits) -> Evidence:
    """The evidence, its contact spoilt where barrier and course of the gap show a move."""
    contact, mouth = seen.contact_scale, seen.mouth
    if seen.spoilt != Spoilt.NOTHING or math.isnan(contact) or not _is_told(mouth):
        return seen
    if not _contradict(contact, mouth.scale):
        return seen
    borne_out = is_by_posture(course, mouth.scale)
    impossible = not limits.least <= contact <= limits.most
    # A barrier that leaves its course is doubtful itself, unless the contact cannot be either.
    if borne_out or (impossible and limits.least <= mouth.scale <= limits.most):
        return seen._replace(spoilt=Spoilt.MOVED)
    return seen


def _contradict(contact_scale: float, mouth_scale: float) -> bool:
    error = math.sqrt(MOUTH_ERROR * MOUTH_ERROR + CONTACT_ERROR * CONTACT_ERROR)
    return abs(contact_scale - mouth_scale) > DEVIATIONS * error


def weigh(seen: Evidence, old: Shift) -> Shift | None:
    """One shift from all that was seen; None where that contradicts itself.

    old: what is not seen stays as it is. Weights are inverse variances. A spoilt contact is left
    out.
    """
    contact = math.nan if seen.spoilt != Spoilt.NOTHING else seen.contact_scale
    if not _is_told(seen.mouth):
        return UNKNOWN if math.isnan(contact) else old._replace(scale=contact)
    if math.isnan(contact):
        return seen.mouth
    if _contradict(contact, seen.mouth.scale):
        return None
    by_mouth, by_contact = (1.0 / (error * error) for error in (MOUTH_ERROR, CONTACT_ERROR))
    scale = (by_mouth * seen.mouth.scale + by_contact * contact) / (by_mouth + by_contact)
    return seen.mouth._replace(scale=scale)


def _is_said_again(before: Shift, now: Shift) -> bool:
    """True where a sensor repeats what was dropped a cycle ago, but for what a posture changes."""
    return (
        abs(now.scale - before.scale) <= POSTURE_MOST
        and abs(now.offset_mm - before.offset_mm) <= SAID_AGAIN_MM
    )


def _is_plain(before: AdaptationChange, seen: Evidence, found: Shift, trusted: bool) -> bool:
    """True where the finding is believed at once.

    Out of range two witnesses must agree; in range a contact without a barrier must be within what
    postures do.
    """
    limits = before.limits
    alone = math.isnan(seen.contact_scale) or seen.spoilt != Spoilt.NOTHING
    if trusted:
        return _is_told(seen.mouth) or is_by_posture(before.course, found.scale)
    both = not alone and _is_told(seen.mouth)
    return both and not limits.least <= found.scale <= limits.most


def update(before: AdaptationChange, seen: Evidence, gap_mm: float) -> AdaptationChange:
    """Adapt the transmission by the evidence of a cycle, and report the finding.

    before: after the last cycle. gap_mm: identified, mm of tip. Nothing seen is no alarm. What is
    out of range is not used: neither that nor a bound of the range was measured, so the old stays.
    """
    old, course, limits = before.new, before.course, before.limits
    seen = _look_closer(course, seen, limits)
    found = weigh(seen, old)
    change = before._replace(old=old, seen=seen, found=UNKNOWN, doubted=UNKNOWN)
    if found is None:
        return change._replace(finding=Finding.CONTRADICTION)
    if not _is_told(found):
        return change._replace(finding=Finding.NOTHING_SEEN, doubted=before.doubted)
    change, trusted = change._replace(found=found), is_trusted(found, gap_mm, limits)
    if not (_is_plain(before, seen, found, trusted) or _is_said_again(before.doubted, found)):
        return change._replace(finding=Finding.DOUBTED, doubted=found)
    if not trusted:
        return change._replace(finding=Finding.OUT_OF_RANGE)
    course = follow(course, found.scale)
    used = found._replace(scale=expected(course))
    if not is_trusted(used, gap_mm, limits):
        used = found
    return change._replace(new=used, finding=Finding.LEARNED, course=course)
