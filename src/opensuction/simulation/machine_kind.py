"""A kind of machine: what a name or a file describes, before a seed draws one machine of it.

The twin is what the machine does, the profile what its controller goes by. Where the controller
must know, the two are held against each other.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.controller import machine_profile
from opensuction.controller.machine_profile import MachineProfile
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.identification.estimator import modified_dahl
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.twin import parameter, preset, transmission_parameter
from opensuction.twin.conduit.play_line import SUM_OF_PLAYS as CLEARANCES
from opensuction.twin.conduit.play_line import TransmissionClass, TransmissionKind
from opensuction.twin.machine import catheter as catheter_model
from opensuction.twin.machine import transmission
from opensuction.twin.machine.catheter import Catheter, Conduit
from opensuction.twin.parameter_row import Parameter

SPEED_MARGIN = 1.05
"""The governor's speed limit may be this much over what the fastest machine does."""
ANGLE_TOLERANCE = 0.01
"""Share by which the controller's open angle may differ from the cam's stroke."""
IDENTIFYING_TICK_S = 0.01
"""Of the motion that a transmission of another class is identified by: .16 mm of head at most."""


RELIEF_MMHG = {AgeGroup.ADULT: 150.0, AgeGroup.CHILD: 110.0, AgeGroup.NEONATE: 90.0}
"""Where the mechanical relief valve opens, by age: the adult's as on the paper's pump, the others'
10 mmHg below what guidelines allow, for the stiffest one opens 5 later and the strongest pump's
whole flow through it takes 4.3 more [computed]."""


class MachineKind(NamedTuple):
    """Twin, controller's profile, catheter and conduit of one kind of machine."""

    preset: str
    """``bench`` has nobody on it; ``clinical`` has a patient."""
    table: dict[str, Parameter]
    profile: MachineProfile
    catheter: Catheter
    conduit: Conduit
    transmission: TransmissionClass = CLEARANCES
    """The table holds its parameters."""


def of_preset(name: str, age: AgeGroup | None) -> MachineKind:
    """A preset as it is set up for a patient's age (None: the bench), in its standard conduit.

    Catheter and relief valve are the age's.

    Raises InputError for an unknown name.
    """
    if name not in preset.MACHINE_TABLES:
        known = ", ".join(sorted(preset.MACHINE_TABLES))
        raise InputError(f"machine '{name}' is not known: one of {known}")
    chosen, table, profile = (
        catheter_model.PAPER,
        preset.MACHINE_TABLES[name],
        machine_profile.PROFILES[name],
    )
    if age is not None:
        chosen = catheter_model.CATHETERS[catheter_model.BY_AGE_GROUP[age]]
        opens_mmhg = RELIEF_MMHG[age]
        table = table | {"relief_mmhg": table["relief_mmhg"]._replace(value=opens_mmhg)}
        profile = profile._replace(relief_mmhg=opens_mmhg)
    laid = catheter_model.lay("standard", chosen)
    return MachineKind(name, table, profile, chosen, laid)


def equipped(kind: MachineKind, catheter: Catheter, conduit: Conduit) -> MachineKind:
    """The same machine with another catheter and conduit, and its controller told of the gap.

    Raises InputError where they do not fit each other.
    """
    catheter_model.check(catheter, conduit)
    known = machine_profile.PROFILES[kind.preset].transmission
    if kind.transmission.kind != TransmissionKind.PLAYS:
        known = _nominal_model(kind)
    told = kind.profile._replace(transmission=known)
    ratio = catheter_model.gap_ratio(catheter, conduit)
    return kind._replace(
        profile=machine_profile.with_gap(told, ratio), catheter=catheter, conduit=conduit
    )


def transmitting(kind: MachineKind, chosen: TransmissionClass) -> MachineKind:
    """The same machine with a transmission of another class, and its controller told of it.

    What a builder knows of such a machine is the nominal one's identification.
    """
    table = kind.table | transmission_parameter.rows(chosen)
    changed = kind._replace(table=table, transmission=chosen)
    return equipped(changed, kind.catheter, kind.conduit)


def _nominal_model(kind: MachineKind) -> ModifiedDahl:
    """Model identified from a kind's nominal transmission in the paper's conduit, without noise."""
    values = parameter.nominal(kind.table)
    conduit = preset.transmission_of(values, kind.transmission)
    excitation = kind.profile.excitation
    time_s = np.arange(round(excitation.duration_s / IDENTIFYING_TICK_S)) * IDENTIFYING_TICK_S
    turns = 2.0 * math.pi / excitation.period_s * time_s
    head_mm = 0.5 * excitation.range_mm * (1.0 - np.cos(turns))
    start = transmission.after_retract(conduit, 0.0)
    tip_mm = transmission.simulate(conduit, start, head_mm, IDENTIFYING_TICK_S)
    return modified_dahl.fit(head_mm, tip_mm).model


