"""Self-calibration over a day: each contact measures the gap, the next cycle compensates it.

The governor's bounds stay those of the identified gap (docs/decisions/0007). A gap out of the range
that they hold for, or one that the protocol cannot be done with, lets no further cycle begin.
"""

from typing import NamedTuple

from opensuction.controller import setup
from opensuction.controller.calibration import Calibration
from opensuction.controller.record import Settings
from opensuction.identification.estimator.gap_scale import TRUSTED, ScaleRecord
from opensuction.kernel.errors import InputError
from opensuction.safety.condition import Condition
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import self_calibration
from opensuction.simulation.closed_loop import LoopState
from opensuction.simulation.trace import Columns


class Learning(NamedTuple):
    """What self-calibration knows and has changed so far."""

    identified: Calibration
    """As the laser found it, scale 1."""
    settings: Settings
    """The controller's on that calibration; its limits never change."""
    record: ScaleRecord
    """The last change of the scale."""
    refusal: str | None
    """Why no further cycle may begin."""


def begun(prepared: Prepared) -> Learning:
    """Before the first cycle: the identified gap, and nothing learned."""
    unchanged = ScaleRecord(1.0, float("nan"), 1.0, TRUSTED, in_range=True)
    return Learning(prepared.calibration, prepared.loop.controller, unchanged, None)


def learned(learning: Learning, prepared: Prepared, columns: Columns) -> Learning:
    """After a completed cycle: what its contact says, and whether another may begin."""
    profile = prepared.rig.profile
    record = self_calibration.learned(
        profile, learning.identified, learning.record.new, columns, TRUSTED
    )
    refusal = None if record.in_range else out_of_range(record)
    return learning._replace(record=record, refusal=refusal)


def out_of_range(record: ScaleRecord) -> str:
    """Why a scale out of its range ends the day, in one sentence."""
    said = Condition.CALIBRATION_OUT_OF_RANGE.row
    limits = record.limits
    return (
        f"{said.sentence}: the contact says {record.estimated:.2f} times as wide, and "
        f"{limits.least:g} to {limits.most:g} is what the tip's bounds hold for"
    )


def applied(
    learning: Learning, prepared: Prepared, state: LoopState
) -> tuple[Prepared, LoopState, Learning]:
    """The parked machine with what was learned; with a refusal where the next cycle cannot be done.

    Nothing is changed between ticks of a cycle.
    """
    if learning.record.new == learning.record.old:
        return prepared, state, learning
    rig, kind = prepared.rig, prepared.resolved.compensation
    used = self_calibration.rescaled(learning.identified, learning.record)
    try:
        planned = setup.settings(
            rig.profile, prepared.protocol, kind, used, by_contact=True, site=rig.site
        )
        planned = self_calibration.bounded(planned, learning.settings)
    except InputError as refused:
        scale = learning.record.new
        refusal = f"a gap {scale:.2f} times as wide as identified cannot be compensated: {refused}"
        return prepared, state, learning._replace(refusal=refusal)
    planned = setup.with_schedule(planned, prepared.loop.controller.service.schedule)
    loop = prepared.loop._replace(controller=planned)
    following = prepared._replace(calibration=used, loop=loop)
    return following, self_calibration.parked_anew(loop, state), learning
