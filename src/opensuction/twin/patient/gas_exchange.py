"""Oxygen: from the ventilator through dead space and alveoli into the blood, and used up.

Three stores: the dead space (mixed), the alveoli, and the venous blood with the tissue. Capillary
blood leaves in balance with the alveoli; shunted blood by-passes them, more of it the more lung is
closed. Carbon dioxide is not followed: it is taken to replace oxygen volume for volume, so gas
exchange does not change the lung's volume. Gas is counted at body temperature, saturated, less its
water vapour; blood as is usual at standard conditions.

One lung: elastic, with units that close quickly when pressure is lost and reopen slowly.

A closed unit no longer holds gas at any pressure, so the same pressure goes with less volume:
``pressure = (volume - relaxed volume + closed volume) / compliance``. Closing therefore pushes gas
out through the airway; none is lost from the books.
"""

from typing import NamedTuple

from opensuction.kernel.arithmetic import drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.twin.patient.ventilator import Airflow

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
def step_lung(lung: Lung, state: LungState, flow_ml_per_s: float, dt_s: float) -> LungState:
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


DRY_MMHG = 713.0
"""Atmosphere of 760 mmHg less 47 mmHg of water vapour at 37 C."""
BODY_PER_STANDARD = 863.0 / DRY_MMHG
"""Volume of one mL of dry gas at 0 C once it is in the lung: the 863 of the alveolar equation."""
DISSOLVED_PER_MMHG = 0.000031
"""Oxygen dissolved in blood, mL/mL/mmHg."""
SEVERINGHAUS_P50_MMHG = 26.9
SEVERINGHAUS = 23400.0
CRITICAL_CONTENT = 0.02
"""Venous content below which the tissue can no longer take what it needs; assumed."""
LARGEST_SHUNT = 0.9
STEP_SHARE = 0.1
"""Largest change of the arterial pressure in one step, as a share of it plus 1 mmHg."""


class GasExchange(NamedTuple):
    """Parameters of oxygen transport."""

    dead_space_ml: float
    """Trachea, tube and connector, with the alveoli that see no blood."""
    consumption_ml_per_s: float
    """Oxygen used, at standard conditions (VO2)."""
    output_ml_per_s: float
    """Cardiac output."""
    capacity: float
    """Oxygen bound by one mL of saturated blood, mL."""
    p50_mmhg: float
    """Oxygen pressure at half saturation."""
    venous_ml: float
    """Blood that stores oxygen on its way back, with the tissue's own store."""
    shunt: float
    """Share of blood that sees no alveolus, with all units open."""
    shunt_per_ml: float
    """Its growth for each mL of closed lung."""


class GasState(NamedTuple):
    """State of the oxygen stores."""

    dead_space_ratio: float
    """Oxygen fraction of dry gas in the dead space."""
    alveolar_o2_ml: float
    """Oxygen in the alveoli, as fraction of dry gas times volume."""
    alveolar_mmhg: float
    venous_content: float
    """mL of oxygen in one mL of mixed venous blood."""
    arterial_mmhg: float
    arterial_saturation: float
    """0 to 1."""


@compiled
def saturation(gas: GasExchange, oxygen_mmhg: float) -> float:
    """Share of haemoglobin that carries oxygen.

    Source: [Severinghaus-1979], S = 1 / (23400 / (P^3 + 150 P) + 1), with P scaled to the p50.
    """
    scaled = max(oxygen_mmhg, 0.0) * SEVERINGHAUS_P50_MMHG / gas.p50_mmhg
    power = scaled * (scaled * scaled + 150.0)
    return power / (power + SEVERINGHAUS)


@compiled
def content(gas: GasExchange, oxygen_mmhg: float) -> float:
    """Oxygen in one mL of blood, bound and dissolved, in mL."""
    return gas.capacity * saturation(gas, oxygen_mmhg) + DISSOLVED_PER_MMHG * oxygen_mmhg


@compiled
def content_slope(gas: GasExchange, oxygen_mmhg: float) -> float:
    """Change of `content` for one mmHg."""
    scale = SEVERINGHAUS_P50_MMHG / gas.p50_mmhg
    scaled = oxygen_mmhg * scale
    square = scaled * scaled
    whole = scaled * (square + 150.0) + SEVERINGHAUS
    bound = SEVERINGHAUS * (3.0 * square + 150.0) / (whole * whole)
    return gas.capacity * scale * bound + DISSOLVED_PER_MMHG


@compiled
def pressure_towards(gas: GasExchange, oxygen_mmhg: float, wanted_content: float) -> float:
    """One step of Newton's method for the pressure that has the wanted content.

    Content changes little in a hundredth of a second, so one step each keeps the pressure on it;
    the step is cut where the curve is flat.
    """
    missing = wanted_content - content(gas, oxygen_mmhg)
    largest = STEP_SHARE * (1.0 + oxygen_mmhg)
    change = missing / content_slope(gas, oxygen_mmhg)
    return max(oxygen_mmhg + min(max(change, -largest), largest), 0.0)


@compiled
def uptake_ml_per_s(gas: GasExchange, state: GasState, closed_ml: float) -> float:
    """Oxygen that passes from the alveoli into the blood, at standard conditions."""
    shunt = min(gas.shunt + gas.shunt_per_ml * closed_ml, LARGEST_SHUNT)
    perfused = gas.output_ml_per_s * (1.0 - shunt)
    return perfused * (content(gas, state.alveolar_mmhg) - state.venous_content)


@compiled
def consumed_ml_per_s(gas: GasExchange, state: GasState) -> float:
    """Oxygen that the tissue uses, at standard conditions: less once the blood has hardly any."""
    return gas.consumption_ml_per_s * min(state.venous_content / CRITICAL_CONTENT, 1.0)


@compiled
def step(
    gas: GasExchange,
    state: GasState,
    airflow: Airflow,
    oxygen_ratio: float,
    volume_ml: float,
    closed_ml: float,
    dt_s: float,
) -> GasState:
    """Advance by one step; upwind and implicit in the flows, so no oxygen is lost.

    oxygen_ratio: inspired oxygen. volume_ml: lung volume after the step.
    """
    # The stores are hundreds of times what passes in a step; the bound only guards a lung that
    # has been emptied.
    taken = min(
        uptake_ml_per_s(gas, state, closed_ml) * BODY_PER_STANDARD * dt_s,
        0.5 * state.alveolar_o2_ml,
    )
    fresh = max(airflow.tube_ml_per_s, 0.0) * dt_s
    inhaled = max(airflow.lung_ml_per_s, 0.0) * dt_s
    exhaled = max(-airflow.lung_ml_per_s, 0.0) * dt_s
    alveolar = (state.alveolar_o2_ml - taken) / (1.0 + exhaled / volume_ml)
    entering = fresh * oxygen_ratio + exhaled * alveolar / volume_ml
    dead_space = (gas.dead_space_ml * state.dead_space_ratio + entering) / (
        gas.dead_space_ml + fresh + exhaled
    )
    alveolar += inhaled * dead_space
    into_blood = taken / (BODY_PER_STANDARD * dt_s)
    arterial = pressure_towards(
        gas, state.arterial_mmhg, state.venous_content + into_blood / gas.output_ml_per_s
    )
    used = consumed_ml_per_s(gas, state)
    return GasState(
        dead_space_ratio=dead_space,
        alveolar_o2_ml=alveolar,
        alveolar_mmhg=DRY_MMHG * alveolar / volume_ml,
        venous_content=state.venous_content + (into_blood - used) * dt_s / gas.venous_ml,
        arterial_mmhg=arterial,
        arterial_saturation=saturation(gas, arterial),
    )
