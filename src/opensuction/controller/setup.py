"""Settings of the controller from what is known of the machine, the protocol and a calibration.

Run-in of the head: its lead over the reference at a start, rehearsed on its model beforehand.
"""

import math
from collections.abc import Callable

import numpy as np

from opensuction.control import compensation, preview
from opensuction.control.backlash_inverse import Curves
from opensuction.control.compensation import (
    FED_FORWARD,
    LOOKS_AHEAD,
    ON_PLAYS,
    RUNS_IN,
    Branches,
    Compensation,
    CompensationKind,
)
from opensuction.control.motion_profile import HeadLimits, Profile
from opensuction.control.preview import RunIn, Start
from opensuction.control.servo import Servo, ValveMotion
from opensuction.controller.calibration import PLAIN_PD, Calibration, Feedforward
from opensuction.controller.governor_limit import free_flow, limits
from opensuction.controller.machine_profile import MachineProfile
from opensuction.controller.record import Settings
from opensuction.hysteresis import modified_dahl, play_sum, prandtl_ishlinskii
from opensuction.hysteresis.bank.play_lines import Table
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.kernel.errors import InputError
from opensuction.kernel.unit import ATMOSPHERE_MMHG, ML_PER_S
from opensuction.kernel.vocabulary import name_of
from opensuction.procedure.cycle.interlocks import LIFE_S, Service
from opensuction.procedure.cycle.plan import TUBE_END_MM
from opensuction.procedure.cycle.schedule import ON_REQUEST_ONLY, Schedule
from opensuction.procedure.planning import guideline, planner
from opensuction.procedure.planning.planner import Abilities
from opensuction.procedure.planning.protocol import Protocol, Site
from opensuction.safety.alarm import alarm_state
from opensuction.safety.alarm.alarm_signal import REMINDER
from opensuction.safety.limits import bound_tip, head_cap_mm

RUN_INS_S = tuple(0.01 * step for step in range(16))
"""Run-ins that are tried: the best of the machines here lie at 0.04 to 0.1 s."""
LIKELY_RUN_IN_S = 0.06
"""Where the search begins; the nearer to the best, the sooner the others are seen to be worse."""
LONG_RUN_INS_S = (*RUN_INS_S, *(0.05 * step for step in range(4, 31)))
"""Likewise of a model whose tip creeps along while a gap is crossed: then the crossing itself is
what begins early, and 25 mm take 1.5 s."""
REHEARSAL_TICK_S = 0.001
"""The control loop's own tick."""
REHEARSED_MM = 90.0
"""Length of the rehearsed move: longer than what its start needs."""


def _best_s(run_ins_s: tuple[float, ...], rehearse: Callable[[float, float], float]) -> float:
    """The one of some run-ins that leaves the smallest tip error at the start of a move.

    rehearse: the error of a run-in, s; carried to its end while it is below the second number.
    """
    best = (math.inf, 0.0)
    for run_in_s in sorted(run_ins_s, key=lambda run_in_s: abs(run_in_s - LIKELY_RUN_IN_S)):
        # A rehearsal ends as soon as it is worse than the best one before.
        best = min(best, (float(rehearse(run_in_s, best[0])), run_in_s))
    return best[1]


def find(
    model: PrandtlIshlinskii,
    table: Table | None,
    limits: HeadLimits,
    speeds_mm_per_s: tuple[float, float],
) -> RunIn:
    """The best run-ins inwards and outwards.

    table: of the model that drives; None: the plays do. speeds_mm_per_s: of the tip when it starts
    inwards and outwards. Where the gain changes with the place the start inwards is rehearsed at
    the tube's end, the one outwards deep inside. Raises InputError for too many plays.
    """
    inwards, outwards = (
        Profile(0.0, REHEARSED_MM, speed, limits.acceleration_mm_per_s2)
        for speed in speeds_mm_per_s
    )
    if table is not None:
        return RunIn(
            _of_table(table, limits, Start(TUBE_END_MM, 1.0, inwards)),
            _of_table(table, limits, Start(REHEARSED_MM, -1.0, outwards)),
        )
    plays = play_sum.bundle(model)
    return RunIn(*(_of_plays(plays, limits, move) for move in (inwards, outwards)))


