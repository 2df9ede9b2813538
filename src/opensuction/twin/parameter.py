"""Every parameter of the twin: value, spread between machines, unit, meaning and source.

`BENCH` is the paper's bench, `CLINICAL` what differs at the bedside; catheters and patients change
both. This is the one documented place. ``spread`` is the standard deviation over machines; a seed
draws one machine. Sources: [paper] the paper; [datasheet] Faulhaber 1524T024SR; [calibrated]
chosen so that the bench reproduces the paper's identification and Table I; [computed] from the
others; [assumed] no source found.
"""

import math
import zlib
from typing import NamedTuple

from opensuction.kernel import random_stream

MACHINE_PURPOSE = 1
"""Stream of random numbers that draws machines."""
SPREAD_LIMIT = 2.5
"""Draws are cut off at this many standard deviations."""


class Parameter(NamedTuple):
    """One parameter of the twin."""

    value: float
    spread: float
    unit: str
    meaning: str
    source: str


def _p(value: float, unit: str, meaning: str, source: str, spread: float = 0.0) -> Parameter:
    return Parameter(value=value, spread=spread, unit=unit, meaning=meaning, source=source)


BENCH: dict[str, Parameter] = {
    # Insertion axis
    "supply_v": _p(24.0, "V", "supply of both motors", "[datasheet]"),
    "no_load_mm_per_s": _p(
        18.8, "mm/s", "head speed at full supply without friction", "[calibrated] Table I", 0.3
    ),
    "insertion_time_constant_s": _p(
        0.020, "s", "mechanical time constant of the insertion axis", "[assumed]"
    ),
    "moving_mass_kg": _p(
        16.4, "kg", "inertia of the drive, referred to the head", "[assumed] 0.3 m/s2 at 5 N"
    ),
    "insertion_friction_v": _p(
        0.5,
        "V",
        "Coulomb friction of motor, gear and guide, as a voltage",
        "[assumed] at most 1",
        0.05,
    ),
    "drive_force_n": _p(5.0, "N", "drive current limit, as force at the head", "[assumed]"),
    "drive_a_per_n": _p(
        0.0012,
        "A/N",
        "motor current for each newton at the head",
        "[computed] 18.8 mm/s / 24 V / 0.65 gear efficiency",
    ),
    "head_encoder_mm": _p(0.005, "mm", "resolution of the head position", "[assumed]"),
    "gear_backlash_mm": _p(0.10, "mm", "play of gearhead and rack", "[assumed] 0.05 to 0.2"),
    # Catheter in its conduit
    "bend_rad": _p(9.6, "rad", "total bend of the conduit", "[calibrated] paper's loop width", 0.5),
    "clearance_mm": _p(2.0, "mm", "conduit bore less catheter diameter", "[paper] 6.0 - 4.0"),
    "width_spread_mm": _p(
        2.0, "mm", "standard deviation of the clearances along the bends", "[calibrated]"
    ),
    "stretch_mm": _p(
        0.2, "mm", "friction-limited elastic stretch, both ways", "[computed] 0.1 N / 1 N per mm"
    ),
    "gain": _p(0.949, "mm/mm", "tip travel for each mm of head travel", "[calibrated]", 0.003),
    "gain_per_100mm": _p(0.01, "1", "change of that gain over 100 mm of depth", "[assumed]", 0.003),
    "offset_mm": _p(-6.0, "mm", "tip position at head 0 without clearance", "[calibrated]", 0.25),
    "creep_fast_mm": _p(0.15, "mm", "fast part of the polymer's creep", "[assumed] at most 0.3"),
    "creep_fast_s": _p(0.5, "s", "its time constant", "[assumed] 0.3 to 10"),
    "creep_slow_mm": _p(0.10, "mm", "slow part of the polymer's creep", "[assumed]"),
    "creep_slow_s": _p(5.0, "s", "its time constant", "[assumed]"),
    # Valve axis
    "cam_no_load_rad_per_s": _p(
        math.radians(90.0), "rad/s", "cam speed at full supply without friction", "[assumed]"
    ),
    "valve_time_constant_s": _p(0.020, "s", "mechanical time constant of the cam", "[assumed]"),
    "valve_friction_v": _p(0.5, "V", "Coulomb friction of the cam's drive", "[assumed]"),
    "valve_force_v": _p(16.0, "V", "current limit of the cam's drive, as a voltage", "[assumed]"),
    "cam_encoder_rad": _p(math.radians(0.05), "rad", "resolution of the cam angle", "[assumed]"),
    "cam_stroke_rad": _p(math.radians(30.0), "rad", "cam angle of the full stroke", "[paper]"),
    "valve_slide_mm": _p(5.0, "mm", "travel of the suction valve (s)", "[paper]"),
    "valve_seal_mm": _p(0.3, "mm", "travel before the seal opens", "[assumed]"),
    "spring_preload_v": _p(0.7, "V", "return spring, closed, as a voltage", "[assumed]"),
    "spring_v_per_rad": _p(1.5, "V/rad", "its rate", "[assumed]"),
    "cam_stop_rad": _p(math.radians(0.5), "rad", "end stop behind the closed cam", "[assumed]"),
    # Suction line
    "pump_free_l_per_min": _p(18.0, "L/min", "free-air flow of the pump", "[paper]"),
    "pump_occluded_mmhg": _p(560.0, "mmHg", "occluded vacuum of the pump", "[paper]"),
    "regulator_ml_per_s_per_mmhg": _p(
        60.0, "mL/s/mmHg", "air let in by the regulator above its set point", "[assumed]"
    ),
    "relief_mmhg": _p(150.0, "mmHg", "mechanical relief valve", "[paper] use at most 150"),
    "relief_ml_per_s_per_mmhg": _p(60.0, "mL/s/mmHg", "air it lets in above", "[assumed]"),
    "canister_ml": _p(800.0, "mL", "canister and tubing", "[assumed]"),
    "bore_l_per_min": _p(
        17.7, "L/min", "free-air flow of 3.5 mm x 2 m at 100 mmHg", "[computed] Blasius"
    ),
    "leak_ml_per_s_per_mmhg": _p(0.02, "mL/s/mmHg", "leak of canister and valve", "[assumed]"),
    # Airway of the bench: a rubber trachea with artificial secretions
    "carina_mm": _p(100.0, "mm", "tube end to carina; the paper's travel is 90", "[assumed]"),
    "carina_n_per_mm": _p(0.5, "N/mm", "stiffness of the rubber carina", "[assumed]"),
    "catheter_n_per_mm": _p(
        0.9, "N/mm", "axial stiffness of the 2 m catheter", "[computed] 0.59 to 1.18"
    ),
    "buckling_n": _p(
        0.20, "N", "load at which the free tip buckles", "[computed] PVC 0.13 to 0.26", 0.03
    ),
    "post_buckling_ratio": _p(0.05, "1", "stiffness left after buckling", "[assumed]"),
    "switch_n": _p(0.08017, "N", "force that closes the contact switch", "[paper]", 0.001),
    "switch_open_ratio": _p(0.85, "1", "share of that force at which it opens", "[assumed]"),
    "switch_bounce_s": _p(0.003, "s", "chatter after closing", "[assumed] 1 to 10 ms"),
    "switch_bounce_open_ratio": _p(0.3, "1", "share of the chatter that is open", "[assumed]"),
    "switch_latency_s": _p(0.004, "s", "delay of the switch's line", "[assumed]"),
    "secretion_ml": _p(3.0, "mL", "secretions in the trachea", "[assumed] 0.5 to 5 a pass", 0.6),
    "secretion_above_carina_mm": _p(
        30.0, "mm", "distance from the carina around which they lie", "[assumed]", 5.0
    ),
    "secretion_spread_mm": _p(25.0, "mm", "half of the length over which they lie", "[assumed]"),
    "uptake_ml_per_s_per_mmhg": _p(
        0.0085,
        "mL/s/mmHg",
        "uptake of a 5 cm plug of 1 Pa s (1.2 mL/s at 120 mmHg, with losses)",
        "[computed]",
        0.001,
    ),
    "mucus_pa_s": _p(1.0, "Pa s", "viscosity of the mucus at 100 /s", "[assumed] as for uptake"),
    "mucus_yield_pa": _p(5.0, "Pa", "stress below which it does not flow", "[assumed] .5 to 50"),
    "reach_mm": _p(15.0, "mm", "distance from which mucus flows to the tip", "[assumed]"),
    "mucus_share": _p(0.6, "1", "share of the tip that flowing mucus takes", "[assumed]"),
    # Measurement
    "laser_noise_mm": _p(0.08, "mm", "laser, target and set-up, RMS", "[assumed] at most 0.1"),
}
"""The paper's bench."""

