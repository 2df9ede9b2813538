"""Every parameter of the twin: value, spread between machines, unit, meaning and source.

`BENCH` is the paper's bench, `CLINICAL` what differs at the bedside; catheters and patients change
both. `docs/reference/parameters.md` shows this table. ``spread`` is the standard deviation over
machines; a seed draws one machine. A file may set a value from ``low`` to ``high``;
these are the project's own judgement of what is plausible. Tags of the sources: docs/sources.md.

Parameters of the machine's sensors: ordinary parts, drawn with the machine.

Noise is what is new in each reading, a thousand a second. The least and largest values are what a
file may set; the controller is held to bear up to the largest (docs/safety/tolerance.md).
"""

import math
import zlib

from opensuction.kernel import random_stream
from opensuction.twin.parameter_row import Parameter, parameter_row
from opensuction.twin.parameter_row import parameter_row as _p

SENSORS: dict[str, Parameter] = {
    "carriage_sensor_mm": parameter_row(
        0.1,
        "mm",
        (0.001, 0.2),
        "resolution of the sensor on the catheter head, behind gear and rack",
        "[assumed] a magnetic strip",
    ),
    "carriage_noise_mm": parameter_row(
        0.01, "mm", (0, 0.03), "its noise, RMS", "[assumed] jitter of a magnetic strip", 0.002
    ),
    "carriage_zero_mm": parameter_row(
        0.0, "mm", (-0.4, 0.4), "its zero against the motor's encoder", "[assumed] mounting", 0.1
    ),
    "cam_encoder_rad": parameter_row(
        math.radians(0.05), "rad", (0.00001, 0.01), "resolution of the cam angle", "[assumed]"
    ),
    "cam_noise_rad": parameter_row(
        math.radians(0.02),
        "rad",
        (0, math.radians(0.1)),
        "noise of the cam angle, RMS",
        "[assumed] a magnetic angle sensor of 12 to 14 bit",
    ),
    "cam_zero_rad": parameter_row(
        0.0,
        "rad",
        (-0.01, 0.01),
        "zero of the cam angle",
        "[assumed] 0.1 degrees of mounting and linearity",
        math.radians(0.1),
    ),
    "vacuum_noise_mmhg": parameter_row(
        1.0, "mmHg", (0, 3), "noise of the vacuum sensor, RMS", "[assumed] 0.2 % of 500 mmHg", 0.2
    ),
    "vacuum_offset_mmhg": parameter_row(
        0.0, "mmHg", (-5, 5), "its offset", "[assumed] 1 % of 500 mmHg at most", 2.0
    ),
    "vacuum_drift_mmhg": parameter_row(
        0.3, "mmHg", (0, 2), "how far that wanders within minutes, RMS", "[assumed] temperature"
    ),
    "vacuum_gain": parameter_row(
        1.0, "1", (0.98, 1.02), "its reading for each mmHg", "[assumed]", 0.005
    ),
    "vacuum_step_mmhg": parameter_row(
        0.125, "mmHg", (0, 2), "its resolution", "[computed] 12 bit of 500 mmHg"
    ),
    "vacuum_lag_s": parameter_row(
        0.002, "s", (0, 0.01), "time constant of its bandwidth", "[assumed]"
    ),
    "current_noise_a": parameter_row(
        0.0003,
        "A",
        (0, 0.003),
        "noise of the insertion motor's current, RMS",
        "[assumed] 0.2 % of a range of 150 mA",
        0.00005,
    ),
    "current_offset_a": parameter_row(
        0.0, "A", (-0.002, 0.002), "its offset", "[assumed] 0.5 % of that range", 0.0005
    ),
    "current_drift_a": parameter_row(
        0.0001, "A", (0, 0.001), "how far that wanders within minutes, RMS", "[assumed]"
    ),
    "current_gain": parameter_row(
        1.0, "1", (0.9, 1.1), "its reading for each ampere", "[assumed] shunt and amplifier", 0.01
    ),
    "current_step_a": parameter_row(
        0.00004, "A", (0, 0.0005), "its resolution", "[computed] 12 bit of that range"
    ),
    "current_lag_s": parameter_row(
        0.0005, "s", (0, 0.005), "time constant of its bandwidth", "[assumed]"
    ),
    "late_share": parameter_row(
        0.01, "1", (0, 0.1), "share of messages that come a tick late", "[assumed] jitter of a bus"
    ),
}
"""Of either machine."""


