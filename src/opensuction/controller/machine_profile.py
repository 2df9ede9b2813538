"""A machine as its controller knows it, with the source of each value.

Ranges are what a machine file may set; they are the project's own judgement of what is plausible.
Tags of the sources: docs/sources.md.
"""

import math
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Le

from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.kernel.vocabulary import Meaning
from opensuction.procedure.cycle.plan import Excitation


class MachineProfile(NamedTuple):
    """Profile of a machine for its controller: nominal values, not the twin's truth."""

    supply_v: Annotated[float, Ge(12), Le(48), Meaning("supply of both motors")]
    head_limit_mm_per_s: Annotated[
        float, Gt(0), Le(160), Meaning("head speed that the governor lets through")
    ]
    head_planned_mm_per_s: Annotated[
        float,
        Gt(0),
        Le(150),
        Meaning("head speed that is planned with: friction takes a part of the no-load speed"),
    ]
    acceleration_mm_per_s2: Annotated[float, Ge(10), Le(5000), Meaning("planned acceleration")]
    head_time_constant_s: Annotated[
        float, Ge(0), Le(0.2), Meaning("lead of the servo's feedforward")
    ]
    settle_mm: Annotated[
        float, Ge(0.05), Le(2), Meaning("the head has arrived when it is this near")
    ]
    following_mm: Annotated[
        float, Ge(1), Le(20), Meaning("distance from its command that is a fault of the head")
    ]
    stalled_mm: Annotated[
        float,
        Ge(0.01),
        Le(2),
        Meaning("distance from its command at which the servo overcomes any friction of the head"),
    ]
    contact_latency_s: Annotated[
        float, Ge(0), Le(0.05), Meaning("delay of the contact switch's line, nominal")
    ]
    cam_open_rad: Annotated[float, Ge(0.1), Le(1.6), Meaning("cam angle of the open valve")]
    cam_rad_per_s: Annotated[float, Ge(0.05), Le(10), Meaning("cam speed of a valve stroke")]
    insertion_p_v_per_mm: Annotated[float, Ge(1), Le(200), Meaning("P of the insertion axis")]
    insertion_d_v_s_per_mm: Annotated[float, Ge(0), Le(1), Meaning("D of the insertion axis")]
    valve_p_v_per_rad: Annotated[float, Ge(10), Le(5000), Meaning("P of the valve axis")]
    valve_d_v_s_per_rad: Annotated[float, Ge(0), Le(10), Meaning("D of the valve axis")]
    newton_per_a: Annotated[
        float, Gt(0), Le(10000), Meaning("force at the head for each ampere of its motor")
    ]
    no_load_mm_per_s: Annotated[
        float, Gt(0), Le(160), Meaning("head speed at full supply without friction or load")
    ]
    winding_v_per_a: Annotated[
        float,
        Gt(0),
        Le(1e5),
        Meaning("volts that drive an ampere through the insertion motor at standstill"),
    ]
    moving_mass_kg: Annotated[
        float, Gt(0), Le(100), Meaning("inertia of the drive, referred to the head")
    ]
    drive_force_n: Annotated[
        float, Gt(0), Le(20), Meaning("force at which the drive limits its current")
    ]
    jam_n: Annotated[
        float, Gt(0), Le(20), Meaning("resistance of the head that no friction explains")
    ]
    pump_l_per_min: Annotated[float, Gt(0), Le(60), Meaning("free-air flow of the pump")]
    pump_occluded_mmhg: Annotated[float, Gt(0), Le(720), Meaning("occluded vacuum of the pump")]
    canister_ml: Annotated[float, Gt(0), Le(4000), Meaning("empty canister and tubing")]
    relief_mmhg: Annotated[float, Gt(0), Le(200), Meaning("mechanical relief valve")]
    excitation: Excitation
    """Identification of the transmission over the stroke that is used."""
    transmission: ModifiedDahl
    """Nominal transmission: bounds the tip where nothing was identified."""


EXCITATION = Excitation(range_mm=100.0, period_s=20.0, duration_s=40.0)
"""Identification: head 0 to 100 mm and back, twice."""

