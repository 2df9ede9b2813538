"""Ventilator in pressure control: what it offers to the airway at each moment.

It wants a pressure: PEEP, and above it the driving pressure during inspiration, approached
smoothly. It reaches what it wants only as far as gas allows. Against a leak such as suction it adds
flow in proportion to the missing pressure, up to a limit; beyond the limit nothing holds the
pressure, and the airway falls below PEEP and may fall below the atmosphere. The expiratory valve
can let gas out but never in. The patient makes no effort and triggers nothing.

Flows and pressures between ventilator, tube, trachea, catheter and lung.

Quasi-steady within a step: gas in tube and circuit has no inertia and no compliance worth a
hundredth of a second, and gas is incompressible (30 cmH2O are 3 % of an atmosphere). With the lung
at the middle of the step (implicit midpoint rule: second order, stable for every step) there is one
unknown, the flow through the tube, and it solves a quadratic equation: no iteration.
"""

import math
from typing import NamedTuple

from opensuction.kernel.arithmetic import drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero

ROOM_OXYGEN_RATIO = 0.21
"""Oxygen in the room's air."""


class Ventilator(NamedTuple):
    """Settings and mechanics of the ventilator."""

    peep_cmh2o: float
    driving_cmh2o: float
    """Inspiratory pressure above PEEP."""
    period_s: float
    """Duration of a breath."""
    inspiration_s: float
    """Duration of its inspiration."""
    rise_s: float
    """Time constant of the pressure at the start of an inspiration."""
    fall_s: float
    """Time constant of the expiratory valve's opening."""
    source_cmh2o_s_per_ml: float
    """Pressure missing for each mL/s delivered during inspiration."""
    peak_ml_per_s: float
    """Most gas delivered during inspiration."""
    droop_cmh2o_s_per_ml: float
    """Pressure missing for each mL/s of flow compensation during expiration."""
    compensation_ml_per_s: float
    """Most gas delivered during expiration."""
    valve_cmh2o_s_per_ml: float
    """Resistance of the expiratory limb."""
    oxygen_ratio: float
    """Inspired oxygen (FiO2)."""
    pressure_ratio: float
    """What it gives of the pressures it was set to: 1, but for a fault."""
    connected: bool
    """Whether the circuit is on the tube: otherwise the connector is open to the room."""


class VentilatorState(NamedTuple):
    """State of the ventilator."""

    breath_s: float
    """Time since the start of the breath."""
    target_cmh2o: float
    """Pressure it wants at the connector."""


class Supply(NamedTuple):
    """Supply of the ventilator during one step."""

    target_cmh2o: float
    source_cmh2o_s_per_ml: float
    limit_ml_per_s: float
    valve_cmh2o_s_per_ml: float


def at_rest(ventilator: Ventilator) -> VentilatorState:
    """State at the start of a breath."""
    return VentilatorState(breath_s=0.0, target_cmh2o=ventilator.peep_cmh2o)


@compiled
def is_inspiring(ventilator: Ventilator, state: VentilatorState) -> bool:
    """True while the ventilator is in its inspiration."""
    return state.breath_s < ventilator.inspiration_s


@compiled
def step(ventilator: Ventilator, state: VentilatorState, dt_s: float) -> VentilatorState:
    """Advance the ventilator's clock and the pressure it wants (a first-order approach)."""
    breath_s = state.breath_s + dt_s
    # Half a step of tolerance: rounding must not lengthen a breath by a step now and then.
    if breath_s > ventilator.period_s - 0.5 * dt_s:
        breath_s = max(breath_s - ventilator.period_s, 0.0)
    wanted = ventilator.peep_cmh2o
    approach_s = ventilator.fall_s
    if breath_s < ventilator.inspiration_s:
        wanted += ventilator.driving_cmh2o
        approach_s = ventilator.rise_s
    share = dt_s / (approach_s + dt_s)
    return VentilatorState(
        breath_s=breath_s,
        target_cmh2o=drop_tiny(state.target_cmh2o + share * (wanted - state.target_cmh2o)),
    )


@compiled
def supply(ventilator: Ventilator, state: VentilatorState) -> Supply:
    """Supply of the ventilator now; disconnected, the room offers gas without limit."""
    if not ventilator.connected:
        return Supply(
            target_cmh2o=0.0,
            source_cmh2o_s_per_ml=0.0,
            limit_ml_per_s=math.inf,
            valve_cmh2o_s_per_ml=0.0,
        )
    source = ventilator.droop_cmh2o_s_per_ml
    limit = ventilator.compensation_ml_per_s
    if is_inspiring(ventilator, state):
        source = ventilator.source_cmh2o_s_per_ml
        limit = ventilator.peak_ml_per_s
    return Supply(
        target_cmh2o=ventilator.pressure_ratio * state.target_cmh2o,
        source_cmh2o_s_per_ml=source,
        limit_ml_per_s=limit,
        valve_cmh2o_s_per_ml=ventilator.valve_cmh2o_s_per_ml,
    )


@compiled
def inspired_ratio(ventilator: Ventilator) -> float:
    """Oxygen in the gas that flows in through the tube."""
    return ventilator.oxygen_ratio if ventilator.connected else ROOM_OXYGEN_RATIO


class Airflow(NamedTuple):
    """Flows in mL/s and pressures in cmH2O during one step."""

    tube_ml_per_s: float
    """From the ventilator into the trachea; negative in expiration."""
    suction_ml_per_s: float
    """Out of the trachea into the catheter."""
    lung_ml_per_s: float
    """Into the lung: the difference of both."""
    trachea_cmh2o: float
    connector_cmh2o: float
    """Where the ventilator measures."""


def still(pressure_cmh2o: float) -> Airflow:
    """No flow, the same pressure everywhere."""
    return make_zero(Airflow, trachea_cmh2o=pressure_cmh2o, connector_cmh2o=pressure_cmh2o)


@compiled
def _magnitude(push: float, linear: float, square: float) -> float:
    """Positive root of ``square q^2 + linear q = push`` for ``push`` >= 0, without cancellation."""
    return 2.0 * push / (linear + math.sqrt(linear * linear + 4.0 * square * push))


@compiled
def solve(
    supply: Supply,
    tube_loss: float,
    lung_cmh2o: float,
    lung_cmh2o_s_per_ml: float,
    suction_ml_per_s: float,
) -> Airflow:
    """Flows and pressures for one step.

    tube_loss: see `twin.airway.airway.loss`. lung_cmh2o: elastic pressure at the start of the
    step; lung_cmh2o_s_per_ml: resistance below the tube plus half a step over the compliance.
    """
    push = supply.target_cmh2o - lung_cmh2o + lung_cmh2o_s_per_ml * suction_ml_per_s
    if push >= 0.0:
        linear = lung_cmh2o_s_per_ml + supply.source_cmh2o_s_per_ml
        flow = min(_magnitude(push, linear, tube_loss), supply.limit_ml_per_s)
    else:
        linear = lung_cmh2o_s_per_ml + supply.valve_cmh2o_s_per_ml
        flow = -_magnitude(-push, linear, tube_loss)
    into_lung = flow - suction_ml_per_s
    trachea = lung_cmh2o + lung_cmh2o_s_per_ml * into_lung
    return Airflow(
        tube_ml_per_s=flow,
        suction_ml_per_s=suction_ml_per_s,
        lung_ml_per_s=into_lung,
        trachea_cmh2o=trachea,
        connector_cmh2o=trachea + tube_loss * flow * abs(flow),
    )
