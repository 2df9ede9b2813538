"""Settings of the controller from what is known of the machine, the protocol and a calibration."""

from typing import NamedTuple

from opensuction.control import compensation
from opensuction.control.compensation import Compensation, CompensationKind
from opensuction.control.head_path import HeadLimits
from opensuction.control.servo import Servo
from opensuction.control.valve import ValveMotion
from opensuction.controller.controller import Settings
from opensuction.controller.machine_profile import MachineProfile
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.kernel.errors import InputError
from opensuction.procedure import planner
from opensuction.procedure.planner import Abilities
from opensuction.procedure.protocol import Protocol
from opensuction.procedure.schedule import ON_REQUEST_ONLY, Schedule
from opensuction.procedure.site import Site
from opensuction.procedure.upkeep import LIFE_S, Service
from opensuction.safety import limits as bounds
from opensuction.safety.limits import Limits

OUTSIDE_MARGIN_MM = 1.0
"""The parked interval plus this counts as outside on a machine that parks at the boundary."""
VACUUM_MARGIN = 1.25
"""Line vacuum over the set point that is a fault."""
CONTACT_S = 2.0
"""Longest contact with the carina; one without back-off keeps it for its suction (paper)."""
WITHDRAWAL_MARGIN_S = 3.0
"""Time added to a withdrawal at full speed before it counts as failed."""


class Feedforward(NamedTuple):
    """Servo feedforward of the insertion axis, found by calibration; zeros for the paper's PD."""

    velocity_v_s_per_mm: float
    friction_v: float


PLAIN_PD = Feedforward(velocity_v_s_per_mm=0.0, friction_v=0.0)


class Calibration(NamedTuple):
    """What an identification run found."""

    model: ModifiedDahl
    feedforward: Feedforward


def _gaps_mm(kind: int, model: ModifiedDahl) -> tuple[float, float]:
    """Head travel across the gap, inwards and outwards, that the compensator will ask for."""
    if kind != CompensationKind.EXACT_INVERSE:
        return 0.0, 0.0
    full = float(modified_dahl.saturation_mm(model))
    return abs(modified_dahl.gap_move(model, full, 1.0)), abs(
        modified_dahl.gap_move(model, -full, -1.0)
    )


JOG_MM = 2.0
"""Head travel of the pre-use test: ten times what a servo settles to; assumed."""
JOG_SHARE = 0.25
"""Share of the narrowest gap thought possible that it may take at most; assumed."""


def _jog_mm(model: ModifiedDahl) -> float:
    gap_mm = float(modified_dahl.gap_mm(model))
    tip = bounds.tip_bounds(gain=model.slope, offset_mm=model.offset_mm, gap_mm=gap_mm)
    return min(JOG_MM, JOG_SHARE * tip.narrow_mm)


def _servos(profile: MachineProfile, kind: int, feedforward: Feedforward) -> tuple[Servo, Servo]:
    lead = profile.head_time_constant_s
    if kind != CompensationKind.EXACT_INVERSE:
        feedforward, lead = PLAIN_PD, 0.0
    insertion = Servo(
        proportional_v=profile.insertion_p_v_per_mm,
        derivative_v_s=profile.insertion_d_v_s_per_mm,
        velocity_v_s=feedforward.velocity_v_s_per_mm,
        friction_v=feedforward.friction_v,
        time_constant_s=lead,
        voltage_limit_v=profile.supply_v,
    )
    valve = Servo(
        proportional_v=profile.valve_p_v_per_rad,
        derivative_v_s=profile.valve_d_v_s_per_rad,
        velocity_v_s=0.0,
        friction_v=0.0,
        time_constant_s=0.0,
        voltage_limit_v=profile.supply_v,
    )
    return insertion, valve


