"""Data sets of the leaderboard by name.

A data set that equations describe has `DataSet.generate` in the place of a file and its checksum.
Errors of others on the simulated damper: [SysIdentPy].
"""

from opensuction.evidence import oscillator_benchmark as benchmark
from opensuction.evidence.leaderboard.data_set import Columns, DataSet, Published, Split, halves

MRD = {
    "00": (
        ".1 Hz",
        1998,
        "bc8efb13dda85eb5fa1a1ef9bcbc1204785382b10d1ce99b8fbac5fef08a2475",
    ),
    "25": (
        ".3 Hz",
        2000,
        "525169928e505c4a3cf1459c03a2e2441496e00e9c676d52f1011607f8980e64",
    ),
    "45": (
        ".5 Hz",
        2000,
        "114da9fb67444b4d70dc0ab0e833e9168772deb6c9934c88df387c9360e553b7",
    ),
}
"""Runs of the grasper: frequency of the motion, samples, checksum."""
SETTLED = 50
"""Samples at 100 Hz before the load of the grasper is on: .5 s."""


def _grasper(run: str) -> DataSet:
    motion, samples, sha256 = MRD[run]
    return DataSet(
        name=f"grasper-{run}",
        title=f"cable-driven grasper, sine of {motion}: spindle to jaw",
        inputs=("spindle_deg",),
        output="jaw_deg",
        units=("deg", "deg"),
        negate_output=True,
        split=halves(SETTLED, samples),
        sampling="100 Hz, reduced to it for this project",
        period_s=0.01,
        licence="ODbL 1.0, contents DbCL 1.0",
        source="github.com/MRDLab/mis-tool-characterization, Tool_4_Maryland L_4 " + run,
        file=f"tool4_L4_{run}.csv",
        sha256=sha256,
    )


