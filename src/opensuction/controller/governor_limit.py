"""Limits of the governor for a protocol on a machine, with the margins they rest on.

Flow of the suction line with a free catheter, against which the procedure detects mucus.
"""

import math

from opensuction.controller.machine_profile import MachineProfile
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.kernel.unit import ATMOSPHERE_MMHG, BLASIUS_POWER, ML_PER_S
from opensuction.procedure.cycle.plan import TUBE_END_MM
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.procedure.planning.protocol import Protocol, Site, nearest_contact_mm
from opensuction.procedure.suction.line_flow import SAMPLE_S, FreeFlow
from opensuction.safety.limits import (
    GAP_MOST,
    DriveLimits,
    Limits,
    LineLimits,
    ValveLimits,
    WindowLimits,
    assume_anywhere,
    bound_tip,
    deepest_mm,
    limits_of,
)
from opensuction.safety.watch import tip_force
from opensuction.safety.watch.vacuum_signature import CLOSED_SHARE

MOUTH_MM = 10.0
"""Light barrier in the connector, above the patient's boundary: half way to where the tip parks."""
OUTSIDE_MARGIN_MM = 1.0
"""The parked interval plus this counts as outside on a machine that parks at the boundary."""
VACUUM_MARGIN = 1.25
"""Line vacuum over the set point that is a fault; so is more than a guideline allows."""
CONTACT_S = 2.0
"""Longest contact with the carina; one without back-off keeps it for its suction (paper)."""
WITHDRAWAL_MARGIN_S = 3.0
"""Time added to a withdrawal at full speed before it counts as failed."""
FORCE_MARGIN = 1.3
"""Force over the drive's own current limit that is a fault of the drive: limit, force for an ampere
and the sensor's gain at their worst are 1.21 of it [computed]."""
FRICTION_SHARE = 0.7
"""Friction over the resistance that is a jam [computed]."""
LEAST_GAIN_SHARE = 0.5
"""Share of the planned acceleration that every such drive can do: 3 N beyond friction on 1.7 times
the mass [computed]."""
LIGHT_SHARE = 0.4
"""By how much of it the moving mass may be less than the profile has it; assumed."""
ACCELERATION_MARGIN = 10.0
"""Gain of commanded speed over the planned acceleration that is let through: the paper's scheme
jumps where it turns, and its drive cannot follow at more than the planned one; assumed."""
WINDOW_MM = 1.0
"""Approach by contact: error of the model, and of where the head has settled; assumed."""
RELIEF_MARGIN_MMHG = 40.0
"""Vacuum over the relief valve's that the line is allowed while that is tested; assumed."""
SHOWN_SHARE = 0.8
"""Share of its set point to which an open line must fall to be told from a closed one."""
CLOGGED_SHARE = 0.85
"""Share of that fall that must come at least."""
OPEN_LOW_SHARE = 0.55
"""Share of what pump and open catheter agree on that they keep at least; assumed: a pump that has
lost a quarter of its flow keeps 0.6."""
REGULATED_RATIO = 1.5
"""Flow of the pump over the open catheter's from which the line keeps its set point; assumed."""
WALLS_MM = 0.5
"""Outer less inner diameter of a catheter [paper]: 4.0 - 3.5."""
BORE_MM = 3.5
"""Inner diameter of the paper's catheter."""
BORE_ML_PER_S_PER_ROOT = 29.5
"""Its flow for each root of the vacuum in mmHg: 17.7 L/min at 100 mmHg [computed], Blasius."""


def bore_ml_per_s_per_root(catheter_mm: float) -> float:
    """Flow of a free catheter of that outer diameter for each root of the vacuum in mmHg."""
    bore_share = (catheter_mm - WALLS_MM) / BORE_MM
    return float(BORE_ML_PER_S_PER_ROOT * bore_share**BLASIUS_POWER)


