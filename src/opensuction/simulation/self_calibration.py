"""Self-calibration between cycles: what a contact cycle taught, carried into the next cycle.

The compensation learns, the governor does not: see docs/decisions/0007.
"""

import numpy as np

from opensuction.control import compensation
from opensuction.controller.calibration import Calibration
from opensuction.controller.machine_profile import MachineProfile
from opensuction.controller.record import Settings
from opensuction.hysteresis import prandtl_ishlinskii
from opensuction.identification.estimator import gap_scale
from opensuction.identification.estimator.gap_scale import ScaleLimits, ScaleRecord
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import NO_REQUESTS
from opensuction.safety import tip_bound
from opensuction.simulation import closed_loop, trace
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.rig import Rig
from opensuction.simulation.trace import Columns
from opensuction.twin.machine.transmission import bundle

PARKING_S = 1.0
"""Time in which a parked head goes to its new park position; a few mm take .2 s."""


def with_widths(chosen: Rig, scale: float = 1.0, shift_mm: float = 0.0) -> Rig:
    """The same machine, its conduit routed otherwise behind the controller's back.

    Every gap width is multiplied and then enlarged. The drawn values keep what was drawn.
    """
    transmission = chosen.machine.transmission
    widths = bundle(max(scale * width + shift_mm, 0.0) for width in transmission.widths_mm)
    moved = transmission._replace(widths_mm=widths)
    return chosen._replace(machine=chosen.machine._replace(transmission=moved))


def learned(
    profile: MachineProfile,
    identified: Calibration,
    old: float,
    columns: Columns,
    limits: ScaleLimits = gap_scale.TRUSTED,
) -> ScaleRecord:
    """What a recorded cycle says of the gap, from switch and encoder alone.

    identified: as the laser found it, scale 1. old: the scale that the cycle ran with.
    """
    moving = np.isin(columns["phase"], (Phase.INSERTING, Phase.BACKING_OFF))
    seen = None
    if np.any(columns["phase"] == Phase.BACKING_OFF):
        seen = gap_scale.find_contact(
            columns["readings.contact_closed"][moving],
            columns["readings.head_mm"][moving],
            DT_S,
            profile.contact_latency_s,
        )
    return gap_scale.update(identified.plays, old, seen, limits)


def rescaled(identified: Calibration, record: ScaleRecord) -> Calibration:
    """Calibration for the next cycle: the identified plays with the scale of the record."""
    return identified._replace(plays=prandtl_ishlinskii.scale_widths(identified.plays, record.new))


def bounded(learned: Settings, identified: Settings) -> Settings:
    """Settings for a learned gap, held by the governor's limits of the identified one.

    learned, identified: of the same protocol on the same machine. Of the limits only the position
    where a forced withdrawal ends may move, and only farther out.
    Raises InputError where the head would park so far in that the governor could not take the tip
    to be outside.
    """
    held = identified.limits
    parked_mm = learned.limits.park_head_mm
    deepest_mm = tip_bound.deepest_mm(held.tip, tip_bound.assume_anywhere(held.tip, parked_mm))
    if deepest_mm > held.outside_mm:
        raise InputError(
            f"the head would park at {parked_mm:.1f} mm on the learned gap, where the tip may be "
            f"at {deepest_mm:.1f} mm, and outside the patient ends at {held.outside_mm:.1f} mm: "
            "calibrate the machine anew"
        )
    return learned._replace(
        limits=held._replace(park_head_mm=min(held.park_head_mm, parked_mm)),
    )


def parked_anew(loop: Loop, state: LoopState) -> LoopState:
    """A parked loop under new settings: it begins again from a retract to where its head is."""
    settings = loop.controller
    here = settings.parked._replace(head_mm=state.controller.core.governor.last.head_mm)
    head = compensation.park(settings.compensation, here)
    state = state._replace(controller=state.controller._replace(compensation=head))
    return closed_loop.run(loop, state, NO_REQUESTS, trace.rows(PARKING_S))[0]