def _of_plays(plays: play_sum.PlaySum, limits: HeadLimits, move: Profile) -> float:
    return _best_s(
        RUN_INS_S,
        lambda run_in_s, most: preview.rehearse(
            plays, limits, move, run_in_s, REHEARSAL_TICK_S, most
        ),
    )


def _of_table(table: Table, limits: HeadLimits, start: Start) -> float:
    return _best_s(
        LONG_RUN_INS_S,
        lambda run_in_s, most: preview.rehearse_model(
            table, limits, start, run_in_s, REHEARSAL_TICK_S, most
        ),
    )


AUDIO_PAUSE_S = 120.0
"""Length of an audio pause: the longest that is allowed."""
GAPS_LOOKED_AT = 10
"""Depths of a cycle at which the gap of a model is looked at that changes with the place."""


def _plays_gap_mm(plays: PrandtlIshlinskii) -> float:
    """Head travel across the gap of the plays after a long travel the other way."""
    positions = prandtl_ishlinskii.retracted_positions_mm(plays, 0.0)
    here_mm = prandtl_ishlinskii.output_mm(plays, positions, 0.0)
    touched_mm = here_mm + preview.TOUCH_MM
    return float(prandtl_ishlinskii.inverse_step(plays, positions, 0.0, touched_mm))


def _lines_gap_mm(table: Branches) -> float:
    """Head travel across the widest gap that plays with lines have along a cycle, either way.

    As far as the tip may go early: where it creeps along, the crossing is part of the run-in.
    """
    widest_mm = 0.0
    for tip_mm in np.linspace(TUBE_END_MM, REHEARSED_MM, GAPS_LOOKED_AT).tolist():
        for direction in (1.0, -1.0):
            rest = preview.at_rest(table, tip_mm, -direction)
            crossed = preview.cross(table, rest, direction * preview.EARLY_MM)
            widest_mm = max(widest_mm, abs(crossed.head_mm - rest.head_mm))
    return widest_mm


def _gap_mm(chosen: Compensation, heads_mm: Branches | None) -> float:
    """Head travel across the gap, the widest there is: by the model that the kind is on."""
    if chosen.kind in ON_PLAYS:
        return _plays_gap_mm(play_sum.unbundle(chosen.plays))
    if chosen.kind == CompensationKind.EXACT_INVERSE:
        full = float(modified_dahl.saturation_mm(chosen.model))
        return abs(float(modified_dahl.gap_move(chosen.model, full, 1.0)))
    if heads_mm is not None:
        if chosen.kind == CompensationKind.MODEL_PREVIEW:
            return _lines_gap_mm(heads_mm)
        return float(np.max(heads_mm[0] - heads_mm[1]))
    return 0.0


CATCH_UP_MM_PER_S = 10.0
"""By how much a head that has fallen behind may go in faster than planned: one whose motor lets go
again coasts 3 mm from 20 mm/s, less than the cap lies beyond a cycle's end [computed]."""
JOG_MM = 2.0
"""Head travel of the pre-use test: ten times what a servo settles to; assumed."""
JOG_SHARE = 0.25
"""Share of the narrowest gap thought possible that it may take at most; assumed."""


def _jog_mm(model: ModifiedDahl) -> float:
    gap_mm = float(modified_dahl.gap_mm(model))
    tip = bound_tip(gain=model.slope, offset_mm=model.offset_mm, gap_mm=gap_mm)
    return min(JOG_MM, JOG_SHARE * tip.narrow_mm)


