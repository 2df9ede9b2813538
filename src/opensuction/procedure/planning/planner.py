"""Fits a protocol to a machine, or refuses with the arithmetic in one line."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from opensuction.control import motion_profile
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import CYCLE, AgeGroup, Phase
from opensuction.procedure.cycle import plan as plans
from opensuction.procedure.cycle import teaching
from opensuction.procedure.cycle.check import CheckPlan
from opensuction.procedure.cycle.plan import ContactSearch, Excitation, Motion, Plan
from opensuction.procedure.cycle.progress import KEPT_S
from opensuction.procedure.planning.protocol import (
    VACUUM_LIMIT_S,
    VACUUM_READY_SHARE,
    Protocol,
    Site,
    nearest_contact_mm,
    plan_check,
)
from opensuction.procedure.suction.line_flow import UNSEEN, PacePlan

CAP_MARGIN_MM = 5.0
"""Least distance from the stopping point to the cap [design-cap]."""
SETTLE_S = 1.0
"""Time a servo may need to settle after a move, before the phase counts as overdue."""
OVERDUE_SHARE = 1.5
"""A phase may last this many times its planned duration (and `SETTLE_S`)."""
SLOW_MM_PER_S = 5.0
"""Speed of the way out where mucus comes [in-silico]: docs/evidence/2026-11-23-suction-ends.md."""
WAY_IN_MMHG = {AgeGroup.ADULT: 15.0, AgeGroup.CHILD: 10.0, AgeGroup.NEONATE: 10.0}
"""Vacuum in the line while the tip goes in: a valve that opens by itself draws with no more, and a
free 12 Fr catheter has emptied 0.8 L of it after 0.3 s [computed]; a sensor's noise of 1 mmHg and
what its offset has drifted since it was learnt are told from that. Through a thin catheter a slit
takes so long to show that a small patient's way in may be over: of 15 mmHg one of a tenth drew 1.6
at a child's tip, for 64 mm [in-silico]."""
PACE_SHARE = 0.5
"""Share of the planned acceleration with which it changes: a head that is still catching up after
the gap cannot brake as hard as its reference; at all of it the tip ran 2 mm ahead, so .8
[in-silico]."""


class Abilities(NamedTuple):
    """Abilities of the machine, for the planner."""

    head_mm_per_s: float
    """Speed at which the head crosses a gap and withdraws on an abort."""
    acceleration_mm_per_s2: float
    park_head_mm: float
    settle_mm: float
    cam_open_rad: float
    cam_rad_per_s: float
    gap_in_mm: float
    """Head travel that takes up the gap before insertion; 0 without compensation."""
    gap_out_mm: float
    """Head travel that takes it up before the way back."""
    relief_mmhg: float
    """Mechanical relief valve of the suction line."""
    jog_mm: float
    """Head travel inwards that does not move the parked tip, whatever the gap has become."""
    pump_mmhg_per_s: float
    """Rate at which the pump evacuates a vented line."""
    pump_occluded_mmhg: float
    """Vacuum at which it moves nothing."""
    turn_mm: float
    """Head travel of a turn whether it is prepared or not; at least ``gap_out_mm``."""


class Timeline(NamedTuple):
    """Planned durations, s."""

    preload: float
    insertion: float
    build: float
    """Vacuum of the way in to that of suction, behind the closed valve."""
    stroke: float
    dwell: float
    withdrawal: float
    back_off: float
    """Across the gap and off the carina; 0 where the tip stops by travel."""
    negative_pressure: float
    """Valve leaves its seat to valve closed."""
    in_airway: float


def crossing_s(abilities: Abilities, gap_mm: float) -> float:
    """Time to cross a gap from rest to rest within the head's limits."""
    speed, acceleration = abilities.head_mm_per_s, abilities.acceleration_mm_per_s2
    return float(
        motion_profile.duration_s(motion_profile.Profile(0.0, gap_mm, speed, acceleration))
    )


