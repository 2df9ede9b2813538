"""Self-calibration between cycles: what a contact cycle taught, carried into the next cycle."""

import numpy as np

from opensuction.controller.machine_profile import MachineProfile
from opensuction.controller.setup import Calibration
from opensuction.hysteresis import prandtl_ishlinskii
from opensuction.identification import gap_scale
from opensuction.identification.gap_scale import ScaleLimits, ScaleRecord
from opensuction.kernel.phase import Phase
from opensuction.simulation.bench import Rig
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns


def with_widths(chosen: Rig, scale: float = 1.0, shift_mm: float = 0.0) -> Rig:
    """The same machine, its conduit routed otherwise behind the controller's back.

    Every gap width is multiplied and then enlarged. The drawn values keep what was drawn.
    """
    transmission = chosen.machine.transmission
    widths = np.maximum(scale * transmission.widths_mm + shift_mm, 0.0)
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
        seen = gap_scale.episode(
            columns["readings.contact_closed"][moving],
            columns["readings.head_mm"][moving],
            DT_S,
            profile.contact_latency_s,
        )
    return gap_scale.update(identified.plays, old, seen, limits)


def rescaled(identified: Calibration, record: ScaleRecord) -> Calibration:
    """Calibration for the next cycle: the identified plays with the scale of the record."""
    return identified._replace(plays=prandtl_ishlinskii.scaled(identified.plays, record.new))
