"""Exchange between the machine at 1 kHz and the bedside at 100 Hz; nothing else passes.

Gas and mucus that the tip takes are summed between two steps of the bedside, so that none is lost;
the bedside gets them a hundredth of a second late at most. The machine gets the patient's signs and
the volume of mucus within reach of the tip.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Monitor
from opensuction.kernel.record import make_zero

TICKS = 10
"""Ticks of the machine for each step of the bedside."""


class PatientSigns(NamedTuple):
    """Signs of the patient at the bedside's last step; 0 on the bench, which has no patient."""

    airway_pressure_cmh2o: float
    """In the trachea, below the tube."""
    lung_volume_ml: float
    """Above residual volume."""
    lung_volume_loss_ml: float
    """End-expiratory volume lost against the start, smoothed over a breath."""
    spo2_percent: float
    """As the oximeter shows it, late."""
    heart_rate_per_min: float
    monitor: Monitor
    """What the monitor passes on."""
    muscle_cmh2o: float
    """Pressure of the patient's muscles on the lung: a cough pushes, an own breath pulls."""
    relaxed_pressure_cmh2o: float
    """Pressure in the trachea, had the muscles never moved."""
    relaxed_loss_ml: float
    """Volume lost, likewise."""


NO_SIGNS = make_zero(PatientSigns)


class CouplingState(NamedTuple):
    """Exchange between machine and bedside since the bedside's last step."""

    ticks: int
    gas_ml: float
    """Gas that the tip drew inside the patient, at atmospheric pressure."""
    mucus_ml: float
    """Mucus that the tip took."""
    reachable_ml: float
    """Mucus still within reach of where the tip was then."""
    from_mm: float
    """Where the tip was then."""
    carina_shift_mm: float
    """How much deeper the carina is than at the start: the patient coughs and is moved."""
    gap_ratio: float
    """Gap of the conduit over that at the start."""
    signs: PatientSigns


@compiled
def accumulate(state: CouplingState, gas_ml: float, mucus_ml: float) -> CouplingState:
    """The coupling after one tick in which the tip took this much."""
    return state._replace(
        ticks=state.ticks + 1,
        gas_ml=state.gas_ml + gas_ml,
        mucus_ml=state.mucus_ml + mucus_ml,
        reachable_ml=max(state.reachable_ml - mucus_ml, 0.0),
    )
