"""The gap of a conduit over a day: what the patient's postures make of it, and what a hand did.

A patient who is moved bends the conduit: its gap is another one until the next move, around the
same mean. A conduit that was laid otherwise has another mean. So the gap of the next cycle is
expected between the one that was measured last, for the patient may lie as before, and the mean
over the postures so far. How often the patient is moved is not known: it is counted in the
measurements that are alike. Without that, following the last one alone, a patient who is moved
before each cycle is tracked worse by 1.4 than by the identified gap.
Source: [calc-gap-course].
"""

import math
from typing import NamedTuple

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
