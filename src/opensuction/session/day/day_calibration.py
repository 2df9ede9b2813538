"""Self-calibration over a day: each cycle tells of gap and tip, the next cycle compensates that.

The governor's bounds stay those of the identified gap (docs/decisions/0007). A transmission out of
what they hold for, or one that the protocol cannot be done with, lets no further cycle begin.
"""

import math
from typing import NamedTuple

from opensuction.controller import calibration, setup
from opensuction.controller.calibration import Calibration
from opensuction.controller.record import Settings
from opensuction.hysteresis import prandtl_ishlinskii
from opensuction.identification.estimator.adaptation import (
    AdaptationChange,
    branch_scales,
    unchanged,
)
from opensuction.identification.estimator.gap_measurement import TRUSTED, Shift
from opensuction.kernel.errors import InputError
from opensuction.safety.condition import Condition
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import self_calibration
from opensuction.simulation.closed_loop import LoopState
from opensuction.simulation.trace import Columns


class Learning(NamedTuple):
    """State of the self-calibration, and its changes so far."""

    identified: Calibration
    """As the laser found it."""
    settings: Settings
    """The controller's on that calibration; its limits never change."""
    change: AdaptationChange
    """The last one."""
    refusal: str | None
    """Why no further cycle may begin."""


def begun(prepared: Prepared) -> Learning:
    """Before the first cycle: the identified transmission, and nothing learned."""
    return Learning(prepared.calibration, prepared.loop.controller, unchanged(TRUSTED), None)


def learned(learning: Learning, prepared: Prepared, columns: Columns) -> Learning:
    """After a completed cycle: what it showed, and whether another may begin."""
    mouth_mm = learning.settings.limits.mouth_mm
    profile, kind = prepared.rig.profile, prepared.resolved.compensation
    # The governor's limit of the pressure at the connector: no ventilator's breath goes there.
    cough_cmh2o = learning.settings.limits.patient.airway_most_cmh2o
    seen = self_calibration.seen(profile, kind, learning.identified, mouth_mm, columns, cough_cmh2o)
    change = calibration.learn(learning.identified, learning.change, seen)
    gap_mm = prandtl_ishlinskii.gap_mm(learning.identified.plays)
    refusal = None if change.in_range else out_of_range(change, gap_mm)
    return learning._replace(change=change, refusal=refusal)


def out_of_range(change: AdaptationChange, gap_mm: float) -> str:
    """Sentence on a transmission out of range, which ends the day. gap_mm: identified."""
    sentence, limits = Condition.CALIBRATION_OUT_OF_RANGE.row.sentence, change.limits
    scale, deeper_mm = change.found
    holds = f"{limits.least:g} to {limits.most:g} is what the tip's bounds hold for"
    if math.isnan(change.seen.mouth.scale) and deeper_mm == 0.0:
        return f"{sentence}: the contact says {scale:.2f} times as wide, and {holds}"
    inwards, outwards = branch_scales(change.found, gap_mm)
    witness = "the light barrier says" if change.found == change.seen.mouth else "together it is"
    return (
        f"{sentence}: {witness} {scale:.2f} times as wide and the tip "
        f"{depth_words(deeper_mm)}; inwards that is where a gap {inwards:.2f} times as wide has "
        f"it, outwards {outwards:.2f}, and {holds}"
    )


def depth_words(deeper_mm: float) -> str:
    """Depth of the tip against the identified one, in words."""
    return f"{abs(deeper_mm):.1f} mm {'shallower' if deeper_mm < 0.0 else 'deeper'}"


def _refused(shift: Shift, why: InputError) -> str:
    return (
        f"a gap {shift.scale:.2f} times as wide as identified with the tip "
        f"{depth_words(shift.offset_mm)} cannot be compensated: {why}"
    )


def _replanned(
    learning: Learning, prepared: Prepared, shift: Shift
) -> tuple[Settings, Calibration]:
    """Settings that go by a shift, and its calibration; InputError where it cannot be done."""
    rig, used = prepared.rig, calibration.adapted(learning.identified, shift)
    planned = self_calibration.replanned(
        rig.profile,
        prepared.protocol,
        prepared.resolved.compensation,
        used,
        prepared.resolved.by_contact,
        rig.site,
        learning.settings,
    )
    return planned, used


def applied(
    learning: Learning, prepared: Prepared, state: LoopState
) -> tuple[Prepared, LoopState, Learning]:
    """The parked machine with what was learned; with a refusal where the next cycle cannot be done.

    Nothing is changed between ticks of a cycle.
    """
    change = learning.change
    if change.new == change.old:
        return prepared, state, learning
    try:
        planned, used = _replanned(learning, prepared, change.new)
    except InputError as refused:
        # What a posture makes of the gap is over with the next: the usual gap is gone by then.
        usual = change.new._replace(scale=change.course.usual)
        try:
            planned, used = _replanned(learning, prepared, usual)
        except InputError:
            return prepared, state, learning._replace(refusal=_refused(change.new, refused))
        learning = learning._replace(change=change._replace(new=usual))
    kind = prepared.resolved.compensation
    planned = setup.with_schedule(planned, prepared.loop.controller.service.schedule)
    loop = prepared.loop._replace(controller=planned, heads_mm=setup.branches(kind, used))
    following = prepared._replace(calibration=used, loop=loop)
    return following, self_calibration.parked_anew(loop, state), learning
