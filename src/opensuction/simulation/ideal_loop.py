"""A compensator on an ideal servo: the head follows its command, and nothing is noisy or late.

What is left is compensator against plant; any model of hysteresis can be that plant, because a
compensator never sees the tip. Nobody is on such a machine, and no governor watches it.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control import compensation, head_path, profile, staged_path
from opensuction.control.compensation import Branches, Compensation
from opensuction.control.exact_inverse import HeadState
from opensuction.control.head_path import HeadLimits
from opensuction.kernel.compiled import compiled
from opensuction.procedure.cycle import plan as plans
from opensuction.procedure.cycle.demand import INWARDS, NOT_ANNOUNCED_S, OUTWARDS
from opensuction.procedure.cycle.plan import Plan
from opensuction.simulation.closed_loop import DT_S

Array = npt.NDArray[np.float64]


class Course(NamedTuple):
    """Course of the tip's reference, a sample a tick: the way in, the dwell and the way out."""

    demand: Array
    """Reference, its velocity, direction of the next motion and time until it; shape (n, 4)."""
    insertion_tick: int
    """Tick at which the tip begins to move in; before it the gap may be crossed."""


def course(plan: Plan) -> Course:
    """The demand of one cycle of known travel, as the procedure announces it (`Demand`)."""
    motion = plan.motion
    in_s = float(staged_path.duration_s(plans.way_in(motion, motion.park_mm)))
    way_out = plans.way_out(motion, motion.target_mm, motion.withdrawal_mm_per_s)
    leaving_s = plan.preload_s + in_s + plan.dwell_s
    total_s = leaving_s + float(profile.duration_s(way_out))
    demand = np.empty((round(total_s / DT_S) + 1, 4))
    _fill(plan, plan.preload_s + in_s, demand)
    return Course(demand, round(plan.preload_s / DT_S))


@compiled
def _fill(plan: Plan, arrived_s: float, demand: Array) -> None:
    """Write the rows of `Course.demand`. arrived_s: when the reference reaches the target."""
    motion = plan.motion
    way_in = plans.way_in(motion, motion.park_mm)
    way_out = plans.way_out(motion, motion.target_mm, motion.withdrawal_mm_per_s)
    leaving_s = arrived_s + plan.dwell_s
    for tick in range(demand.shape[0]):
        now_s = tick * DT_S
        direction, starts_in_s = INWARDS, 0.0
        reference, velocity = motion.park_mm, 0.0
        if now_s < plan.preload_s:
            starts_in_s = plan.preload_s - now_s
        elif now_s < leaving_s:
            reference, velocity = staged_path.at(way_in, now_s - plan.preload_s)
            left_s = leaving_s - now_s
            if now_s >= arrived_s:
                starts_in_s = NOT_ANNOUNCED_S
            if left_s <= plan.gap_lead_s:
                direction, starts_in_s = OUTWARDS, left_s
        else:
            reference, velocity = profile.at(way_out, now_s - leaving_s)
            direction = OUTWARDS
        demand[tick, 0] = reference
        demand[tick, 1] = velocity
        demand[tick, 2] = direction
        demand[tick, 3] = starts_in_s


@compiled
def lead(
    chosen: Compensation,
    heads_mm: Branches | None,
    limits: HeadLimits,
    start: HeadState,
    demand: Array,
    dt_s: float,
) -> Array:
    """Head positions under a compensator at the end of each tick, mm, shape (n,).

    A command is where the head shall be when its tick ends; by then the reference is that of the
    next tick. heads_mm: branches of the compensation. limits: of the head, which follows the
    command no faster. demand: as `Course.demand`.
    """
    heads = np.empty(demand.shape[0])
    state, head, velocity = start, start.head_mm, 0.0
    for tick in range(demand.shape[0]):
        state = compensation.step(
            chosen,
            heads_mm,
            state,
            demand[tick, 0],
            demand[tick, 1],
            demand[tick, 2],
            demand[tick, 3],
            dt_s,
        )
        most = limits.speed_mm_per_s
        wanted = min(max(state.head_mm_per_s, -most), most)
        # From where the command was a tick ago: at the end of this one the head is where it is.
        distance = state.head_mm - wanted * dt_s - head
        velocity = head_path.step(limits, distance, wanted, velocity, dt_s)
        head += velocity * dt_s
        heads[tick] = head
    return heads
