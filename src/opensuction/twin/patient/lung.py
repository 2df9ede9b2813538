"""One lung: elastic, with units that close quickly when pressure is lost and reopen slowly.

A closed unit no longer holds gas at any pressure, so the same pressure goes with less volume:
``pressure = (volume - relaxed volume + closed volume) / compliance``. Closing therefore pushes gas
out through the airway; none is lost from the books.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.denormals import drop_tiny

SEALED = 0.5
"""Share of the residual volume at which collapsed airways let nothing pass; assumed."""


class Lung(NamedTuple):
    """Mechanics of lung and chest wall together."""

    compliance_ml_per_cmh2o: float
    resistance_cmh2o_s_per_ml: float
    """Of the airways below the tube."""
    relaxed_ml: float
    """Gas volume at zero pressure with every unit open."""
    residual_ml: float
    """Below this volume the airways collapse around the catheter."""
    closing_cmh2o: float
    """Elastic pressure below which units begin to close."""
    closable_ml: float
    """Volume of all units that can close."""
    half_closing_cmh2o: float
    """Pressure lost below ``closing_cmh2o`` that in the end closes half of them."""
    closing_s: float
    """Time constant of closing."""
    opening_s: float
    """Time constant of reopening."""


class LungState(NamedTuple):
    """State of the lung."""

    volume_ml: float
    """All gas in it."""
    closed_ml: float
    """Volume of closed units."""


@compiled
def pressure_cmh2o(lung: Lung, state: LungState) -> float:
    """Elastic pressure of the lung (alveolar pressure)."""
    held = state.volume_ml - lung.relaxed_ml + state.closed_ml
    return held / lung.compliance_ml_per_cmh2o


@compiled
def removable_ml_per_s(lung: Lung, state: LungState, suction_ml_per_s: float, dt_s: float) -> float:
    """Suction that really draws gas: all of it until the lung is down to its residual volume.

    From there ever less, and none once half of that is left: collapsed airways seal the catheter.
    """
    wanted = max(suction_ml_per_s, 0.0)
    least = SEALED * lung.residual_ml
    spare = max(state.volume_ml - least, 0.0)
    return wanted * min(spare / (lung.residual_ml - least + wanted * dt_s), 1.0)


@compiled
def step(lung: Lung, state: LungState, flow_ml_per_s: float, dt_s: float) -> LungState:
    """Advance by one step in which gas flowed in at a constant rate; closing by backward Euler."""
    lost = max(lung.closing_cmh2o - pressure_cmh2o(lung, state), 0.0)
    final = lung.closable_ml * lost / (lost + lung.half_closing_cmh2o)
    time_constant_s = lung.opening_s
    if final > state.closed_ml:
        time_constant_s = lung.closing_s
    share = dt_s / (time_constant_s + dt_s)
    return LungState(
        volume_ml=state.volume_ml + flow_ml_per_s * dt_s,
        closed_ml=drop_tiny(state.closed_ml + share * (final - state.closed_ml)),
    )