def line_limits(profile: MachineProfile, catheter_mm: float, vacuum_mmhg: float) -> LineLimits:
    """Limits of a sound line at a set point, through a free catheter of that outer diameter.

    Pump: ``Q (1 - P / P0)``; catheter: ``k sqrt(P)``. Where the two agree below the set point, an
    open valve shows in the line; a thin catheter draws too little to be seen.
    """
    pump = profile.pump_l_per_min * ML_PER_S
    occluded = profile.pump_occluded_mmhg
    per_root = bore_ml_per_s_per_root(catheter_mm)
    slope = pump / occluded
    root = (math.sqrt(per_root * per_root + 4.0 * slope * pump) - per_root) / (2.0 * slope)
    open_mmhg = min(root * root, vacuum_mmhg)
    drawn = per_root * math.sqrt(vacuum_mmhg)
    pumped = pump * max(1.0 - vacuum_mmhg / occluded, 0.0)
    per_ml = ATMOSPHERE_MMHG / profile.canister_ml
    open_share = open_mmhg / vacuum_mmhg
    shows = open_share <= SHOWN_SHARE
    return LineLimits(
        open_low_share=(
            CLOSED_SHARE if pumped >= REGULATED_RATIO * drawn else OPEN_LOW_SHARE * open_share
        ),
        clogged_share=open_share + CLOGGED_SHARE * (1.0 - open_share) if shows else math.inf,
        rests_open=not shows,
        open_fall_mmhg_per_s=per_ml * max(drawn - pumped, 0.0),
        bore_fall_mmhg_per_s=per_ml * drawn,
        bore_fall_mmhg_per_s_per_root=per_ml * per_root,
        parked_closed_mmhg=profile.relief_mmhg + RELIEF_MARGIN_MMHG,
    )


def _window(
    protocol: Protocol, model: ModifiedDahl, by_contact: bool, on_bench: bool
) -> WindowLimits:
    """Window in which contact may and must come; by travel none must, and none may in the tube."""
    if not by_contact:
        return WindowLimits(from_mm=-math.inf if on_bench else TUBE_END_MM, by_mm=math.inf)
    slack_mm = 0.5 * (GAP_MOST - 1.0) * float(modified_dahl.gap_mm(model)) + WINDOW_MM
    from_mm = nearest_contact_mm(protocol)
    return WindowLimits(from_mm=from_mm, by_mm=protocol.travel_mm - slack_mm)


def _gaining_most_mm_per_s2(profile: MachineProfile) -> float:
    """The drive at its highest force, friction with it, on the least mass that there may be."""
    force_n = FORCE_MARGIN * profile.drive_force_n + FRICTION_SHARE * profile.jam_n
    return 1000.0 * force_n / ((1.0 - LIGHT_SHARE) * profile.moving_mass_kg)


def limits(
    profile: MachineProfile,
    protocol: Protocol,
    model: ModifiedDahl,
    park_head_mm: float,
    site: Site,
    by_contact: bool,
) -> Limits:
    """Governor's limits for a protocol, on the transmission that was identified (or nominal)."""
    tip = bound_tip(
        gain=model.slope, offset_mm=model.offset_mm, gap_mm=float(modified_dahl.gap_mm(model))
    )
    parked = deepest_mm(tip, assume_anywhere(tip, park_head_mm))
    farthest_mm = protocol.cap_mm - site.park_mm + float(modified_dahl.gap_mm(model))
    on_bench = site.boundary_mm == TUBE_END_MM
    stays_on_carina = by_contact and protocol.backoff_mm == 0.0
    return Limits(
        tip=tip,
        drive=DriveLimits(
            newton_per_a=profile.newton_per_a,
            moving_mass_kg=profile.moving_mass_kg,
            jam_n=profile.jam_n,
            force_n=FORCE_MARGIN * profile.drive_force_n,
            supply_v=profile.supply_v,
            mm_per_s_per_v=profile.no_load_mm_per_s / profile.supply_v,
            volts_per_a=profile.winding_v_per_a,
            gaining_least_mm_per_s2=LEAST_GAIN_SHARE * profile.acceleration_mm_per_s2,
            gaining_most_mm_per_s2=_gaining_most_mm_per_s2(profile),
        ),
        window=_window(protocol, model, by_contact, on_bench),
        valve=ValveLimits(
            open_rad=profile.cam_open_rad, stroke_s=profile.cam_open_rad / profile.cam_rad_per_s
        ),
        line=line_limits(profile, site.catheter_mm, protocol.vacuum_mmhg),
        cap_mm=protocol.cap_mm,
        # The bench parks on its boundary; a machine that parks behind it is out at the boundary.
        outside_mm=max(float(parked) + OUTSIDE_MARGIN_MM, site.boundary_mm),
        mouth_mm=math.inf if on_bench else site.boundary_mm - MOUTH_MM,
        park_head_mm=park_head_mm,
        head_speed_mm_per_s=profile.head_limit_mm_per_s,
        head_mm_per_s2=ACCELERATION_MARGIN * profile.acceleration_mm_per_s2,
        braking_mm_per_s2=profile.acceleration_mm_per_s2,
        leaving_mm_per_s=profile.head_planned_mm_per_s,
        following_mm=profile.following_mm,
        stalled_mm=profile.stalled_mm,
        vacuum_mmhg=min(
            VACUUM_MARGIN * protocol.vacuum_mmhg,
            math.inf if protocol.bench_only else GUIDELINES[site.age].vacuum_mmhg,
        ),
        negative_pressure_s=protocol.negative_pressure_budget_s,
        in_airway_s=protocol.in_airway_budget_s,
        contact_s=protocol.negative_pressure_budget_s if stays_on_carina else CONTACT_S,
        # By travel no carina is to be touched, but by the hand that teaches where it is.
        driven_contact_s=math.inf if by_contact or on_bench else tip_force.IMPOSSIBLE_S,
        withdrawal_s=farthest_mm / profile.head_planned_mm_per_s + WITHDRAWAL_MARGIN_S,
        patient=limits_of(site.age, site.peep_cmh2o, site.monitored, site.breathes),
    )


