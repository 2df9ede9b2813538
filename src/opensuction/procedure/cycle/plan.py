"""The plan of one run: a protocol fitted to machine and patient, in the form the tick needs."""

from typing import Annotated, NamedTuple

from annotated_types import Len

from opensuction.control.motion_profile import Profile, StagedPath
from opensuction.kernel.compiled import compiled
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.check import CheckPlan
from opensuction.procedure.cycle.teaching import TravelRange
from opensuction.procedure.suction.line_flow import FreeFlow, PacePlan

BACK_OFF_SHARE = 0.5
"""Share of the head's acceleration that the tip's reference uses to back off: a head that comes
late out of the gap must brake harder than its reference does, or it runs past the end."""
LEAST_OFF_SHARE = 0.5
"""Share of a back-off that the tip must have gone since the contact switch opened. Where the gap is
wider than it was identified the switch opens late, and the tip still lies on the carina, with less
force than closes a switch, where the back-off was to end."""
OPENED_SHARE = 0.75
"""Share of a back-off, from a contact before the window, at which the switch must have opened. Half
of it is too little where the gap has grown with a posture; with all of it the longest contact that
the governor lets pass would be over."""
TUBE_END_MM = 0.0
"""Lower end of the tube: the origin of every depth."""


class Motion(NamedTuple):
    """Motion of the tip."""

    park_mm: float
    """Reference of the parked tip."""
    target_mm: float
    tube_mm_per_s: float
    """Speed inwards inside the tube, down to its lower end at 0."""
    insertion_mm_per_s: float
    withdrawal_mm_per_s: float
    abort_mm_per_s: float
    acceleration_mm_per_s2: float
    park_head_mm: float
    """Head position at which the machine is parked."""
    settle_mm: float
    """The head has arrived when it is this near to its command."""


class ContactSearch(NamedTuple):
    """Stopping by contact: where it is expected, and how far the tip backs off before suction."""

    enabled: bool
    window_start_mm: float
    """Contact with the estimated tip before this is not the carina as it was taught: it has come
    nearer, something is in the way, or the switch is bridged."""
    nearest_mm: float
    """And before this it is a fault, however steady."""
    backoff_mm: float
    suction_mm: float
    """Suction takes place no deeper, wherever contact came. Contact that comes deep in its window
    is as well a stiff switch as a carina that lies deep: the tip then still presses where a
    back-off from there ends."""


class Excitation(NamedTuple):
    """Identification: the head follows half of (1 - cos), starting from rest."""

    range_mm: float
    period_s: float
    duration_s: float


class Plan(NamedTuple):
    """Plan that the procedure follows. Times are s, vacuum is mmHg."""

    motion: Motion
    contact: ContactSearch
    check: CheckPlan
    plausible: TravelRange
    """Lengths that may be taught."""
    excitation: Excitation
    preload_s: float
    """Time given to the head to take up the gap before insertion."""
    dwell_s: float
    """From the reference's arrival at the target to the start of the way back."""
    gap_lead_s: float
    """Last part of the dwell, in which the gap of the way back is crossed."""
    pace: PacePlan
    """When the dwell ends before its time, and where the way out is slow."""
    flow: FreeFlow
    """By what mucus is seen to come."""
    vacuum_mmhg: float
    build_most_s: float
    """Longest time that the vacuum of suction may take to build: half as long again as planned, and
    time to settle; at most what the pre-use test allows."""
    way_in_mmhg: float
    """Vacuum of the line while the tip goes in: enough to tell a valve that lets gas through."""
    cam_open_rad: float
    pump_rests_open: bool
    """With the valve open the pump only brings the vacuum back when it has fallen: see
    `safety.limits.LineLimits`."""
    bench_only: bool
    """Nobody is on the machine: it may be identified."""
    travel_known: bool
    """Whether a cycle may start: not under the plan that a person teaches with."""
    limits_s: Annotated[tuple[float, ...], Len(len(Phase), len(Phase))]
    """Longest duration of each phase, by its number; infinite where a person acts."""


@compiled
def way_in(motion: Motion, start_mm: float) -> StagedPath:
    """Insertion from where the reference is: fast inside the tube, slow beyond its end."""
    return StagedPath(
        start_mm=start_mm,
        switch_mm=TUBE_END_MM,
        end_mm=motion.target_mm,
        fast_mm_per_s=motion.tube_mm_per_s,
        slow_mm_per_s=motion.insertion_mm_per_s,
        acceleration_mm_per_s2=motion.acceleration_mm_per_s2,
    )


@compiled
def backed_off_mm(contact: ContactSearch, start_mm: float) -> float:
    """End of the tip's reference off the carina. start_mm: the reference at contact."""
    return min(start_mm - contact.backoff_mm, contact.suction_mm)


@compiled
def back_off(motion: Motion, start_mm: float, end_mm: float) -> Profile:
    """Off the carina, as fast as the head may go outwards."""
    return Profile(
        start_mm=start_mm,
        end_mm=end_mm,
        speed_mm_per_s=motion.abort_mm_per_s,
        acceleration_mm_per_s2=BACK_OFF_SHARE * motion.acceleration_mm_per_s2,
    )


@compiled
def back_off_wait_s(plan: Plan) -> float:
    """Time that the reference of a back-off gives the head to cross the gap.

    The crossing at full speed, without the half of its braking that ends at rest: it goes on.
    """
    braking_s = 0.5 * plan.motion.abort_mm_per_s / plan.motion.acceleration_mm_per_s2
    return max(plan.gap_lead_s - braking_s, 0.0)


@compiled
def way_out(motion: Motion, start_mm: float, speed_mm_per_s: float) -> Profile:
    """Withdrawal to the parked reference."""
    return Profile(
        start_mm=start_mm,
        end_mm=motion.park_mm,
        speed_mm_per_s=speed_mm_per_s,
        acceleration_mm_per_s2=motion.acceleration_mm_per_s2,
    )
