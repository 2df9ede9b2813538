"""Changes of a plant after its identification, unknown to the controller: the benchmark's columns.

A transmission's gap, gain and offset drift with the conduit's route, with temperature and with how
the catheter is clamped; polymers creep; commands come late. The compensator is told of none.
"""

from typing import NamedTuple

import numpy as np

from opensuction.kernel.record import Array
from opensuction.twin import parameter, preset
from opensuction.twin.machine import creep
from opensuction.twin.machine.creep import Creep
from opensuction.twin.machine.transmission import Transmission


class Disturbance(NamedTuple):
    """A change after the identification; as it stands here, none."""

    name: str = "as identified"
    gap_ratio: float = 1.0
    """Of every gap width, or of the lag in its place."""
    gain_ratio: float = 1.0
    """Of the tip's travel, reckoned from the head's position 0."""
    offset_mm: float = 0.0
    """That the tip is farther in."""
    creep_ratio: float = 1.0
    """Of the twin's creep. A model plant has none, so that it gets this multiple of the bench's."""
    delay_s: float = 0.0
    """By which commands come late: the head's on an ideal servo, the drives' at a twin."""
    cycles: int = 0
    """So many cycles that taught the compensation by a light barrier went before, without contact;
    a model plant alone has the barrier."""


NOTHING = Disturbance()
DISTURBANCES = (
    Disturbance("gap +10 %", gap_ratio=1.1),
    Disturbance("gap -10 %", gap_ratio=0.9),
    Disturbance("gain +2 %", gain_ratio=1.02),
    Disturbance("gain -2 %", gain_ratio=0.98),
    Disturbance("offset +2 mm", offset_mm=2.0),
    Disturbance("offset -2 mm", offset_mm=-2.0),
    Disturbance("creep x4", creep_ratio=4.0),
    Disturbance("5 ms delay", delay_s=0.005),
    Disturbance("gap +10 %, two cycles on", gap_ratio=1.1, cycles=2),
    Disturbance("gap -10 %, two cycles on", gap_ratio=0.9, cycles=2),
    Disturbance("offset +2 mm, two cycles on", offset_mm=2.0, cycles=2),
    Disturbance("offset -2 mm, two cycles on", offset_mm=-2.0, cycles=2),
)
NAMES = tuple(one.name for one in DISTURBANCES)
MODEL_CREEP = preset.transmission_of(parameter.nominal(parameter.BENCH)).creep
"""Of the nominal bench."""


def _multiply(amplitudes: Creep, ratio: float) -> Creep:
    return amplitudes._replace(
        fast_mm=ratio * amplitudes.fast_mm, slow_mm=ratio * amplitudes.slow_mm
    )


def disturb_transmission(conduit: Transmission, disturbance: Disturbance) -> Transmission:
    """A twin's transmission with all but the delay."""
    widths = tuple(disturbance.gap_ratio * width for width in conduit.widths_mm)
    return conduit._replace(
        widths_mm=widths,
        lag_ratio=disturbance.gap_ratio * conduit.lag_ratio,
        gain=disturbance.gain_ratio * conduit.gain,
        offset_mm=conduit.offset_mm + disturbance.offset_mm,
        creep=_multiply(conduit.creep, disturbance.creep_ratio),
    )


def delay(head_mm: Array, disturbance: Disturbance, dt_s: float) -> Array:
    """Head positions as late as the disturbance has them; shape (n,), from rest."""
    ticks = round(disturbance.delay_s / dt_s)
    if ticks == 0:
        return head_mm
    return np.concatenate((np.full(ticks, head_mm[0]), head_mm[:-ticks]))


def disturb_tip(tip_mm: Array, at_head_0_mm: float, disturbance: Disturbance, dt_s: float) -> Array:
    """Tip positions of a model plant with gain, offset and creep changed; shape (n,).

    at_head_0_mm: its tip with the head at 0.
    """
    if disturbance.gain_ratio != 1.0:
        tip_mm = at_head_0_mm + disturbance.gain_ratio * (tip_mm - at_head_0_mm)
    if disturbance.offset_mm != 0.0:
        tip_mm = tip_mm + disturbance.offset_mm
    if disturbance.creep_ratio != 1.0:
        stronger = _multiply(MODEL_CREEP, disturbance.creep_ratio)
        tip_mm = tip_mm - creep.lag_mm(stronger, tip_mm, dt_s)
    return tip_mm
