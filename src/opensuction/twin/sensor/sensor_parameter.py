"""Parameters of the machine's sensors: ordinary parts, drawn with the machine.

Noise is what is new in each reading, a thousand a second. The least and largest values are what a
file may set; the controller is held to bear up to the largest (docs/safety/tolerance.md).
"""

import math

from opensuction.twin.parameter_row import Parameter, parameter_row

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