def _least(entry: Parameter) -> float:
    return entry.value - parameter.SPREAD_LIMIT * entry.spread


def _most(entry: Parameter) -> float:
    return entry.value + parameter.SPREAD_LIMIT * entry.spread


def check(kind: MachineKind) -> None:
    """Refuse a controller that goes by another machine than this one; raises InputError."""
    _check_supply(kind)
    _check_head(kind)
    _check_acceleration(kind)
    _check_cam(kind)
    _check_jam(kind)


def _check_supply(kind: MachineKind) -> None:
    given, known = kind.table["supply_v"].value, kind.profile.supply_v
    if given != known:
        raise InputError(
            f"controller.supply_v is {known:g} V and twin.supply_v {given:g} V: give both the same"
        )


def _check_head(kind: MachineKind) -> None:
    table, profile = kind.table, kind.profile
    supply, speed, friction = (
        table[name] for name in ("supply_v", "no_load_mm_per_s", "insertion_friction_v")
    )
    slowest = _least(speed) * (1.0 - _most(friction) / supply.value)
    if profile.head_planned_mm_per_s > slowest:
        raise InputError(
            f"controller.head_planned_mm_per_s is {profile.head_planned_mm_per_s:g} mm/s, and the "
            f"slowest such head does {slowest:.1f} mm/s = {_least(speed):.1f} mm/s without load x "
            f"(1 - {_most(friction):.2f} V of friction / {supply.value:g} V): plan with less"
        )
    fastest = SPEED_MARGIN * _most(speed)
    if profile.head_limit_mm_per_s > fastest:
        raise InputError(
            f"controller.head_limit_mm_per_s is {profile.head_limit_mm_per_s:g} mm/s, and the "
            f"fastest such head does {_most(speed):.1f} mm/s without load: a limit above "
            f"{SPEED_MARGIN:g} x {_most(speed):.1f} = {fastest:.1f} mm/s limits nothing"
        )
    if profile.head_planned_mm_per_s > profile.head_limit_mm_per_s:
        raise InputError(
            f"controller.head_planned_mm_per_s {profile.head_planned_mm_per_s:g} mm/s is above "
            f"head_limit_mm_per_s {profile.head_limit_mm_per_s:g} mm/s: the governor would hold "
            "every move back"
        )


def _check_acceleration(kind: MachineKind) -> None:
    table, wanted = kind.table, kind.profile.acceleration_mm_per_s2
    values = parameter.nominal(table)
    per_v = 1000.0 / (values["moving_mass_kg"] * preset.load_v_per_n(values))
    force, mass = values["drive_force_n"], values["moving_mass_kg"]
    friction = _most(table["insertion_friction_v"]) * per_v
    most = 1000.0 * force / mass - friction
    if wanted > most:
        raise InputError(
            f"controller.acceleration_mm_per_s2 is {wanted:g} mm/s^2, and {force:g} N / {mass:g} "
            f"kg less {friction:.0f} mm/s^2 of friction are {most:.0f} mm/s^2: plan with less or "
            "change the drive"
        )


def _check_cam(kind: MachineKind) -> None:
    values, profile = parameter.nominal(kind.table), kind.profile
    stroke, angle = values["cam_stroke_rad"], profile.cam_open_rad
    if abs(angle - stroke) > ANGLE_TOLERANCE * stroke:
        raise InputError(
            f"controller.cam_open_rad is {angle:.4g} rad and twin.cam_stroke_rad {stroke:.4g} rad, "
            f"so that the valve would open to {100.0 * angle / stroke:.0f} % of its stroke: give "
            "both the same"
        )
    load = values["valve_friction_v"] + values["spring_preload_v"]
    load += values["spring_v_per_rad"] * stroke
    most = values["cam_no_load_rad_per_s"] * (1.0 - load / values["supply_v"])
    if profile.cam_rad_per_s > most:
        raise InputError(
            f"controller.cam_rad_per_s is {profile.cam_rad_per_s:.3g} rad/s, and the cam does "
            f"{most:.3g} rad/s = {values['cam_no_load_rad_per_s']:.3g} rad/s without load x (1 - "
            f"{load:.2f} V of friction and spring / {values['supply_v']:g} V): plan with less"
        )


def _check_jam(kind: MachineKind) -> None:
    table, limit_n = kind.table, kind.profile.jam_n
    most_v = _most(table["insertion_friction_v"])
    friction_n = most_v / preset.load_v_per_n(parameter.nominal(table))
    if friction_n >= limit_n:
        raise InputError(
            f"controller.jam_n is {limit_n:g} N, and {most_v:.2f} V of friction in such a head are "
            f"{friction_n:.2f} N: the governor would take every move for a jam; give more"
        )