MACHINE_PURPOSE = 1
"""Stream of random numbers that draws machines."""
SPREAD_LIMIT = 2.5
"""Draws are cut off at this many standard deviations."""
FAR_LIMIT = 3.0
"""The same of draws that are spread wider than usual."""

ParameterValues = dict[str, float]
"""A value for each parameter by name: those of one machine or patient."""

BENCH: dict[str, Parameter] = {
    # Insertion axis
    "supply_v": _p(24.0, "V", (12, 48), "supply of both motors", "[datasheet]"),
    "no_load_mm_per_s": _p(
        18.8,
        "mm/s",
        (5, 150),
        "head speed at full supply without friction",
        "[calibrated] Table I",
        0.3,
    ),
    "insertion_time_constant_s": _p(
        0.020,
        "s",
        (0.002, 0.2),
        "mechanical time constant of the insertion axis, with 16.4 kg to move",
        "[assumed]",
        0.001,
    ),
    "moving_mass_kg": _p(
        16.4,
        "kg",
        (0.5, 100),
        "inertia of the drive, referred to the head",
        "[assumed] 0.3 m/s2 at 5 N",
        1.0,
    ),
    "insertion_friction_v": _p(
        0.5,
        "V",
        (0.05, 3),
        "Coulomb friction of motor, gear and guide, as a voltage",
        "[assumed] at most 1",
        0.05,
    ),
    "drive_force_n": _p(
        5.0, "N", (1, 20), "drive current limit, as force at the head", "[assumed]", 0.15
    ),
    "drive_a_per_n": _p(
        0.0012,
        "A/N",
        (0.0001, 0.1),
        "motor current for each newton at the head",
        "[computed] 18.8 mm/s / 24 V / 0.65 gear efficiency",
        0.00003,
    ),
    "head_encoder_mm": _p(
        0.005, "mm", (0.0001, 0.1), "resolution of the head position", "[assumed]"
    ),
    "gear_backlash_mm": _p(
        0.10, "mm", (0, 0.5), "play of gearhead and rack", "[assumed] 0.05 to 0.2", 0.02
    ),
    # Catheter in its conduit
    "bend_rad": _p(
        9.6, "rad", (1, 25), "total bend of the conduit", "[calibrated] paper's loop width", 0.5
    ),
    "clearance_mm": _p(
        2.0, "mm", (0.2, 4), "conduit bore less catheter diameter", "[paper] 6.0 - 4.0"
    ),
    "width_spread_mm": _p(
        2.0, "mm", (0, 3), "standard deviation of the clearances along the bends", "[calibrated]"
    ),
    "stretch_mm": _p(
        0.2,
        "mm",
        (0, 2),
        "friction-limited elastic stretch, both ways",
        "[computed] 0.1 N / 1 N per mm",
        0.02,
    ),
    "gain": _p(
        0.949, "mm/mm", (0.8, 1.05), "tip travel for each mm of head travel", "[calibrated]", 0.003
    ),
    "gain_per_100mm": _p(
        0.01, "1", (-0.03, 0.03), "change of that gain over 100 mm of depth", "[assumed]", 0.003
    ),
    "offset_mm": _p(
        -6.0, "mm", (-15, 5), "tip position at head 0 without clearance", "[calibrated]", 0.25
    ),
    "creep_fast_mm": _p(
        0.15, "mm", (0, 0.3), "fast part of the polymer's creep", "[assumed] at most 0.3", 0.02
    ),
    "creep_fast_s": _p(0.5, "s", (0.3, 10), "its time constant", "[assumed] 0.3 to 10"),
    "creep_slow_mm": _p(0.10, "mm", (0, 0.3), "slow part of the polymer's creep", "[assumed]"),
    "creep_slow_s": _p(5.0, "s", (0.3, 10), "its time constant", "[assumed]"),
    # Valve axis
    "cam_no_load_rad_per_s": _p(
        math.radians(90.0),
        "rad/s",
        (0.2, 10),
        "cam speed at full supply without friction",
        "[assumed]",
        math.radians(2.0),
    ),
    "valve_time_constant_s": _p(
        0.020, "s", (0.002, 0.2), "mechanical time constant of the cam", "[assumed]", 0.001
    ),
    "valve_friction_v": _p(
        0.5, "V", (0.05, 3), "Coulomb friction of the cam's drive", "[assumed]", 0.05
    ),
    "valve_force_v": _p(
        16.0, "V", (2, 48), "current limit of the cam's drive, as a voltage", "[assumed]"
    ),
    "cam_stroke_rad": _p(
        math.radians(30.0), "rad", (0.1, 1.6), "cam angle of the full stroke", "[paper]"
    ),
    "valve_slide_mm": _p(5.0, "mm", (1, 15), "travel of the suction valve (s)", "[paper]"),
    "valve_seal_mm": _p(0.3, "mm", (0, 2), "travel before the seal opens", "[assumed]"),
    "spring_preload_v": _p(
        0.7, "V", (0, 5), "return spring, closed, as a voltage", "[assumed]", 0.05
    ),
    "spring_v_per_rad": _p(1.5, "V/rad", (0, 10), "its rate", "[assumed]", 0.1),
    "cam_stop_rad": _p(
        math.radians(0.5), "rad", (0, 0.1), "end stop behind the closed cam", "[assumed]"
    ),
    # Suction line
    "pump_free_l_per_min": _p(18.0, "L/min", (2, 60), "free-air flow of the pump", "[paper]", 0.7),
    "pump_occluded_mmhg": _p(
        560.0, "mmHg", (50, 720), "occluded vacuum of the pump", "[paper]", 10.0
    ),
    "regulator_ml_per_s_per_mmhg": _p(
        60.0,
        "mL/s/mmHg",
        (1, 500),
        "air let in by the regulator above its set point",
        "[assumed]",
        5.0,
    ),
    "relief_mmhg": _p(
        150.0, "mmHg", (50, 200), "mechanical relief valve", "[paper] use at most 150", 2.0
    ),
    "relief_ml_per_s_per_mmhg": _p(
        60.0, "mL/s/mmHg", (1, 500), "air it lets in above", "[assumed]"
    ),
    "canister_ml": _p(800.0, "mL", (50, 4000), "canister and tubing", "[assumed]", 15.0),
    "bore_l_per_min": _p(
        17.7,
        "L/min",
        (0.5, 40),
        "free-air flow of 3.5 mm x 2 m at 100 mmHg",
        "[computed] Blasius",
        0.4,
    ),
    "leak_ml_per_s_per_mmhg": _p(
        0.02, "mL/s/mmHg", (0, 5), "leak of canister and valve", "[assumed]", 0.004
    ),
    # Airway of the bench: a rubber trachea with artificial secretions
    "carina_mm": _p(
        100.0, "mm", (5, 130), "tube end to carina; the paper's travel is 90", "[assumed]"
    ),
    "carina_n_per_mm": _p(0.5, "N/mm", (0.05, 5), "stiffness of the rubber carina", "[assumed]"),
    "catheter_n_per_mm": _p(
        0.9, "N/mm", (0.05, 5), "axial stiffness of the 2 m catheter", "[computed] 0.59 to 1.18"
    ),
    "buckling_n": _p(
        0.20,
        "N",
        (0.01, 2),
        "load at which the free tip buckles",
        "[computed] PVC 0.13 to 0.26",
        0.03,
    ),
    "post_buckling_ratio": _p(
        0.05,
        "1",
        (0, 0.15),
        "stiffness left after buckling",
        "[assumed]; most [computed]: P (1 + d / 2 L) by Euler's elastica, .35 N, 10 mm free",
    ),
    "switch_n": _p(
        0.08017, "N", (0.02, 0.3), "force that closes the contact switch", "[paper]", 0.001
    ),
    "switch_open_ratio": _p(
        0.85, "1", (0.3, 1), "share of that force at which it opens", "[assumed]"
    ),
    "switch_bounce_s": _p(
        0.003, "s", (0, 0.02), "chatter after closing", "[assumed] 1 to 10 ms", 0.0005
    ),
    "switch_bounce_open_ratio": _p(
        0.3, "1", (0, 1), "share of the chatter that is open", "[assumed]"
    ),
    "switch_latency_s": _p(
        0.004, "s", (0, 0.05), "delay of the switch's line", "[assumed]", 0.0007
    ),
    "secretion_ml": _p(
        3.0, "mL", (0, 30), "secretions in the trachea", "[assumed] 0.5 to 5 a pass", 0.6
    ),
    "secretion_above_carina_mm": _p(
        30.0, "mm", (0, 100), "distance from the carina around which they lie", "[assumed]", 5.0
    ),
    "secretion_spread_mm": _p(
        25.0, "mm", (5, 100), "half of the length over which they lie", "[assumed]"
    ),
    "uptake_ml_per_s_per_mmhg": _p(
        0.0085,
        "mL/s/mmHg",
        (0.0001, 0.1),
        "uptake of a 5 cm plug of 1 Pa s (1.2 mL/s at 120 mmHg, with losses)",
        "[computed]",
        0.001,
    ),
    "mucus_pa_s": _p(
        1.0, "Pa s", (0.02, 10), "viscosity of the mucus at 100 /s", "[assumed] as for uptake"
    ),
    "mucus_yield_pa": _p(
        5.0, "Pa", (0, 200), "stress below which it does not flow", "[assumed] .5 to 50"
    ),
    "reach_mm": _p(15.0, "mm", (1, 50), "distance from which mucus flows to the tip", "[assumed]"),
    "mucus_share": _p(0.6, "1", (0, 1), "share of the tip that flowing mucus takes", "[assumed]"),
    **SENSORS,
    # Measurement
    "laser_noise_mm": _p(
        0.08, "mm", (0, 1), "laser, target and set-up, RMS", "[assumed] at most 0.1"
    ),
}
"""The paper's bench."""