def _servos(
    profile: MachineProfile, kind: int, feedforward: Feedforward, bench_only: bool
) -> tuple[Servo, Servo]:
    """Of head and valve. bench_only: nobody is on the machine, and its head may be in a hurry."""
    lead, supply_v = profile.head_time_constant_s, profile.supply_v
    back_emf_v_s = supply_v / profile.no_load_mm_per_s
    if kind not in FED_FORWARD:
        feedforward, lead = PLAIN_PD, 0.0
    insertion = Servo(
        proportional_v=profile.insertion_p_v_per_mm,
        derivative_v_s=profile.insertion_d_v_s_per_mm,
        velocity_v_s=feedforward.velocity_v_s_per_mm,
        friction_v=feedforward.friction_v,
        time_constant_s=lead,
        voltage_limit_v=supply_v,
        back_emf_v_s=back_emf_v_s,
        catch_up_v=supply_v if bench_only else back_emf_v_s * CATCH_UP_MM_PER_S,
    )
    valve = Servo(
        proportional_v=profile.valve_p_v_per_rad,
        derivative_v_s=profile.valve_d_v_s_per_rad,
        velocity_v_s=0.0,
        friction_v=0.0,
        time_constant_s=0.0,
        voltage_limit_v=supply_v,
        back_emf_v_s=0.0,
        catch_up_v=supply_v,
    )
    return insertion, valve


def check_cap(
    chosen: Compensation, heads_mm: Branches | None, protocol: Protocol, highest_mm: float
) -> None:
    """Refuse a cap that would stop the head short of the target."""
    model = chosen.model
    needed_mm = compensation.head_after_travel_mm(chosen, heads_mm, protocol.travel_mm, 1.0)
    if needed_mm > highest_mm:
        least_mm = protocol.cap_mm + model.slope * (needed_mm - highest_mm)
        raise InputError(
            f"cap_mm {protocol.cap_mm:g} mm allows the head {highest_mm:.1f} mm in case the gap of "
            f"{modified_dahl.gap_mm(model):.1f} mm has shrunk, and travel_mm "
            f"{protocol.travel_mm:g} mm needs {needed_mm:.1f} mm: "
            f"set cap_mm to {least_mm:.1f} mm or more"
        )


def _curves(kind: CompensationKind, calibration: Calibration) -> Curves:
    return calibration.width if kind == CompensationKind.GAP_WIDTH else calibration.table


def branches(kind: CompensationKind, calibration: Calibration) -> Branches | None:
    """The curves or the table that a compensation of a kind is on; they go with its settings."""
    return compensation.branches(kind, _curves(kind, calibration), calibration.lines)


def compensator(
    profile: MachineProfile,
    kind: CompensationKind,
    calibration: Calibration,
    speeds_mm_per_s: tuple[float, float] | None = None,
) -> Compensation:
    """Compensation by kind, on a calibrated (or nominal) model, within the machine's limits.

    speeds_mm_per_s: of the tip when it starts inwards and outwards; a kind that runs in rehearses
    both starts. Without them it has no run-in: enough to plan with.
    """
    limits = HeadLimits(
        speed_mm_per_s=profile.head_planned_mm_per_s,
        acceleration_mm_per_s2=profile.acceleration_mm_per_s2,
    )
    run_in = RunIn(0.0, 0.0)
    if kind in RUNS_IN and speeds_mm_per_s is not None:
        table = branches(kind, calibration)
        run_in = find(calibration.plays, table, limits, speeds_mm_per_s)
    return compensation.choose(
        kind,
        limits,
        calibration.model,
        calibration.plays,
        _curves(kind, calibration),
        run_in,
    )


def abilities(
    profile: MachineProfile, kind: CompensationKind, calibration: Calibration, site: Site
) -> Abilities:
    """Abilities of a machine with its compensation, for the planner."""
    chosen, heads_mm = compensator(profile, kind, calibration), branches(kind, calibration)
    turn_mm = _gap_mm(chosen, heads_mm)
    ahead_mm = turn_mm if kind in LOOKS_AHEAD else 0.0
    if kind in RUNS_IN:
        # Room for the run-in, wherever its best length turns out to lie.
        ahead_mm += RUN_INS_S[-1] * profile.head_planned_mm_per_s
    return Abilities(
        head_mm_per_s=profile.head_planned_mm_per_s,
        acceleration_mm_per_s2=profile.acceleration_mm_per_s2,
        park_head_mm=compensation.rest(chosen, heads_mm, site.park_mm).head_mm,
        settle_mm=profile.settle_mm,
        cam_open_rad=profile.cam_open_rad,
        cam_rad_per_s=profile.cam_rad_per_s,
        relief_mmhg=profile.relief_mmhg,
        jog_mm=_jog_mm(calibration.model),
        gap_in_mm=ahead_mm,
        gap_out_mm=ahead_mm,
        pump_mmhg_per_s=profile.pump_l_per_min * ML_PER_S * ATMOSPHERE_MMHG / profile.canister_ml,
        pump_occluded_mmhg=profile.pump_occluded_mmhg,
        turn_mm=max(turn_mm, ahead_mm),
    )


