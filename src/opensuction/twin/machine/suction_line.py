"""Pump, regulator, relief valve, canister and catheter bore: the vacuum and the gas it moves.

One volume (canister and tubing) in front of the suction valve, isothermal: gas that flows in
raises its pressure towards the atmosphere, the pump lowers it. Flows are counted at atmospheric
pressure. The 2 m bore flows turbulently (Reynolds number 6,000 to 9,000), so its flow grows with
the root of the pressure difference.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.denormals import drop_tiny


class SuctionLine(NamedTuple):
    """Parameters of the suction line."""

    pump_free_ml_per_s: float
    """Free-air flow of the pump."""
    pump_occluded_mmhg: float
    """Vacuum at which the pump moves nothing."""
    regulator_ml_per_s_per_mmhg: float
    """Air the regulator lets in for each mmHg above its set point."""
    relief_mmhg: float
    """Mechanical relief valve, independent of the regulator."""
    relief_ml_per_s_per_mmhg: float
    mmhg_per_ml: float
    """Pressure that one mL of free air adds in the canister: atmosphere over volume."""
    bore_ml_per_s_per_root_mmhg: float
    """Free-air flow through valve and open catheter for each root of the vacuum in mmHg."""
    leak_ml_per_s_per_mmhg: float
    pump_runs_away: bool
    """Whether the pump runs whatever is commanded."""


class SuctionState(NamedTuple):
    """State of the suction line."""

    vacuum_mmhg: float
    """Below atmosphere, positive, in the canister."""
    gas_ml_per_s: float
    """Gas drawn through the tip, at atmospheric pressure."""
    gas_ml: float
    """Total of it."""


@compiled
def bore_flow_ml_per_s(line: SuctionLine, vacuum_mmhg: float, open_ratio: float) -> float:
    """Free-air flow through the catheter for a vacuum behind the valve.

    open_ratio: valve opening times the share of the tip that is free of mucus, 0 to 1.
    """
    return open_ratio * line.bore_ml_per_s_per_root_mmhg * math.sqrt(max(vacuum_mmhg, 0.0))


@compiled
def step(
    line: SuctionLine,
    state: SuctionState,
    pump_on: bool,
    setpoint_mmhg: float,
    open_ratio: float,
    lost_mmhg: float,
    dt_s: float,
) -> SuctionState:
    """Advance the line by one tick.

    setpoint_mmhg: regulator; open_ratio: see `bore_flow_ml_per_s`; lost_mmhg: vacuum that mucus in
    the bore takes. Backward Euler in the stiff regulator and relief terms, so that no gain of
    theirs can make the tick unstable.
    """
    vacuum = state.vacuum_mmhg
    drawn = bore_flow_ml_per_s(line, vacuum - lost_mmhg, open_ratio)
    pumped = 0.0
    if pump_on or line.pump_runs_away:
        pumped = line.pump_free_ml_per_s * max(1.0 - vacuum / line.pump_occluded_mmhg, 0.0)
    rise = dt_s * line.mmhg_per_ml
    free = vacuum + rise * (pumped - drawn)
    stiffness = rise * line.leak_ml_per_s_per_mmhg
    source = 0.0
    if free > setpoint_mmhg:
        gain = rise * line.regulator_ml_per_s_per_mmhg
        stiffness += gain
        source += gain * setpoint_mmhg
    if free > line.relief_mmhg:
        gain = rise * line.relief_ml_per_s_per_mmhg
        stiffness += gain
        source += gain * line.relief_mmhg
    return SuctionState(
        vacuum_mmhg=drop_tiny(max((free + source) / (1.0 + stiffness), 0.0)),
        gas_ml_per_s=drawn,
        gas_ml=state.gas_ml + drawn * dt_s,
    )
