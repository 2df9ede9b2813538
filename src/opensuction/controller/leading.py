"""Where the head is led, and what the procedure learns of where it is."""

from opensuction.control import compensation
from opensuction.control.exact_inverse import HeadState
from opensuction.controller.record import Memory, Settings
from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import Phase
from opensuction.kernel.readings import Readings, is_number
from opensuction.procedure.cycle.cycle import Demand
from opensuction.procedure.cycle.progress import ControlFeedback


@compiled
def _head_mm(known_mm: float, readings: Readings) -> float:
    """Head as it is read in this tick; the last that was known where it is not."""
    if readings.head_valid and is_number(readings.head_mm):
        return readings.head_mm
    return known_mm


@compiled
def lead(
    settings: Settings,
    led: HeadState,
    origin: HeadState,
    let_through_mm: float,
    demand: Demand,
    phase: int,
    dt_s: float,
) -> HeadState:
    """Head as the cycle wants it: home, kept where it is, or led from ``origin`` to the tip.

    led: as the last tick led it. let_through_mm: what the governor let through of that.
    """
    by_hand = not demand.insertion_on
    if phase == Phase.HALTED or by_hand:
        return compensation.held(led, let_through_mm, 0.0)
    if demand.homing:
        # From what was let through: the compensation may be far ahead of what the head can do.
        let_through = compensation.held(led, let_through_mm, led.head_mm_per_s)
        home_mm = settings.plan.motion.park_head_mm + demand.jog_mm
        speed = settings.plan.motion.abort_mm_per_s
        if phase == Phase.TEACHING:
            speed = settings.plan.teaching.home_mm_per_s
        sent = compensation.home(settings.compensation, let_through, home_mm, speed, dt_s)
        if phase == Phase.CHECKING:
            # The jog stays within the gap: it moves no tip, though the model has none so sharp.
            return compensation.rested(
                settings.compensation, settings.parked, led, sent.head_mm, sent.head_mm_per_s
            )
        return sent
    return compensation.step(
        settings.compensation,
        origin,
        demand.reference_mm,
        demand.reference_mm_per_s,
        demand.direction,
        demand.starts_in_s,
        dt_s,
    )


@compiled
def surroundings(
    settings: Settings,
    state: Memory,
    led: HeadState,
    readings: Readings,
    touched: bool,
    confirm: bool,
) -> tuple[HeadState, ControlFeedback]:
    """What the procedure learns of the rest, and the head as it is led from where it touched.

    touched: the tip has met something on its way in. confirm: a person says where the tip is.
    """
    here, here_mm, tip_mm = led, 0.0, 0.0
    if touched or confirm:
        head_mm = _head_mm(state.governor.watch.head_mm, readings)
        tip_mm = compensation.pushed_mm(settings.compensation, settings.parked.head_mm, head_mm)
        if touched:
            here, here_mm = compensation.stopped(settings.compensation, led, head_mm)
    around = ControlFeedback(
        head_wanted_mm=led.head_mm,
        head_wanted_mm_per_s=led.head_mm_per_s,
        tripped=state.tripped,
        powerless=state.powerless,
        contact_tip_mm=here_mm,
        tip_mm=tip_mm,
    )
    return here, around
