"""Limitation of a proposal: the setpoints that are let through, and the reaction that this is.

It has no memory and judges nothing; `opensuction.safety.governor.governor` does.
"""

from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Setpoints
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.safety.handling import Reaction
from opensuction.safety.limits import Limits, head_cap_mm
from opensuction.safety.watch.watch import PARKED_MM
from opensuction.safety.watch.watch_state import Watch

LEAD_SHARE = 0.5
"""Share of the following limit by which a withdrawal may lead the head."""
ADVANCE_MM = 0.5
"""Net advance of the head that is allowed while the valve is not closed."""
ADVANCING_MM_PER_S = 3.0
"""Measured speed inwards above which the head is advancing: the valve is kept from opening."""
FURTHER_MM = 5.0
"""How much further than home the head is drawn where a catheter is still at the tube's mouth: half
of what a rack has behind it [design]. A gap three times as wide as identified leaves the tip 1.1 mm
short of where it is out [in-silico]."""
FURTHER_S = 1.0
"""For how long: it takes half a second, and by readings that are frozen it would pull for ever;
assumed."""
LOSING_S = 0.02
"""How long vacuum may be lost behind a closed valve before the head is stopped: a trip takes
longer, a sensor's noise does not last."""


@compiled
def _limit_rate(
    limits: Limits, origin_mm: float, wanted_mm: float, before_mm_per_s: float, dt_s: float
) -> float:
    """Position that may be commanded next: speed and gain of speed are bounded, a stop is not."""
    gained = limits.head_mm_per_s2 * dt_s
    fastest = limits.head_speed_mm_per_s
    inwards = min(max(before_mm_per_s, 0.0) + gained, fastest)
    outwards = min(max(-before_mm_per_s, 0.0) + gained, fastest)
    return min(max(wanted_mm, origin_mm - outwards * dt_s), origin_mm + inwards * dt_s)


@compiled
def _narrow_head(
    limits: Limits,
    command_mm: float,
    before_mm_per_s: float,
    seen: Watch,
    proposal: Setpoints,
    held: bool,
    stopped: bool,
    dt_s: float,
) -> tuple[float, float]:
    """Head command that may be let through (mm), and the velocity that belongs to it (mm/s).

    command_mm, before_mm_per_s: the last ones. held: the valve is not closed. stopped: it may not
    go further in at all. A stop takes effect at once: the command drops to where the head is,
    however far it was ahead.
    """
    highest = head_cap_mm(limits.tip, limits.cap_mm)
    if held:
        highest = min(highest, seen.suction_start_mm + ADVANCE_MM)
    if stopped:
        highest = min(highest, seen.head_mm, command_mm)
    # A head that is leaving is now ahead of its command, now behind: its speed is the command's.
    leaving = stopped and before_mm_per_s < 0.0
    origin = command_mm if leaving else min(command_mm, max(seen.head_mm, highest))
    wanted_mm = min(proposal.head_mm, highest)
    head = _limit_rate(limits, origin, wanted_mm, before_mm_per_s, dt_s)
    bound = highest < proposal.head_mm and highest <= command_mm and (held or stopped)
    if bound or (leaving and (head == wanted_mm or head > seen.head_mm)):
        # The bound follows the encoder's steps, whose speed a servo must not lead: see below.
        head = min(head, seen.head_mm) if leaving else head
        return head, max(min(proposal.head_mm_per_s, 0.0), -limits.head_speed_mm_per_s)
    return head, (head - origin) / dt_s


@compiled
def _home_mm(limits: Limits, seen: Watch) -> float:
    """End of a withdrawal: further back where the head is home and its catheter is not."""
    if 0.0 < seen.durations.remaining_s < FURTHER_S:
        return limits.park_head_mm - FURTHER_MM
    return limits.park_head_mm