CANNOT_BACK_OFF = {
    CompensationKind.NONE: "the head would not cross the gap",
    # Its jump at the reversal crosses a part of it: 10 mm ended 7 mm off the carina.
    CompensationKind.DIRECT_INVERSE: "as printed, the head crosses only a part of the gap",
}
"""Compensations after which a back-off ends short of its distance, and why."""


def _check_back_off(kind: CompensationKind, protocol: Protocol) -> None:
    """Refuse a back-off that would end inside the gap, the tip too near to the carina."""
    if kind in CANNOT_BACK_OFF and protocol.backoff_mm > 0.0:
        raise InputError(
            f"compensation '{name_of(kind)}' cannot back off {protocol.backoff_mm:g} mm "
            f"after contact: {CANNOT_BACK_OFF[kind]}; "
            "set backoff_mm to 0 or compensation to preview"
        )


def plan_settings(
    profile: MachineProfile,
    protocol: Protocol,
    kind: CompensationKind,
    calibration: Calibration,
    by_contact: bool,
    site: Site,
) -> Settings:
    """As `settings`, without the rehearsal of a start: enough to see whether it can be done."""
    planner.check_numbers(protocol)
    if by_contact:
        _check_back_off(kind, protocol)
    chosen, heads_mm = compensator(profile, kind, calibration), branches(kind, calibration)
    parked = compensation.rest(chosen, heads_mm, site.park_mm)
    able = abilities(profile, kind, calibration, site)
    insertion, valve = _servos(profile, kind, calibration.feedforward, protocol.bench_only)
    held = limits(profile, protocol, calibration.model, parked.head_mm, site, by_contact)
    plan = planner.plan(protocol, able, profile.excitation, by_contact, site)
    rests_open = held.line.rests_open
    plan = plan._replace(pump_rests_open=rests_open)
    if protocol.nothing_comes_s > 0.0:
        flow = free_flow(profile, site.catheter_mm, protocol.vacuum_mmhg, rests_open)
        plan = plan._replace(flow=flow)
    check_cap(chosen, heads_mm, protocol, float(head_cap_mm(held.tip, held.cap_mm)))
    service = Service(
        life_s=LIFE_S,
        cycle_s=planner.longest_cycle_s(plan),
        schedule=ON_REQUEST_ONLY,
        passes=guideline.of(protocol.bench_only, site.age),
    )
    return Settings(
        plan=plan,
        service=service,
        compensation=chosen,
        parked=parked,
        insertion_servo=insertion,
        valve_servo=valve,
        valve_motion=ValveMotion(
            open_rad=profile.cam_open_rad, speed_rad_per_s=profile.cam_rad_per_s
        ),
        limits=held,
        alarms=alarm_state.check_settings(AUDIO_PAUSE_S, REMINDER.interval_s.value),
    )


def settings(
    profile: MachineProfile,
    protocol: Protocol,
    kind: CompensationKind,
    calibration: Calibration,
    by_contact: bool,
    site: Site,
) -> Settings:
    """Controller settings for one run. Raises InputError where the protocol cannot be done.

    by_contact: stop where the contact switch closes instead of after a known travel.
    site: the patient's (or the bench's) geometry.
    """
    unrehearsed = plan_settings(profile, protocol, kind, calibration, by_contact, site)
    inwards_mm_per_s = protocol.insertion_mm_per_s
    if site.park_mm < TUBE_END_MM:
        inwards_mm_per_s = max(inwards_mm_per_s, site.fast_mm_per_s)
    speeds = (inwards_mm_per_s, protocol.withdrawal_mm_per_s)
    return unrehearsed._replace(compensation=compensator(profile, kind, calibration, speeds))


def with_schedule(settings: Settings, schedule: Schedule) -> Settings:
    """The same settings with cycles that begin, or are asked for, by the clock."""
    return settings._replace(service=settings.service._replace(schedule=schedule))
