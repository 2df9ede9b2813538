"""Flows and pressures between ventilator, tube, trachea, catheter and lung.

Quasi-steady within a step: gas in tube and circuit has no inertia and no compliance worth a
hundredth of a second, and gas is incompressible (30 cmH2O are 3 % of an atmosphere). With the lung
at the middle of the step (implicit midpoint rule: second order, stable for every step) there is one
unknown, the flow through the tube, and it solves a quadratic equation: no iteration.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero
from opensuction.twin.patient.ventilator import Supply


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

    tube_loss: see `twin.airway.tube.loss`. lung_cmh2o: elastic pressure at the start of the
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