BENCH = MachineProfile(
    supply_v=24.0,
    head_limit_mm_per_s=20.0,
    head_planned_mm_per_s=17.0,
    acceleration_mm_per_s2=200.0,
    head_time_constant_s=0.020,
    settle_mm=0.25,
    following_mm=8.0,
    stalled_mm=0.11,
    contact_latency_s=0.004,
    cam_open_rad=math.radians(30.0),
    cam_rad_per_s=math.radians(15.0),
    insertion_p_v_per_mm=10.0,
    insertion_d_v_s_per_mm=0.010,
    valve_p_v_per_rad=7.0 * 180.0 / math.pi,
    valve_d_v_s_per_rad=0.007 * 180.0 / math.pi,
    newton_per_a=833.0,
    no_load_mm_per_s=18.8,
    winding_v_per_a=1298.0,
    moving_mass_kg=16.4,
    drive_force_n=5.0,
    jam_n=1.4,
    pump_l_per_min=18.0,
    pump_occluded_mmhg=560.0,
    canister_ml=800.0,
    relief_mmhg=150.0,
    excitation=EXCITATION,
    transmission=modified_dahl.PUBLISHED,
)
"""The paper's bench."""

SOURCES: dict[str, str] = {
    "supply_v": "as the twin's",
    "head_limit_mm_per_s": "[computed] no-load speed of the fastest such machine",
    "head_planned_mm_per_s": "[computed] what the slowest still does against 1 V of friction",
    "acceleration_mm_per_s2": "[computed] 5 N less friction, on 16.4 kg referred mass: 260",
    "head_time_constant_s": "[assumed] as the twin's",
    "settle_mm": "[computed] .1 mm static error of P = 10 V/mm against 1 V of friction, and noise",
    "following_mm": "[computed] the paper's compensator jumps by 2.6 mm and its PD lags 2.4 mm at "
    "18 mm/s",
    "stalled_mm": "[computed] 1 V of friction against 10 V/mm, and two steps of the encoder",
    "contact_latency_s": "[assumed] as the twin's",
    "cam_open_rad": "[paper] IV-A: 30 deg",
    "cam_rad_per_s": "[paper] IV-A: 15 deg/s",
    "insertion_p_v_per_mm": "[paper] P = 10; the unit is ours",
    "insertion_d_v_s_per_mm": "[paper] D = 10; the unit is ours",
    "valve_p_v_per_rad": "[paper] P = 7, per degree; the unit is ours",
    "valve_d_v_s_per_rad": "[paper] D = 7, per degree; the unit is ours",
    "newton_per_a": "as the twin's: 1 / 0.0012 A/N",
    "no_load_mm_per_s": "as the twin's",
    "winding_v_per_a": "[computed] from the twin's time constant, mass and current: 1.557 V/N / "
    "0.0012 A/N",
    "moving_mass_kg": "as the twin's",
    "drive_force_n": "as the twin's",
    "jam_n": "[computed] 0.4 N of friction at most and 0.3 N at the tip; sound cycles reach 0.7 N; "
    "2 N more than the least friction is 2.2",
    "pump_l_per_min": "[paper]",
    "pump_occluded_mmhg": "[paper]",
    "canister_ml": "as the twin's",
    "relief_mmhg": "as the twin's",
}
"""Where the bench's values come from."""

CLINICAL = BENCH._replace(
    head_limit_mm_per_s=62.0,
    head_planned_mm_per_s=50.0,
    following_mm=12.0,
    cam_rad_per_s=math.radians(60.0),
    newton_per_a=259.7,
    no_load_mm_per_s=60.0,
    winding_v_per_a=81.1,
    jam_n=2.4,
    excitation=Excitation(range_mm=200.0, period_s=25.0, duration_s=50.0),
)
"""The bedside machine: the bench with another gear; the tip parks in the connector."""

CLINICAL_SOURCES: dict[str, str] = {
    "head_limit_mm_per_s": "[computed] no-load speed of the fastest such machine",
    "head_planned_mm_per_s": "[computed] less friction and the sag of a servo under load",
    "following_mm": "[computed] as the bench's, at the higher speed",
    "cam_rad_per_s": "[design] .5 s strokes: 60 deg/s",
    "newton_per_a": "as the twin's: 1 / 0.00385 A/N",
    "no_load_mm_per_s": "as the twin's",
    "winding_v_per_a": "[computed] as the bench's: 0.312 V/N / 0.00385 A/N",
    "jam_n": "[computed] 1.7 N of friction at most and 0.3 N at the tip; sound cycles reach 1.7 N; "
    "2 N more than the least friction is 2.9",
}
"""Where the values come from that differ at the bedside."""

PROFILES = {"bench": BENCH, "clinical": CLINICAL}
"""Machines by name, as their controllers know them."""


def with_gap(profile: MachineProfile, ratio: float) -> MachineProfile:
    """The same machine with a transmission whose gap is ``ratio`` times as wide.

    A bundle of plays with all widths times r is the same bundle in units of r: the decay goes with
    1 / r, slope and velocity gain stay.
    """
    model = profile.transmission
    return profile._replace(transmission=model._replace(decay_per_mm=model.decay_per_mm / ratio))