REST_FREE_SHARE = 0.8
"""Share of a free catheter's flow from which only gas comes, seen while the pump rests. Mucus takes
.6 of the tip (assumed) and leaves .4; a canister half full makes .8 of that."""
CRITICAL_ML_PER_S_PER_MM = 27.1
"""Flow at the critical Reynolds number of 2,300 for each mm of bore [computed]: a thin bore has no
less at `THIN_MMHG`, for below it flow is laminar and meets less resistance."""
THIN_MMHG = 100.0
"""[computed] A bore of 1.5 mm is between laminar and turbulent there."""
NOISE_MMHG = 2.0
"""White noise of the vacuum sensor at `SAMPLE_S`; assumed."""
FLOW_ERROR = 0.1
"""Standard deviation that this noise may leave in the flow, as share of a free catheter's: half of
the way to where it is told from mucus."""
LEAST_WINDOW_S = 0.1
"""Shortest time over which the flow is measured beside a running pump; assumed."""


def _window_s(fall_mmhg_per_s: float) -> float:
    """Time in which a line fitted to the noise leaves that much of a fall.

    The slope of a line through n readings deviates by sqrt(12 / n) / T times what they do.
    """
    spread = math.sqrt(12.0 * SAMPLE_S) * NOISE_MMHG
    return float((spread / (FLOW_ERROR * fall_mmhg_per_s)) ** (2.0 / 3.0))


def free_flow(
    profile: MachineProfile, catheter_mm: float, vacuum_mmhg: float, at_rest: bool
) -> FreeFlow:
    """As the profile has the line, for a catheter of that outer diameter and a set point.

    at_rest: the pump rests with the valve open (`LineLimits.rests_open`). Beside a running pump the
    line is at its set point while mucus comes: what the pump takes out there bounds the flow.
    """
    pump = profile.pump_l_per_min * ML_PER_S
    per_mmhg = pump / profile.pump_occluded_mmhg
    thin = CRITICAL_ML_PER_S_PER_MM * (catheter_mm - WALLS_MM) / math.sqrt(THIN_MMHG)
    per_root = max(bore_ml_per_s_per_root(catheter_mm), thin)
    drawn = per_root * math.sqrt(vacuum_mmhg)
    canister = profile.canister_ml / ATMOSPHERE_MMHG
    window_s, free_share = _window_s(drawn / canister), REST_FREE_SHARE
    if not at_rest:
        window_s = max(window_s, LEAST_WINDOW_S)
        free_share = 0.5 * (1.0 + (pump - per_mmhg * vacuum_mmhg) / drawn)
    return FreeFlow(
        window_s=window_s,
        pump_ml_per_s=pump,
        pump_ml_per_s_per_mmhg=per_mmhg,
        bore_ml_per_s_per_root_mmhg=per_root,
        canister_ml_per_mmhg=canister,
        free_share=free_share,
        at_rest=at_rest,
    )