@compiled
def _withdraw_head(
    limits: Limits, command_mm: float, before_mm_per_s: float, seen: Watch, dt_s: float
) -> tuple[float, float]:
    """Head command and velocity on the way out, from where the head is or was told to be."""
    origin = min(command_mm, seen.head_mm)
    home_mm = _home_mm(limits, seen)
    # Never further ahead than the servo needs: a head slower than its limit still follows.
    lowest = seen.head_mm - LEAD_SHARE * limits.following_mm
    wanted = min(max(home_mm, lowest), origin)
    head = _limit_rate(limits, origin, wanted, before_mm_per_s, dt_s)
    if lowest > home_mm and head <= lowest:
        # It follows the encoder's steps, whose speed a servo must not lead: a tick of it the other
        # way takes what a drive that is held has gained in fifty.
        return head, min(before_mm_per_s, 0.0)
    return head, (head - origin) / dt_s


@compiled
def _narrow_suction(
    limits: Limits, was_open: bool, seen: Watch, proposal: Setpoints, cut: bool
) -> tuple[bool, float]:
    """Permission for an open valve, and the regulator's set point (mmHg).

    The valve is kept from opening on a head that advances, and on more vacuum than the patient's
    limit: only behind a closed valve, with the tip parked, may the relief valve be tested, and only
    in a tick whose own readings say so: a number that the vote rides out is none.
    """
    advancing = seen.speed_mm_per_s > ADVANCING_MM_PER_S
    excessive = seen.line.vacuum_mmhg > limits.vacuum_mmhg
    valve_open = proposal.valve_open and not cut and (was_open or not (advancing or excessive))
    highest = limits.vacuum_mmhg
    off_mm = abs(seen.vote.encoder_mm - limits.park_head_mm)
    read = seen.invalid.head == 0 and seen.invalid.cam == 0 and off_mm <= PARKED_MM
    if seen.parked_closed and read and not valve_open:
        highest = max(highest, limits.line.parked_closed_mmhg)
    return valve_open, 0.0 if cut else min(proposal.vacuum_mmhg, highest)


@compiled
def narrow(
    limits: Limits, last: Setpoints, seen: Watch, proposal: Setpoints, trips: int, dt_s: float
) -> tuple[Setpoints, int]:
    """Setpoints that may be let through, and the reaction that this is.

    last: what was let through in the last tick.
    """
    reaction = condition_mask.strongest_reaction(trips)
    cut = condition_mask.cuts_vacuum(trips)
    valve_open, vacuum = _narrow_suction(limits, last.valve_open, seen, proposal, cut)
    held = valve_open or seen.durations.sucking_s > 0.0
    released = not proposal.insertion_on and reaction != Reaction.WITHDRAW
    # By sensors that are adrift a head that is home would be led astray again; one that its motor
    # has not brought home is another matter.
    wrong = trips >> Condition.HEAD_SENSORS_DISAGREE & 1 == 1
    lost = wrong and seen.durations.disagreeing_s == 0.0
    home = seen.head_mm <= _home_mm(limits, seen) + ADVANCE_MM
    let_go = reaction == Reaction.TORQUE_OFF or (reaction == Reaction.WITHDRAW and lost and home)
    driven = not (let_go or released)
    changed = valve_open != proposal.valve_open or vacuum != proposal.vacuum_mmhg
    if not driven:
        head, velocity = seen.head_mm, 0.0  # a start begins from where it is
        if released and reaction == Reaction.PASS and changed:
            reaction = Reaction.CAP
    elif reaction == Reaction.WITHDRAW:
        head, velocity = _withdraw_head(limits, last.head_mm, last.head_mm_per_s, seen, dt_s)
    else:
        # Where vacuum is lost behind a closed valve, it may be drawing at the tip.
        stopped = seen.durations.contact_s > 0.0 or seen.line.closed_low_s > LOSING_S
        head, velocity = _narrow_head(
            limits, last.head_mm, last.head_mm_per_s, seen, proposal, held, stopped, dt_s
        )
        if (held or stopped) and head < proposal.head_mm:
            reaction = Reaction.HOLD
        elif changed or head != proposal.head_mm:
            reaction = Reaction.CAP
    allowed = Setpoints(
        head_mm=head,
        head_mm_per_s=velocity,
        insertion_on=driven,
        valve_open=valve_open,
        pump_on=proposal.pump_on and not cut,
        vacuum_mmhg=vacuum,
    )
    return allowed, reaction