def way_in_mmhg(protocol: Protocol, age: AgeGroup) -> float:
    """Vacuum of the line while the tip goes in; on a bench, where nobody is drawn at, the whole."""
    if protocol.bench_only:
        return protocol.vacuum_mmhg
    return min(WAY_IN_MMHG[age], protocol.vacuum_mmhg)


def build_s(abilities: Abilities, from_mmhg: float, vacuum_mmhg: float) -> float:
    """Time in which the pump brings the line from the way in to a set point that counts as built.

    At most what the pre-use test allows for it.
    """
    occluded, ready_mmhg = abilities.pump_occluded_mmhg, VACUUM_READY_SHARE * vacuum_mmhg
    start_mmhg = min(from_mmhg, ready_mmhg)
    if ready_mmhg >= occluded:
        return VACUUM_LIMIT_S
    ratio = (occluded - start_mmhg) / (occluded - ready_mmhg)
    return min(occluded / abilities.pump_mmhg_per_s * math.log(ratio), VACUUM_LIMIT_S)


def motion(protocol: Protocol, abilities: Abilities, site: Site) -> Motion:
    """Tip motion of a protocol on a machine and a patient."""
    return Motion(
        park_mm=site.park_mm,
        tube_mm_per_s=max(site.fast_mm_per_s, protocol.insertion_mm_per_s),
        target_mm=protocol.travel_mm,
        insertion_mm_per_s=protocol.insertion_mm_per_s,
        withdrawal_mm_per_s=protocol.withdrawal_mm_per_s,
        abort_mm_per_s=abilities.head_mm_per_s,
        acceleration_mm_per_s2=abilities.acceleration_mm_per_s2,
        park_head_mm=abilities.park_head_mm,
        settle_mm=abilities.settle_mm,
    )


def timeline(protocol: Protocol, abilities: Abilities, site: Site, by_contact: bool) -> Timeline:
    """Planned durations of a cycle; by contact, of one that finds it only at the search's end."""
    moves = motion(protocol, abilities, site)
    insertion = float(motion_profile.staged_duration_s(plans.way_in(moves, site.park_mm)))
    # By contact suction takes place off the carina, wherever it was found.
    deepest_mm = protocol.travel_mm - (protocol.backoff_mm if by_contact else 0.0)
    withdrawal = float(
        motion_profile.duration_s(plans.way_out(moves, deepest_mm, protocol.withdrawal_mm_per_s))
    )
    stroke = abilities.cam_open_rad / abilities.cam_rad_per_s
    build = build_s(abilities, way_in_mmhg(protocol, site.age), protocol.vacuum_mmhg)
    back_off = 0.0
    if by_contact:
        back_off = crossing_s(abilities, abilities.turn_mm) + float(
            motion_profile.duration_s(plans.back_off(moves, 0.0, -protocol.backoff_mm))
        )
    return Timeline(
        preload=crossing_s(abilities, abilities.gap_in_mm),
        insertion=insertion,
        build=build,
        stroke=stroke,
        dwell=protocol.dwell_s,
        withdrawal=withdrawal,
        back_off=back_off,
        negative_pressure=protocol.dwell_s + withdrawal + stroke,
        in_airway=insertion + back_off + build + protocol.dwell_s + withdrawal,
    )


POSITIVE = ("travel_mm", "insertion_mm_per_s", "withdrawal_mm_per_s", "vacuum_mmhg")
"""Fields of a protocol that mean nothing at 0 or below."""


def check_numbers(protocol: Protocol) -> None:
    """Refuse what no arithmetic is possible with. Raises InputError.

    A file's ranges are narrower and are checked where it is read; a protocol made in a program
    comes here first.
    """
    for name, value in zip(protocol._fields, protocol, strict=True):
        if not math.isfinite(value):
            raise InputError(f"{name} {value:g} should be a finite number")
        if name in POSITIVE and value <= 0.0:
            raise InputError(f"{name} {value:g} should be greater than 0")


class Refused(NamedTuple):
    """Reason why something cannot be done."""

    field: str
    """Of the protocol: what a person would change first."""
    sentence: str
    """With the arithmetic."""