_GEARED: dict[str, tuple[float, float, str]] = {
    # Insertion axis: a 1524T024SR, geared to 60 mm/s at its 9800 rpm, gear efficiency 0.65
    "no_load_mm_per_s": (60.0, 0.8, "[assumed] gearing"),
    "insertion_time_constant_s": (0.0128, 0.0006, "[computed] motor's 8.3 ms / 0.65"),
    "moving_mass_kg": (16.4, 1.0, "[computed] rotor's 0.56 g cm2 at 0.058 mm/rad"),
    "insertion_friction_v": (0.4, 0.05, "[computed] 0.32 V for the motor's 4 mA; guide [assumed]"),
    "drive_a_per_n": (0.00385, 0.0001, "[computed] 60 mm/s / 24 V / 0.65 gear efficiency"),
    # Valve axis: half the bench's gear ratio, so the same spring takes twice the voltage
    "cam_no_load_rad_per_s": (
        math.radians(180.0),
        math.radians(4.0),
        "[assumed] for 60 deg/s against the spring",
    ),
    "spring_preload_v": (1.4, 0.1, "[computed] bench's at twice the speed"),
    "spring_v_per_rad": (3.0, 0.2, "[computed] bench's at twice the speed"),
}
"""Value, spread and source of what the bedside's faster gears change."""

