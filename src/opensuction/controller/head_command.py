"""The commanded head position, and what the procedure learns of it."""

from opensuction.control import compensation
from opensuction.control.backlash_inverse import HeadState
from opensuction.control.compensation import Branches
from opensuction.controller.record import CoreState, Settings
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings, is_number
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import teaching
from opensuction.procedure.cycle.demand import Demand
from opensuction.procedure.cycle.progress import ControlFeedback


@compiled
def _home(
    settings: Settings,
    heads_mm: Branches | None,
    let_through: HeadState,
    demand: Demand,
    phase: int,
    dt_s: float,
) -> HeadState:
    """Head on its way to its park position, or to the jog of the pre-use test."""
    home_mm = settings.plan.motion.park_head_mm + demand.jog_mm
    speed = settings.plan.motion.abort_mm_per_s
    if phase == Phase.TEACHING:
        speed = teaching.HOME_MM_PER_S
    sent = compensation.home(settings.compensation, heads_mm, let_through, home_mm, speed, dt_s)
    if phase == Phase.CHECKING:
        # The jog stays within the gap: it moves no tip, though the model has none so sharp.
        return compensation.after_retract(
            settings.compensation, settings.parked, sent.head_mm, sent.head_mm_per_s
        )
    return sent


@compiled
def step(
    settings: Settings,
    heads_mm: Branches | None,
    head: HeadState,
    origin: HeadState,
    let_through_mm: float,
    demand: Demand,
    phase: int,
    dt_s: float,
) -> HeadState:
    """Head as the cycle wants it: home, kept where it is, or on its way from ``origin`` to the tip.

    head: as the last tick commanded it. let_through_mm: what the governor let through of that.
    """
    by_hand = not demand.insertion_on
    if phase == Phase.HALTED or by_hand:
        return head._replace(head_mm=let_through_mm, head_mm_per_s=0.0)
    if demand.homing:
        # From what was let through: the compensation may be far ahead of what the head can do.
        let_through = head._replace(head_mm=let_through_mm)
        return _home(settings, heads_mm, let_through, demand, phase, dt_s)
    return compensation.step(
        settings.compensation,
        heads_mm,
        origin,
        demand.reference_mm,
        demand.reference_mm_per_s,
        demand.direction,
        demand.starts_in_s,
        dt_s,
    )


@compiled
def feedback(
    settings: Settings,
    heads_mm: Branches | None,
    state: CoreState,
    head: HeadState,
    readings: Readings,
    touched: bool,
    confirm: bool,
) -> tuple[HeadState, ControlFeedback]:
    """Feedback of the rest to the procedure, and the head as commanded from where the tip touched.

    touched: the tip has met something on its way in. confirm: a person says where the tip is.
    """
    here, contact_tip_mm, tip_mm = head, 0.0, 0.0
    if touched or confirm:
        head_mm = state.governor.watch.head_mm
        if readings.head_valid and is_number(readings.head_mm):
            head_mm = readings.head_mm
        tip_mm = compensation.loading_tip_mm(
            settings.compensation, settings.parked.head_mm, head_mm
        )
        if touched:
            here, contact_tip_mm = compensation.at_contact(
                settings.compensation, heads_mm, settings.parked, head_mm
            )
    learned = ControlFeedback(
        head_wanted_mm=head.head_mm,
        head_wanted_mm_per_s=head.head_mm_per_s,
        tripped=state.tripped,
        powerless=state.powerless,
        locked_out=state.upkeep.lock.locked,
        contact_tip_mm=contact_tip_mm,
        tip_mm=tip_mm,
    )
    return here, learned
