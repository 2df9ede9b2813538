"""Where the machine meets the bedside: what passes between 1 kHz and 100 Hz, and nothing else.

Between two steps of the bedside the gas and the mucus that the tip takes are added up, so that
none is lost at the coupling; the bedside feels them a hundredth of a second late at most. The other
way go what the patient shows and how much mucus lies within reach of the tip.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.monitor import ABSENT, Monitor

TICKS = 10
"""Ticks of the machine for each step of the bedside."""


class Shown(NamedTuple):
    """What the patient shows since the bedside's last step; 0 where nobody is there."""

    airway_pressure_cmh2o: float
    lung_volume_ml: float
    lung_volume_loss_ml: float
    spo2_percent: float
    heart_rate_per_min: float
    monitor: Monitor
    """What the monitor passes on."""


NOBODY_SHOWN = Shown(0.0, 0.0, 0.0, 0.0, 0.0, ABSENT)


class CouplingState(NamedTuple):
    """What has passed since the bedside's last step."""

    ticks: int
    gas_ml: float
    """Gas that the tip drew inside the patient, at atmospheric pressure."""
    mucus_ml: float
    """Mucus that the tip took."""
    reachable_ml: float
    """Mucus still within reach of where the tip was then."""
    from_mm: float
    """Where the tip was then."""
    shown: Shown


@compiled
def accumulate(state: CouplingState, gas_ml: float, mucus_ml: float) -> CouplingState:
    """The coupling after one tick in which the tip took this much."""
    return state._replace(
        ticks=state.ticks + 1,
        gas_ml=state.gas_ml + gas_ml,
        mucus_ml=state.mucus_ml + mucus_ml,
        reachable_ml=max(state.reachable_ml - mucus_ml, 0.0),
    )
