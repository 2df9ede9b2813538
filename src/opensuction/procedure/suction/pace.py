"""Duration of suction where the tip stopped, and speed on the way out, by the mucus that comes.

The dwell ends when nothing has come for a stated time. The time that it saves is spent on the way
out where mucus comes again: there the tip goes slowly. In either case suction lasts no longer than
planned.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled


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
