"""Self-calibration over a day: each contact measures the gap, the next cycle compensates it.

The governor's bounds stay those of the identified gap (docs/decisions/0007). A gap out of the range
that they hold for, or one that the protocol cannot be done with, lets no further cycle begin.
"""

from typing import NamedTuple

from opensuction.control.compensation import KIND_OF_NAME, ON_PLAYS, CompensationKind
from opensuction.controller import setup
from opensuction.controller.record import Settings
from opensuction.controller.setup import Calibration
from opensuction.identification.estimator.gap_scale import TRUSTED, ScaleRecord
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning.clinical import Template
from opensuction.procedure.planning.protocol import Protocol
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


def check(
    found: Protocol | Template, kind: CompensationKind, by_contact: bool, repeat: int
) -> None:
    """Refuse self-calibration where nothing could be learned or used; raises InputError."""
    if not by_contact:
        raise InputError(
            "--self-calibrate measures the gap where the tip touches the carina: add "
            "--approach contact"
        )
    if repeat < 2:
        raise InputError(
            "--self-calibrate is for the next cycle: add --repeat 2 or more, and --every MIN"
        )
    if kind not in ON_PLAYS:
        known = " or ".join(name for name, other in KIND_OF_NAME.items() if other in ON_PLAYS)
        name = kind.name.lower().replace("_", "-")
        raise InputError(
            f"--self-calibrate finds a scale of play widths, and compensation '{name}' has none: "
            f"use {known}"
        )
    if found.backoff_mm <= 0.0:
        raise InputError(
            f"--self-calibrate needs a reversal at the carina, and backoff_mm is "
            f"{found.backoff_mm:g} mm: set it to 1 mm or more"
        )


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
    rig = prepared.rig
    used = self_calibration.rescaled(learning.identified, learning.record)
    try:
        planned = setup.settings(
            rig.profile, prepared.protocol, prepared.kind, used, by_contact=True, site=rig.site
        )
        planned = self_calibration.bounded(planned, learning.settings)
    except InputError as refused:
        scale = learning.record.new
        refusal = f"a gap {scale:.2f} times as wide as identified cannot be compensated: {refused}"
        return prepared, state, learning._replace(refusal=refusal)
    planned = setup.scheduled(planned, prepared.loop.controller.service.schedule)
    loop = prepared.loop._replace(controller=planned)
    following = prepared._replace(calibration=used, loop=loop)
    return following, self_calibration.parked_anew(loop, state), learning