def limits(
    profile: MachineProfile,
    protocol: Protocol,
    model: ModifiedDahl,
    park_head_mm: float,
    site: Site,
    stays_on_carina: bool,
) -> Limits:
    """Governor's limits for a protocol, on the transmission that was identified (or nominal).

    stays_on_carina: suction takes place where the contact switch closed, without backing off.
    """
    tip = bounds.tip_bounds(
        gain=model.slope, offset_mm=model.offset_mm, gap_mm=float(modified_dahl.gap_mm(model))
    )
    parked = bounds.deepest_mm(tip, bounds.anywhere(tip, park_head_mm))
    farthest_mm = protocol.cap_mm - site.park_mm + float(modified_dahl.gap_mm(model))
    return Limits(
        tip=tip,
        cap_mm=protocol.cap_mm,
        # The bench parks on its boundary; a machine that parks behind it is out at the boundary.
        outside_mm=max(float(parked) + OUTSIDE_MARGIN_MM, site.boundary_mm),
        park_head_mm=park_head_mm,
        head_speed_mm_per_s=profile.head_limit_mm_per_s,
        following_mm=profile.following_mm,
        stalled_mm=profile.stalled_mm,
        vacuum_mmhg=VACUUM_MARGIN * protocol.vacuum_mmhg,
        negative_pressure_s=protocol.negative_pressure_budget_s,
        in_airway_s=protocol.in_airway_budget_s,
        contact_s=protocol.negative_pressure_budget_s if stays_on_carina else CONTACT_S,
        withdrawal_s=farthest_mm / profile.head_planned_mm_per_s + WITHDRAWAL_MARGIN_S,
    )


def _check_cap(chosen: Compensation, protocol: Protocol, highest_mm: float) -> None:
    """Refuse a cap that would stop the head short of the target."""
    model, needed_mm = chosen.model, protocol.travel_mm
    if chosen.kind != CompensationKind.NONE:
        lag_mm = float(modified_dahl.saturation_mm(model))
        needed_mm = (protocol.travel_mm + lag_mm - model.offset_mm) / model.slope
    if needed_mm > highest_mm:
        least_mm = protocol.cap_mm + model.slope * (needed_mm - highest_mm)
        raise InputError(
            f"cap_mm {protocol.cap_mm:g} mm allows the head {highest_mm:.1f} mm in case the gap of "
            f"{modified_dahl.gap_mm(model):.1f} mm has shrunk, and travel_mm "
            f"{protocol.travel_mm:g} mm needs {needed_mm:.1f} mm: "
            f"set cap_mm to {least_mm:.1f} mm or more"
        )


def compensator(
    profile: MachineProfile, kind: CompensationKind, calibration: Calibration
) -> Compensation:
    """Compensation by kind, on a calibrated (or nominal) model, within the machine's limits."""
    return Compensation(
        kind=int(kind),
        model=calibration.model,
        limits=HeadLimits(
            speed_mm_per_s=profile.head_planned_mm_per_s,
            acceleration_mm_per_s2=profile.acceleration_mm_per_s2,
        ),
    )


def abilities(
    profile: MachineProfile, kind: CompensationKind, calibration: Calibration, site: Site
) -> Abilities:
    """What the planner must know of a machine with its compensation."""
    chosen = compensator(profile, kind, calibration)
    gap_in, gap_out = _gaps_mm(kind, calibration.model)
    return Abilities(
        head_mm_per_s=profile.head_planned_mm_per_s,
        acceleration_mm_per_s2=profile.acceleration_mm_per_s2,
        park_head_mm=compensation.parked(chosen, site.park_mm).head_mm,
        settle_mm=profile.settle_mm,
        cam_open_rad=profile.cam_open_rad,
        cam_rad_per_s=profile.cam_rad_per_s,
        gap_in_mm=gap_in,
        gap_out_mm=gap_out,
        jog_mm=_jog_mm(calibration.model),
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
        name = kind.name.lower().replace("_", "-")
        raise InputError(
            f"compensation '{name}' cannot back off {protocol.backoff_mm:g} mm after contact: "
            f"{CANNOT_BACK_OFF[kind]}; set backoff_mm to 0 or compensation to exact-inverse"
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
    if by_contact:
        _check_back_off(kind, protocol)
    chosen = compensator(profile, kind, calibration)
    parked = compensation.parked(chosen, site.park_mm)
    able = abilities(profile, kind, calibration, site)
    insertion, valve = _servos(profile, kind, calibration.feedforward)
    stays_on_carina = by_contact and protocol.backoff_mm == 0.0
    held = limits(profile, protocol, calibration.model, parked.head_mm, site, stays_on_carina)
    plan = planner.plan(protocol, able, profile.excitation, by_contact, site)
    _check_cap(chosen, protocol, float(bounds.head_cap_mm(held.tip, held.cap_mm)))
    service = Service(
        life_s=LIFE_S,
        cycle_s=planner.longest_cycle_s(plan.limits_s),
        schedule=ON_REQUEST_ONLY,
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
    )


def scheduled(settings: Settings, schedule: Schedule) -> Settings:
    """The same settings with cycles that begin, or are asked for, by the clock."""
    return settings._replace(service=settings.service._replace(schedule=schedule))