def _refuse_times(protocol: Protocol, times: Timeline, by_contact: bool) -> Iterator[Refused]:
    """Refusals of times that do not fit their budget."""
    if times.negative_pressure > protocol.negative_pressure_budget_s:
        yield Refused(
            "dwell_s",
            f"negative pressure would last {times.negative_pressure:.1f} s = dwell "
            f"{times.dwell:.1f} s + withdrawal {times.withdrawal:.1f} s + valve stroke "
            f"{times.stroke:.1f} s; the budget is {protocol.negative_pressure_budget_s:g} s: "
            "shorten dwell_s, raise withdrawal_mm_per_s or reduce travel_mm",
        )
    if times.in_airway > protocol.in_airway_budget_s:
        backing = f"back-off {times.back_off:.1f} s + " if by_contact else ""
        building = f"vacuum {times.build:.1f} s + " if times.build else ""
        yield Refused(
            "in_airway_budget_s",
            f"the catheter would be in the airway for {times.in_airway:.1f} s = insertion "
            f"{times.insertion:.1f} s + {backing}{building}dwell {times.dwell:.1f} s + withdrawal "
            f"{times.withdrawal:.1f} s; the budget is {protocol.in_airway_budget_s:g} s",
        )


def refusals(
    protocol: Protocol, abilities: Abilities, site: Site, by_contact: bool
) -> Iterator[Refused]:
    """All that cannot be done of a protocol whose numbers are some (`check_numbers`)."""
    times = timeline(protocol, abilities, site, by_contact)
    least_cap = protocol.travel_mm + CAP_MARGIN_MM
    if protocol.cap_mm < least_cap:
        yield Refused(
            "cap_mm",
            f"cap_mm {protocol.cap_mm:g} mm is nearer than {CAP_MARGIN_MM:g} mm to travel_mm "
            f"{protocol.travel_mm:g} mm: set cap_mm to {least_cap:g} mm or more",
        )
    yield from _refuse_times(protocol, times, by_contact)
    needed = times.stroke + crossing_s(abilities, abilities.gap_out_mm)
    if protocol.dwell_s < needed:
        yield Refused(
            "dwell_s",
            f"dwell_s {protocol.dwell_s:g} s is too short: the valve stroke takes "
            f"{times.stroke:.1f} s and the gap of the way back {needed - times.stroke:.1f} s",
        )
    insertion, withdrawal = protocol.insertion_mm_per_s, protocol.withdrawal_mm_per_s
    fastest = max(insertion, withdrawal)
    if fastest > abilities.head_mm_per_s:
        yield Refused(
            "withdrawal_mm_per_s" if withdrawal >= insertion else "insertion_mm_per_s",
            f"a speed of {fastest:g} mm/s is more than this machine's head can do "
            f"({abilities.head_mm_per_s:g} mm/s)",
        )
    if by_contact and protocol.contact_from_mm >= protocol.travel_mm:
        yield Refused(
            "contact_from_mm",
            f"contact_from_mm {protocol.contact_from_mm:g} mm should be less than travel_mm "
            f"{protocol.travel_mm:g} mm, where the search for contact ends",
        )


def check(protocol: Protocol, abilities: Abilities, site: Site, by_contact: bool) -> None:
    """Refuse what cannot be done. Raises InputError with the arithmetic in one line."""
    check_numbers(protocol)
    for refused in refusals(protocol, abilities, site, by_contact):
        raise InputError(refused.sentence)


def _overdue_s(planned_s: float) -> float:
    return OVERDUE_SHARE * planned_s + SETTLE_S


