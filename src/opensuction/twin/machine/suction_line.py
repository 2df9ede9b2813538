"""Pump, regulator, relief valve, canister and catheter bore: the vacuum and the gas it moves.

One volume (canister and tubing) in front of the suction valve, isothermal: gas that flows in
raises its pressure towards the atmosphere, the pump lowers it. Flows are counted at atmospheric
pressure. The 2 m bore flows turbulently (Reynolds number 6,000 to 9,000), so its flow grows with
the root of the pressure difference.

Mucus in the catheter's bore: where it lies, the pressure that it takes, its way to the canister.

What the tip has taken lies as plugs, gas between them, evenly from a tail to a front; both move
with the flow, and what passes the bore's end is in the canister. The plugs fill the bore over
their length, so they take pressure as a thick fluid in a pipe does: below its yield stress it
does not move at all, above it the loss grows with the flow, but less than in proportion, for
mucus thins as it is sheared (Herschel and Bulkley, the yield simply added).
With the valve closed nothing flows, and mucus stays where it is until the next suction.
"""

import math
from typing import NamedTuple

from opensuction.kernel.arithmetic import drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero
from opensuction.kernel.unit import PA_PER_MMHG

FLOW_INDEX = 0.35
"""Loss grows with this power of the flow; [K] .2 to .5 for mucus."""
STATED_PER_S = 100.0
"""Shear rate for which viscosity is stated."""
LEAST_PER_S = 1.0
"""Slower shear thickens no more; [assumed], so that a plug at rest can begin to move."""
PROFILE = math.pow((3.0 * FLOW_INDEX + 1.0) / (4.0 * FLOW_INDEX), FLOW_INDEX)
"""Steeper flow profile of a thinning fluid at the wall (Rabinowitsch)."""
UPTAKE_MM = 50.0
"""Plug whose drag the uptake at the tip already holds [calc-plug]."""
MM3_PER_ML = 1000.0


class Bore(NamedTuple):
    """The bore and the mucus that comes into it."""

    volume_ml: float
    """From tip to canister; 19.2 mL in the paper's catheter."""
    diameter_mm: float
    viscosity_pa_s: float
    """Of the mucus at 100 /s."""
    yield_pa: float
    """Stress below which it does not move."""


class BoreState(NamedTuple):
    """Content of the bore, and of the canister behind it."""

    mucus_ml: float
    tail_ml: float
    """Bore between the tip and the nearest mucus."""
    front_ml: float
    """Bore between the tip and the farthest mucus."""
    canister_ml: float
    """Liquid in the canister."""
    drag_mmhg_s_per_ml: float
    """Pressure that thick plugs take for each mL/s, at the viscosity of the flow of this tick: the
    next one goes by it. The flow settles from tick to tick, for the loss grows with less than it.
    """


EMPTY = make_zero(BoreState)


@compiled
def area_mm2(bore: Bore) -> float:
    """Cross-section."""
    return 0.25 * math.pi * bore.diameter_mm * bore.diameter_mm


@compiled
def plug_mm(bore: Bore, mucus_ml: float) -> float:
    """Length of bore that a volume of mucus fills."""
    return MM3_PER_ML / area_mm2(bore) * mucus_ml


@compiled
def holding_mmhg(bore: Bore, mucus_ml: float) -> float:
    """Pressure below which plugs do not move: ``4 tau L / D``."""
    # Divided by what does not change from tick to tick: a division waits for the one before.
    return 4.0 * bore.yield_pa / (bore.diameter_mm * PA_PER_MMHG) * plug_mm(bore, mucus_ml)


@compiled
def drag_mmhg_s_per_ml(bore: Bore, mucus_ml: float, flow_ml_per_s: float) -> float:
    """Pressure lost for each mL/s beyond that, at the viscosity of a given flow.

    Of the plugs beyond `UPTAKE_MM`: what those take is in the uptake and in the tip's free share.

    Hagen and Poiseuille: ``32 eta L v / D^2`` with the viscosity at the wall's shear rate 8 v / D.
    """
    beyond_mm = max(plug_mm(bore, mucus_ml) - UPTAKE_MM, 0.0)
    if beyond_mm == 0.0:  # spares the power
        return 0.0
    speed_mm_per_s = MM3_PER_ML * max(flow_ml_per_s, 0.0) / area_mm2(bore)
    shear_per_s = max(8.0 * speed_mm_per_s / bore.diameter_mm, LEAST_PER_S)
    thinned = math.pow(shear_per_s / STATED_PER_S, FLOW_INDEX - 1.0)
    viscosity = bore.viscosity_pa_s * PROFILE * thinned
    length = beyond_mm / (bore.diameter_mm * bore.diameter_mm)
    return 32.0 * viscosity * length * MM3_PER_ML / area_mm2(bore) / PA_PER_MMHG


@compiled
def lost_mmhg(
    bore: Bore, state: BoreState, vacuum_mmhg: float, ml_per_s_per_root_mmhg: float
) -> float:
    """Vacuum that the mucus in the bore takes; what is left moves gas and draws new mucus.

    vacuum_mmhg: behind the valve. ml_per_s_per_root_mmhg: flow of the bore without mucus for each
    root of the vacuum (turbulent). All of it where a plug holds.
    """
    held_mmhg = min(holding_mmhg(bore, state.mucus_ml), vacuum_mmhg)
    linear = state.drag_mmhg_s_per_ml * ml_per_s_per_root_mmhg
    if linear == 0.0:  # most ticks: spares the root
        return held_mmhg
    # x^2 + drag k x = pushed, with x^2 what is left and k x the flow.
    pushed = vacuum_mmhg - held_mmhg
    root = 2.0 * pushed / (linear + math.sqrt(linear * linear + 4.0 * pushed))
    return vacuum_mmhg - root * root


@compiled
def step_bore(
    bore: Bore, state: BoreState, entered_ml: float, flow_ml_per_s: float, dt_s: float
) -> BoreState:
    """Advance by one tick in which mucus came in at the tip and gas flowed behind it."""
    mucus = state.mucus_ml + entered_ml
    if mucus <= 0.0:
        return state
    moved = flow_ml_per_s * dt_s + entered_ml
    tail = 0.0 if entered_ml > 0.0 else state.tail_ml + moved
    front = state.front_ml + moved
    left = 0.0
    if front > bore.volume_ml:
        left = mucus * min((front - bore.volume_ml) / (front - tail), 1.0)
        front = bore.volume_ml
    if left >= mucus:
        tail = front = 0.0
    return BoreState(
        mucus_ml=mucus - left,
        tail_ml=tail,
        front_ml=front,
        canister_ml=state.canister_ml + left,
        drag_mmhg_s_per_ml=drag_mmhg_s_per_ml(bore, mucus - left, flow_ml_per_s),
    )


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
