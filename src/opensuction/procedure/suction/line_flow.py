"""Detection of mucus from the line vacuum, by the gas flow that the catheter lets through.

Mucus at the tip or in the bore leaves less room for gas. The flow into the canister is the pump's
flow less the share that raises the canister's pressure; a free catheter draws the root of the
vacuum times a constant of its bore. Where mucus comes, the line takes in a smaller share of that.

Two kinds of line. Where the free catheter draws more than the pump keeps up with, the vacuum falls
below its set point and the balance holds as long as the pump runs; at the set point the regulator
lets in air that nothing measures, and the share is overstated, but still well below a free one's.
Where a thin catheter draws so little that it would not show, the pump rests with the valve open
(decision 19), and only those rests are evaluated: the vacuum's fall is then the flow.

The vacuum is taken over windows, a line fitted through each: white noise of a sensor averages out,
and an offset of 7 mmHg changes the share by 6 % at most.

Duration of suction where the tip stopped, and speed on the way out, by the mucus that comes.

The dwell ends when nothing has come for a stated time. The time that it saves is spent on the way
out where mucus comes again: there the tip goes slowly. In either case suction lasts no longer than
planned.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero


class PacePlan(NamedTuple):
    """Plan of the pace of suction; times are s."""

    nothing_comes_s: float
    """Time without mucus that ends the dwell; 0 where it lasts its whole time."""
    gap_lead_s: float
    """Time that the gap of the way back takes before it; 0 where it has been crossed before."""
    slow_ratio: float
    """Speed of the way out where mucus comes, as share of the planned one."""
    ramp_s: float
    """Time in which it changes between rest and the planned speed."""


class Pace(NamedTuple):
    """State of suction, up to this tick."""

    quiet_ticks: int
    """For how long nothing has come in the dwell."""
    turned: bool
    """The head has been sent across the gap of the way back."""
    ratio: float
    """Present speed of the way out, as share of the planned one."""
    late_s: float
    """By how much the way out is behind one at the planned speed."""
    spare_s: float
    """Time by which the way out may still last longer."""


BEGUN = Pace(quiet_ticks=0, turned=False, ratio=1.0, late_s=0.0, spare_s=0.0)


@compiled
def listen(plan: PacePlan, pace: Pace, nothing_comes: bool) -> Pace:
    """The dwell after another tick. nothing_comes: only gas is known to come."""
    quiet = pace.quiet_ticks + 1 if nothing_comes and plan.nothing_comes_s > 0.0 else 0
    return pace._replace(quiet_ticks=quiet)


@compiled
def left_s(plan: PacePlan, pace: Pace, dwell_left_s: float, dt_s: float) -> float:
    """Time until the way back begins, as far as it is known now.

    dwell_left_s: what is left of the whole dwell.
    """
    if pace.quiet_ticks == 0:
        return dwell_left_s
    return min(dwell_left_s, plan.nothing_comes_s - pace.quiet_ticks * dt_s)


@compiled
def is_over(plan: PacePlan, pace: Pace, dt_s: float) -> bool:
    """True once nothing has come for the stated time."""
    return plan.nothing_comes_s > 0.0 and pace.quiet_ticks * dt_s >= plan.nothing_comes_s


@compiled
def turn(plan: PacePlan, pace: Pace, until_s: float) -> Pace:
    """Remember that the gap is being crossed: the head does not go back, whatever comes then."""
    return pace._replace(turned=pace.turned or until_s <= plan.gap_lead_s)


@compiled
def leave(plan: PacePlan, dwell_left_s: float) -> Pace:
    """The begin of the way out."""
    spare = max(dwell_left_s, 0.0) if plan.nothing_comes_s > 0.0 else 0.0
    return BEGUN._replace(turned=True, spare_s=spare)


@compiled
def go_on(plan: PacePlan, pace: Pace, comes: bool, dt_s: float) -> Pace:
    """The way out after another tick: slowly where mucus comes, as long as there is time for it.

    The speed changes no faster than the plan has it.
    """
    # As much as the way back to the full speed takes must be left, and more.
    may_slow = comes and pace.spare_s > (1.0 - plan.slow_ratio) * plan.ramp_s + dt_s
    wanted = plan.slow_ratio if may_slow else 1.0
    most = dt_s / plan.ramp_s if plan.ramp_s > dt_s else 1.0
    ratio = min(max(wanted, pace.ratio - most), pace.ratio + most)
    lost_s = (1.0 - ratio) * dt_s
    return pace._replace(
        ratio=ratio,
        late_s=pace.late_s + lost_s,
        spare_s=max(pace.spare_s - lost_s, 0.0),
    )


SETTLE_S = 0.04
"""After the pump has begun to rest: its regulator has settled (17 ms), and so has a sensor that
takes 20 ms, but for a seventh [computed]."""
STALE_S = 0.6
"""A window older than this says nothing any more. A thin catheter's pump runs for 50 ms, and its
rest has a window 230 ms after it began [computed]."""
SAMPLE_S = 0.001
"""Time between two readings that `FreeFlow.window_s` is meant for."""
LEAST_MMHG = 10.0
"""A line with less vacuum draws nothing that could be told: a sensor's offset is as much; assumed.
"""


class FreeFlow(NamedTuple):
    """Line and catheter without mucus, as the machine's profile has them."""

    window_s: float
    """Time over which the flow is measured, with a reading each `SAMPLE_S`; 0 where nothing is
    looked for."""
    pump_ml_per_s: float
    """Free-air flow of the pump."""
    pump_ml_per_s_per_mmhg: float
    """Flow that it loses for each mmHg."""
    bore_ml_per_s_per_root_mmhg: float
    """Free-air flow through the catheter for each root of the vacuum in mmHg."""
    canister_ml_per_mmhg: float
    """Free air that raises the pressure in the canister by 1 mmHg."""
    free_share: float
    """Share of a free catheter's flow from which nothing but gas comes."""
    at_rest: bool
    """Only a resting pump lets the flow be seen."""