CLINICAL: dict[str, Parameter] = {
    **BENCH,
    # Insertion axis: a 1524T024SR, geared to 60 mm/s at its 9800 rpm, gear efficiency 0.65
    "no_load_mm_per_s": _p(
        60.0, "mm/s", "head speed at full supply without friction", "[assumed] gearing", 0.8
    ),
    "insertion_time_constant_s": _p(
        0.0128,
        "s",
        "mechanical time constant of the insertion axis",
        "[computed] motor's 8.3 ms / 0.65",
    ),
    "moving_mass_kg": _p(
        16.4,
        "kg",
        "inertia of the drive, referred to the head",
        "[computed] rotor's 0.56 g cm2 at 0.058 mm/rad",
    ),
    "insertion_friction_v": _p(
        0.4,
        "V",
        "Coulomb friction of motor, gear and guide, as a voltage",
        "[computed] 0.32 V for the motor's 4 mA; guide [assumed]",
        0.05,
    ),
    "drive_a_per_n": _p(
        0.00385,
        "A/N",
        "motor current for each newton at the head",
        "[computed] 60 mm/s / 24 V / 0.65 gear efficiency",
    ),
    # Valve axis: half the bench's gear ratio, so the same spring takes twice the voltage
    "cam_no_load_rad_per_s": _p(
        math.radians(180.0),
        "rad/s",
        "cam speed at full supply without friction",
        "[assumed] for 60 deg/s against the spring",
    ),
    "spring_preload_v": _p(
        1.4, "V", "return spring, closed, as a voltage", "[computed] bench's at twice the speed"
    ),
    "spring_v_per_rad": _p(3.0, "V/rad", "its rate", "[computed] bench's at twice the speed"),
}
"""The bedside machine: the bench with faster gears."""


def nominal(table: dict[str, Parameter]) -> dict[str, float]:
    """Every parameter at its value."""
    return {name: parameter.value for name, parameter in table.items()}


def drawn(table: dict[str, Parameter], seed: int) -> dict[str, float]:
    """One machine: every parameter drawn from its spread. seed: any integer below 2**32."""
    values: dict[str, float] = {}
    for name, parameter in table.items():
        # A block of random numbers named by the parameter: neither a new parameter nor a new
        # spread changes what the others draw.
        block = zlib.crc32(name.encode())
        source = random_stream.stream(seed, MACHINE_PURPOSE)._replace(counter=block)
        draw, _, _ = random_stream.normal_pair(source)
        cut = min(max(draw, -SPREAD_LIMIT), SPREAD_LIMIT)
        values[name] = parameter.value + parameter.spread * cut
    return values
