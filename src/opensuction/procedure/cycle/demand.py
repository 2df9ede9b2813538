"""Demand of the procedure on the control: a tip reference, the valve, the pump."""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.vocabulary import CYCLE, Phase
from opensuction.procedure.cycle import check
from opensuction.procedure.cycle import plan as plans
from opensuction.procedure.cycle.plan import Plan
from opensuction.procedure.cycle.progress import ProcedureState
from opensuction.procedure.suction import line_flow

WAY_IN = (Phase.PRELOADING, Phase.INSERTING, Phase.BACKING_OFF)
"""Phases before the tip is where it shall suck: with as little vacuum as shows that the line holds.
"""
INWARDS = 1.0
OUTWARDS = -1.0
NOT_ANNOUNCED_S = -1.0
"""The tip's next motion lies further ahead than the gap needs."""
PUMPED = CYCLE[1:]
"""Phases in which the pump runs; elsewhere the line vents, so that each check tests it."""


class Demand(NamedTuple):
    """Demand of the procedure on the control."""

    reference_mm: float
    """Desired tip position (y_r)."""
    reference_mm_per_s: float
    direction: float
    """Of the tip's next motion: +1 towards the carina, -1 back."""
    starts_in_s: float
    """Time until that motion begins; 0 while it lasts, below 0 where none is announced."""
    homing: bool
    """The head goes to its park position, whatever the model makes of the reference."""
    jog_mm: float
    """Homing: this far inwards of it, for the pre-use test."""
    insertion_on: bool
    """Torque of the insertion drive; off while a hand moves the head."""
    valve_open: bool
    valve_on: bool
    """Torque of the valve drive; off while the pre-use test leaves the valve to its spring."""
    pump_on: bool
    vacuum_mmhg: float


@compiled
def _next_motion(
    plan: Plan, now: ProcedureState, time_s: float, dt_s: float
) -> tuple[float, float]:
    """Direction of the tip's next motion and the time until it begins: see `Demand`.

    time_s: since the phase began. The direction turns when the way back's gap is to be crossed, and
    stays turned where mucus comes meanwhile: then the head waits behind the gap.
    """
    phase = now.phase
    if phase == Phase.PRELOADING:
        return INWARDS, max(plan.preload_s - time_s, 0.0)
    if phase == Phase.INSERTING:
        return INWARDS, 0.0
    backing = plan.contact.enabled and plan.contact.backoff_mm > 0.0
    if phase == Phase.BACKING_OFF:
        if not backing:
            return INWARDS, NOT_ANNOUNCED_S
        return OUTWARDS, max(plans.back_off_wait_s(plan) - time_s, 0.0)
    if phase in (Phase.OPENING, Phase.SUCTIONING):
        if backing:
            return OUTWARDS, NOT_ANNOUNCED_S  # the back-off has crossed the gap
        dwell_left_s = plan.dwell_s - now.arrived_ticks * dt_s
        left_s = line_flow.left_s(plan.pace, now.pace, dwell_left_s, dt_s)
        if left_s > plan.gap_lead_s:
            return OUTWARDS if now.pace.turned else INWARDS, NOT_ANNOUNCED_S
        return OUTWARDS, max(left_s, 0.0)
    return OUTWARDS, 0.0


@compiled
def _is_driven(phase: int, bringing: bool) -> bool:
    """Torque on the insertion drive: not while hands move the head."""
    if phase == Phase.TEACHING:
        return bringing
    return phase != Phase.OUT_OF_SERVICE


@compiled
def _is_pumping(phase: int, valve_open: bool) -> bool:
    """Pump on: in the cycle itself, and on the way out of one as long as the valve is open."""
    if phase == Phase.ABORTING:
        return valve_open
    return phase in PUMPED


@compiled
def ask(plan: Plan, now: ProcedureState, time_s: float, dt_s: float) -> Demand:
    """Demand of the cycle on the control ``time_s`` after its phase began. now: its new state."""
    phase, item, bringing = now.phase, now.check.item, now.teaching.bringing
    pumping = _is_pumping(phase, now.valve_open)
    vacuum_mmhg = plan.vacuum_mmhg if pumping else 0.0
    if phase in WAY_IN:
        vacuum_mmhg = plan.way_in_mmhg
    if phase == Phase.CHECKING:
        pumping = check.is_pumping(item)
        vacuum_mmhg = check.set_point_mmhg(plan.check, item)
    homing = phase in (Phase.PARKED, Phase.CHECKING, Phase.ABORTING)
    direction, starts_in_s = _next_motion(plan, now, time_s, dt_s)
    return Demand(
        reference_mm=now.reference_mm,
        reference_mm_per_s=now.reference_mm_per_s,
        direction=direction,
        starts_in_s=starts_in_s,
        homing=homing or (phase == Phase.TEACHING and bringing),
        jog_mm=plan.check.jog_mm if check.is_jogging(item) else 0.0,
        insertion_on=_is_driven(phase, bringing),
        valve_open=now.valve_open,
        valve_on=not check.is_by_spring(item),
        pump_on=pumping and not now.line_ready,
        vacuum_mmhg=vacuum_mmhg,
    )