DAMPER = DataSet(
    name="mr-damper",
    title="magnetorheological damper on a test machine, 1.5 Hz: displacement to force",
    inputs=("dist",),
    output="forc",
    split=halves(0, 3001),
    sampling="100 Hz",
    period_s=0.01,
    licence="MIT",
    source="github.com/labcontrol-data/mr-damper",
    file="mr_ensaio1.mat",
    sha256="9e0332f208361276000643c920ba624f6530c43fabfadd411a4f3b649518dc96",
)
FRICTION = DataSet(
    name="friction-damper",
    title="rotary friction damper with backlash, .5 Hz, 20 lb: displacement to friction force",
    inputs=("displacement",),
    output="friction_force",
    negate_output=True,
    split=halves(0, 4609),
    sampling="256 Hz, every fourth of 18,433 samples",
    period_s=1.0 / 256.0,
    licence="CC BY-SA 4.0",
    source="github.com/ARTS-Laboratory/Dataset-Friction-Damper-with-Backlash",
    file="friction_damper.csv",
    sha256="85d0f5a6e019afe0390787061b47b382ad0445b451fee0602cde7520de514ff0",
)
COLUMN = DataSet(
    name="column",
    title="column under cyclic load of growing amplitude: displacement to force",
    inputs=("Lead Actuator Displacment",),
    output="Lead Actuator Force",
    units=("mm", "kN"),
    split=halves(0, 33028)._replace(
        words="first half fitted, second held out, which goes 3.2 times as far"
    ),
    sampling="not known",
    licence="Apache-2.0",
    source="github.com/cslotboom/hysteresis",
    file="column_spc1.csv",
    sha256="ec1fa2a523af4df01599b95e87dab444086f4ef72694016ececd46464d6df1e1",
)
WALL = DataSet(
    name="wall",
    title="wall in shear, of growing amplitude: displacement to force",
    inputs=("1",),
    output="2",
    split=halves(8200, 9281)._replace(
        words="the first 8,200, in which it rests, left out; of the others the first half fitted, "
        "the second held out, which goes 2.5 times as far"
    ),
    sampling="not known",
    licence="Apache-2.0",
    source="github.com/cslotboom/hysteresis",
    file="wall_ts1.csv",
    sha256="40e3936cb941e880e6c5b9aeb30bed1a6d4c939eae6d7b18de7622e52b91da67",
)
SERVO = DataSet(
    name="servo",
    title="servo under load: commanded to measured position, in steps of its encoder",
    inputs=("target pos (5)",),
    output="pos (5)",
    split=halves(0, 273),
    sampling="uneven, some 10 Hz",
    licence="CC BY 4.0",
    source="github.com/roboninecom/Measuring-Backlash-in-Popular-UART-Servos",
    file="servo_single.csv",
    sha256="067ad48c2d18a2e60fe8b1900598ecf52aa40e151780264ab7aee16de6270c2f",
)
OTHER_SERVO = SERVO._replace(
    name="servo-pair",
    title="servo under load, one of four: commanded to measured position, in encoder steps",
    inputs=("target pos (1)",),
    output="pos (1)",
    split=halves(0, 401),
    skip_missing=True,
    file="servo_comp2.csv",
    sha256="eca1e69d17376979462e6a208fa649cc4906a82d6efd7d63456cf82166d2eb21",
)
SIMULATED_DAMPER = DataSet(
    name="simulated-mr-damper",
    title="simulated magnetorheological damper: velocity and voltage to force",
    inputs=("v", "E"),
    output="f",
    units=("cm/s", "V", "N"),
    split=Split(
        400,
        2000,
        2002,
        3600,
        "as published: samples 400 to 1,999 fitted, 2,002 to 3,599 held out (2,001 began the "
        "published simulation)",
    ),
    sampling="500 Hz",
    period_s=0.002,
    licence="MIT",
    source="github.com/wilsonrljr/sysidentpy-data, boucwen_histeretic_system.csv",
    simulated=True,
    file="boucwen.csv",
    sha256="c63b8d94eeb73ee8e9d1ac249ba5a8d341b0330895ea51c42cc9d521d73f3200",
    published=(
        Published("SysIdentPy, FROLS, with sign(v) as a third input", 0.045104, "SysIdentPy"),
        Published("SysIdentPy, MetaMSS, with sign(v) as a third input", 0.055707, "SysIdentPy"),
        Published("SysIdentPy, FROLS, scaled to 0 to 1, v and E alone", 0.163944, "SysIdentPy"),
        Published("SysIdentPy, MetaMSS, scaled to 0 to 1, v and E alone", 0.185607, "SysIdentPy"),
    ),
)

FITTED_SEED, TEST_SEED = 1, 1001
"""Multisines of the generated benchmark."""


def _simulate_oscillator() -> Columns:
    return benchmark.joined_record(FITTED_SEED, TEST_SEED)._asdict()


OSCILLATOR = DataSet(
    name="bouc-wen-benchmark",
    title="mass with a Bouc-Wen force under a multisine of 5 to 150 Hz: force to displacement",
    inputs=("force_n",),
    output="displacement_m",
    units=("N", "m"),
    split=Split(
        0,
        benchmark.PERIODS * benchmark.PERIOD,
        (2 * benchmark.PERIODS - 1) * benchmark.PERIOD,
        2 * benchmark.PERIODS * benchmark.PERIOD,
        "five periods with noise of 8e-6 m fitted; of five of another multisine that follow, "
        "without noise, the last held out",
    ),
    sampling="750 Hz",
    period_s=1.0 / benchmark.RATE_HZ,
    licence="Apache-2.0",
    source="the equations of [BW-2016], with signals of our own",
    simulated=True,
    generate=_simulate_oscillator,
)

DATA_SETS = {
    one.name: one
    for one in (
        *map(_grasper, MRD),
        DAMPER,
        FRICTION,
        COLUMN,
        WALL,
        SERVO,
        OTHER_SERVO,
        SIMULATED_DAMPER,
        OSCILLATOR,
    )
}
"""By name, in the order of the table."""