CLINICAL: dict[str, Parameter] = BENCH | {
    name: BENCH[name]._replace(value=value, spread=spread, source=source)
    for name, (value, spread, source) in _GEARED.items()
}
"""The bedside machine: the bench with faster gears."""


def nominal(table: dict[str, Parameter]) -> ParameterValues:
    """Every parameter at its value."""
    return {name: parameter.value for name, parameter in table.items()}


def draw(table: dict[str, Parameter], seed: int, spread: float = 1.0) -> ParameterValues:
    """One machine: every parameter drawn from its spread.

    seed: any integer below 2**32. spread: every deviation is so many times as large, up to
    `FAR_LIMIT` and to what a file may set; 0 to 3.
    """
    reach = SPREAD_LIMIT if spread <= 1.0 else FAR_LIMIT
    values: ParameterValues = {}
    for name, parameter in table.items():
        # A block of random numbers named by the parameter: neither a new parameter nor a new
        # spread changes what the others draw.
        block = zlib.crc32(name.encode())
        source = random_stream.stream(seed, MACHINE_PURPOSE)._replace(counter=block)
        draw, _, _ = random_stream.normal_pair(source)
        cut = min(max(spread * draw, -reach), reach)
        values[name] = parameter.value + parameter.spread * cut
        if spread > 1.0:
            values[name] = min(max(values[name], parameter.low), parameter.high)
    return values