UNSEEN = make_zero(FreeFlow)
"""A line on which nothing is looked for."""


class FlowSeen(NamedTuple):
    """Measurement of the flow, up to this tick."""

    settling_ticks: int
    """Since the pump began or ceased to run, until the line has settled."""
    ticks: int
    """Of the present window."""
    sum_mmhg: float
    """Of its readings."""
    moment_mmhg: float
    """Of its readings, each times the ticks before it."""
    pumping: bool
    """Whether the pump ran in the last tick."""
    age_ticks: int
    """Since the last window that could be judged; -1 before the first."""
    is_free: bool
    """Nothing but gas came in that."""


NOTHING_SEEN = FlowSeen(
    settling_ticks=0,
    ticks=0,
    sum_mmhg=0.0,
    moment_mmhg=0.0,
    pumping=False,
    age_ticks=-1,
    is_free=False,
)


@compiled
def share(flow: FreeFlow, mean_mmhg: float, slope_mmhg_per_s: float, pumping: bool) -> float:
    """Gas that comes through the catheter, as share of what a free one draws at that vacuum."""
    drawn = -slope_mmhg_per_s * flow.canister_ml_per_mmhg
    if pumping:
        drawn += max(flow.pump_ml_per_s - flow.pump_ml_per_s_per_mmhg * mean_mmhg, 0.0)
    return drawn / (flow.bore_ml_per_s_per_root_mmhg * math.sqrt(max(mean_mmhg, LEAST_MMHG)))


@compiled
def _is_full(flow: FreeFlow, ticks: int, dt_s: float) -> bool:
    """True once a window has readings enough for the noise of its slope to be as small as it must.

    The slope of a line through n readings in a time T deviates by sqrt(12 / n) / T times what they
    do: with readings further apart the cube of T grows as the time between them.
    """
    time_s, window_s = ticks * dt_s, flow.window_s
    apart = max(dt_s / SAMPLE_S, 1.0)
    return time_s * time_s * time_s >= window_s * window_s * window_s * apart


@compiled
def _judge(flow: FreeFlow, seen: FlowSeen, dt_s: float) -> FlowSeen:
    """Judge a window that is full, and begin the next."""
    count = seen.ticks * 1.0
    mean = seen.sum_mmhg / count
    # Least squares through equally spaced readings.
    tilt = seen.moment_mmhg - 0.5 * (count - 1.0) * seen.sum_mmhg
    slope = 12.0 * tilt / (count * (count * count - 1.0) * dt_s)
    following = seen._replace(ticks=0, sum_mmhg=0.0, moment_mmhg=0.0)
    if mean < LEAST_MMHG:
        return following
    is_free = share(flow, mean, slope, seen.pumping) >= flow.free_share
    return following._replace(age_ticks=0, is_free=is_free)


@compiled
def step(
    flow: FreeFlow,
    seen: FlowSeen,
    vacuum_mmhg: float,
    vacuum_valid: bool,
    pumping: bool,
    dt_s: float,
) -> FlowSeen:
    """Take in the reading of a tick. pumping: the pump is commanded to run."""
    age = seen.age_ticks + 1 if seen.age_ticks >= 0 else -1
    unseen = not vacuum_valid or (flow.at_rest and pumping)
    if unseen or pumping != seen.pumping:
        return NOTHING_SEEN._replace(pumping=pumping, age_ticks=age, is_free=seen.is_free)
    if seen.settling_ticks * dt_s < SETTLE_S:
        return seen._replace(settling_ticks=seen.settling_ticks + 1, age_ticks=age)
    longer = seen._replace(
        ticks=seen.ticks + 1,
        sum_mmhg=seen.sum_mmhg + vacuum_mmhg,
        moment_mmhg=seen.moment_mmhg + vacuum_mmhg * seen.ticks,
        age_ticks=age,
    )
    if _is_full(flow, longer.ticks, dt_s):
        return _judge(flow, longer, dt_s)
    return longer


@compiled
def is_known(seen: FlowSeen, dt_s: float) -> bool:
    """True while the last window is young enough to go by."""
    return seen.age_ticks >= 0 and seen.age_ticks * dt_s <= STALE_S


@compiled
def is_nothing_coming(seen: FlowSeen, dt_s: float) -> bool:
    """True where nothing but gas is known to come; false where it is not known."""
    return is_known(seen, dt_s) and seen.is_free


@compiled
def is_coming(seen: FlowSeen, dt_s: float) -> bool:
    """True where mucus is known to come; false where it is not known."""
    return is_known(seen, dt_s) and not seen.is_free