def phase_limits(
    times: Timeline, abilities: Abilities, excitation: Excitation, testing: CheckPlan
) -> tuple[float, ...]:
    """Longest duration of each phase, s: its plan, half of it again and time to settle.

    The items of the pre-use test have limits of their own; the phase ends after all of them.
    Infinite where a person acts.
    """
    abort = times.withdrawal + crossing_s(abilities, abilities.gap_out_mm) + times.stroke
    limits_s = {
        Phase.CHECKING: sum(testing.limits_s) + SETTLE_S,
        Phase.PRELOADING: _overdue_s(times.preload + KEPT_S),
        Phase.INSERTING: _overdue_s(times.insertion),
        Phase.BACKING_OFF: _overdue_s(times.back_off),
        Phase.OPENING: _overdue_s(times.stroke),
        Phase.SUCTIONING: _overdue_s(times.dwell),
        Phase.WITHDRAWING: _overdue_s(times.withdrawal),
        Phase.CLOSING: _overdue_s(times.stroke),
        Phase.ABORTING: _overdue_s(abort),
        Phase.IDENTIFYING: excitation.duration_s + SETTLE_S,
    }
    return tuple(limits_s.get(phase, math.inf) for phase in Phase)


def longest_cycle_s(plan: Plan) -> float:
    """Longest that a cycle may take before one of its phases is overdue."""
    return sum(plan.limits_s[phase] for phase in CYCLE)


def suction_mm(protocol: Protocol, site: Site) -> float:
    """Deepest suction by contact: off the middle of what the search may be beyond the carina.

    None is too deep where the tip sucks where it stopped.
    """
    if protocol.backoff_mm == 0.0:
        return math.inf
    return 0.5 * (site.carina_mm + protocol.travel_mm) - protocol.backoff_mm


def pace_plan(protocol: Protocol, abilities: Abilities, by_contact: bool) -> PacePlan:
    """Plan of the early end of the dwell, and of the pace of the way out.

    The gap of the way back is crossed while nothing comes; a back-off has crossed it.
    """
    crossed = by_contact and protocol.backoff_mm > 0.0
    gap_lead_s = 0.0 if crossed else crossing_s(abilities, abilities.gap_out_mm)
    waits = protocol.nothing_comes_s > 0.0
    return PacePlan(
        nothing_comes_s=max(protocol.nothing_comes_s, gap_lead_s) if waits else 0.0,
        gap_lead_s=gap_lead_s,
        slow_ratio=min(SLOW_MM_PER_S / protocol.withdrawal_mm_per_s, 1.0),
        ramp_s=protocol.withdrawal_mm_per_s / (PACE_SHARE * abilities.acceleration_mm_per_s2),
    )


def plan(
    protocol: Protocol,
    abilities: Abilities,
    excitation: Excitation,
    by_contact: bool,
    site: Site,
) -> Plan:
    """The plan of a protocol on a machine. Raises InputError where it cannot be done.

    by_contact: the tip stops where the contact switch closes, and ``travel_mm`` is where the
    search for it ends.
    """
    check(protocol, abilities, site, by_contact)
    times = timeline(protocol, abilities, site, by_contact)
    testing = plan_check(
        protocol.vacuum_mmhg, abilities.relief_mmhg, abilities.jog_mm, times.stroke
    )
    return Plan(
        motion=motion(protocol, abilities, site),
        contact=ContactSearch(
            enabled=by_contact,
            window_start_mm=protocol.contact_from_mm,
            nearest_mm=nearest_contact_mm(protocol),
            backoff_mm=protocol.backoff_mm,
            suction_mm=suction_mm(protocol, site),
        ),
        check=testing,
        plausible=teaching.PLAUSIBLE[site.age],
        excitation=excitation,
        preload_s=times.preload,
        dwell_s=times.dwell,
        gap_lead_s=crossing_s(abilities, abilities.gap_out_mm),
        pace=pace_plan(protocol, abilities, by_contact),
        flow=UNSEEN,
        vacuum_mmhg=protocol.vacuum_mmhg,
        build_most_s=min(_overdue_s(times.build), VACUUM_LIMIT_S),
        way_in_mmhg=way_in_mmhg(protocol, site.age),
        cam_open_rad=abilities.cam_open_rad,
        pump_rests_open=False,
        bench_only=protocol.bench_only,
        travel_known=True,
        limits_s=phase_limits(times, abilities, excitation, testing),
    )
