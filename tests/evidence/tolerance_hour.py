"""An hour of noise alone on the governor's own functions: how often each of them trips.

The machine's parts are the worst that are drawn, all at once where they help one another; so are
its sensors, or one of them has the noise that a file may set at most.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from opensuction.controller import governor_limit
from opensuction.controller.machine_profile import BENCH as BENCH_PROFILE
from opensuction.controller.machine_profile import CLINICAL as PROFILE
from opensuction.controller.machine_profile import MachineProfile
from opensuction.kernel import random_stream
from opensuction.kernel.unit import ATMOSPHERE_MMHG, ML_PER_S
from opensuction.procedure.cycle.check import CheckItem
from opensuction.procedure.planning import protocol
from opensuction.safety.limits import DriveLimits, ValveLimits
from opensuction.twin import parameter, preset
from opensuction.twin.parameter_row import Parameter
from opensuction.twin.sensor import sensor
from opensuction.twin.sensor.sensor import Sensors, SensorState
from tests.evidence.tolerance_loop import (
    CALM,
    Head,
    Line,
    Pull,
    count_cam,
    count_head,
    count_line,
    count_pull,
    count_refusals,
)

HOUR = 3_600_000
"""Ticks."""
SEED = 1123
TIP_N = 0.3
"""Highest force at the tip [computed]."""
Row = dict[str, Any]
Table = dict[str, Parameter]


def _values(errors: dict[str, float]) -> parameter.ParameterValues:
    return parameter.nominal(parameter.CLINICAL) | errors


def sensors_of(errors: dict[str, float]) -> Sensors:
    """Sensors with these parameters, the others nominal."""
    return sensor.sensors(_values(errors))


def _most(name: str, way: int = 1, table: Table = parameter.CLINICAL) -> float:
    row = table[name]
    return row.value + way * parameter.SPREAD_LIMIT * row.spread


def _worst_errors() -> dict[str, float]:
    """The worst sensors that are drawn, all errors the same way."""
    names = (
        *("vacuum_noise_mmhg", "vacuum_offset_mmhg", "carriage_noise_mm", "carriage_zero_mm"),
        *("cam_noise_rad", "cam_zero_rad", "current_noise_a", "current_offset_a", "current_gain"),
    )
    return {name: _most(name) for name in names} | {"vacuum_gain": _most("vacuum_gain", -1)}


def _drive_limits(profile: MachineProfile) -> DriveLimits:
    return DriveLimits(
        newton_per_a=profile.newton_per_a,
        moving_mass_kg=profile.moving_mass_kg,
        jam_n=profile.jam_n,
        force_n=governor_limit.FORCE_MARGIN * profile.drive_force_n,
        supply_v=profile.supply_v,
        mm_per_s_per_v=profile.no_load_mm_per_s / profile.supply_v,
        volts_per_a=profile.winding_v_per_a,
        gaining_least_mm_per_s2=100.0,
        gaining_most_mm_per_s2=1000.0,
    )


def _pull(table: Table, tip_n: float | None) -> Pull:
    """Against friction and what the tip bears; None: at the drive's own limit."""
    per_n = preset.load_v_per_n(parameter.nominal(table))
    rest_v = _most("insertion_friction_v", 1, table)
    rest_n = rest_v / per_n
    force_n = _most("drive_force_n", 1, table) if tip_n is None else rest_n + tip_n
    speed = 10.0
    back_v = speed / _most("no_load_mm_per_s", -1, table) * table["supply_v"].value
    per_a = _most("drive_a_per_n", 1, table)
    return Pull(force_n, speed, per_a, back_v + per_n * force_n, rest_n, rest_v, 0.005)


Count = Callable[[Sensors, SensorState, int], int]


def hours() -> dict[str, tuple[str, Count]]:
    """What is counted by name, with the sensor parameter whose noise it is."""
    neonate = governor_limit.line_limits(PROFILE, 2.0, 80.0)
    drive, play = _drive_limits(PROFILE), _most("gear_backlash_mm")
    valve = ValveLimits(PROFILE.cam_open_rad, PROFILE.cam_open_rad / PROFILE.cam_rad_per_s)
    leak = _most("leak_ml_per_s_per_mmhg") * ATMOSPHERE_MMHG / _most("canister_ml", -1)
    stop = -_most("cam_stop_rad")

    def line(one: Line) -> Count:
        return lambda sensors, start, ticks: count_line(neonate, sensors, one, start, ticks)

    def head(one: Head) -> Count:
        return lambda sensors, start, ticks: count_head(drive, sensors, one, start, ticks)

    def cam(sensors: Sensors, start: SensorState, ticks: int) -> int:
        less = sensors._replace(cam=sensors.cam._replace(offset=-sensors.cam.offset))
        places = ((less, stop), (sensors, 0.0), (less, 0.97 * valve.open_rad))
        return sum(count_cam(valve, way, place, start, ticks) for way, place in places)

    def pull(profile: MachineProfile, table: Table, tip_n: float | None) -> Count:
        one, limits, which = _pull(table, tip_n), _drive_limits(profile), int(tip_n is None)
        return lambda sensors, start, ticks: count_pull(limits, sensors, one, start, ticks)[which]

    noise, current = "vacuum_noise_mmhg", "current_noise_a"
    return {
        "closed": (noise, line(Line(80.0, 80.0, True, 0.0))),
        "resting": (noise, line(Line(80.0, 80.0, False, leak))),
        "vented": (noise, line(Line(0.0, 0.0, False, 0.0))),
        "cam": ("cam_noise_rad", cam),
        "head": ("carriage_noise_mm", head(Head(10.0, 30.0, 20.0, play, 0.005, False))),
        "head, sucking": ("carriage_noise_mm", head(Head(10.0, 30.0, 20.0, play, 0.005, True))),
        "jam, bedside": (current, pull(PROFILE, parameter.CLINICAL, TIP_N)),
        "force, bedside": (current, pull(PROFILE, parameter.CLINICAL, None)),
        "jam, bench": (current, pull(BENCH_PROFILE, parameter.BENCH, TIP_N)),
        "force, bench": (current, pull(BENCH_PROFILE, parameter.BENCH, None)),
    }


def _begin(sensors: Sensors, number: int) -> SensorState:
    return sensor.begin(sensors, CALM, random_stream.stream(SEED, 73 + number))


def measure(ticks: int = HOUR) -> Row:
    """Every hour, with the worst sensors that are drawn, and the largest noise of a file."""
    found: Row = {}
    for number, (name, (noisy, count)) in enumerate(hours().items()):
        largest = {noisy: parameter.CLINICAL[noisy].high}
        found[name] = {"error": noisy}
        for word, errors in (("worst", {}), ("largest", largest)):
            sensors = sensors_of(_worst_errors() | errors)
            found[name][word] = int(count(sensors, _begin(sensors, number), ticks))
    return found


def measure_refusals(tests: int = 2000) -> Row:
    """Pre-use tests of a sound line at the end of what is drawn, that are failed by noise."""
    leak = _most("leak_ml_per_s_per_mmhg") * ATMOSPHERE_MMHG / _most("canister_ml", -1)
    pumped = _most("pump_free_l_per_min") * ML_PER_S
    relieved = _most("relief_mmhg")
    relieved += (
        pumped * (1.0 - relieved / _most("pump_occluded_mmhg")) / _most("relief_ml_per_s_per_mmhg")
    )
    items = {
        "leak": (80.0, CheckItem.VACUUM_HOLDS, Line(80.0, 80.0, False, leak)),
        "relief": (120.0, CheckItem.RELIEF_OPENS, Line(relieved, 175.0, True, 0.0)),
    }
    found: Row = {}
    for number, (name, (set_mmhg, item, line)) in enumerate(items.items()):
        plan = protocol.plan_check(set_mmhg, PROFILE.relief_mmhg, 2.0, 0.5)
        found[name] = {"tests": tests}
        for word, noise in (("worst", _most("vacuum_noise_mmhg")), ("largest", 3.0)):
            errors = _worst_errors() | {"vacuum_noise_mmhg": noise, "vacuum_gain": 1.0125}
            sensors = sensors_of(errors)
            start = _begin(sensors, number)
            found[name][word] = int(count_refusals(plan, sensors, int(item), line, start, tests))
    return found


def count_leaks(leak_per_s: float, tests: int) -> int:
    """How many pre-use tests of a neonate's line that loses this share a second fail."""
    plan = protocol.plan_check(80.0, PROFILE.relief_mmhg, 2.0, 0.5)
    sensors = sensors_of({})
    line, item = Line(80.0, 80.0, False, leak_per_s), int(CheckItem.VACUUM_HOLDS)
    return int(count_refusals(plan, sensors, item, line, _begin(sensors, 0), tests))


def measure_share(machines: int = 1_000_000) -> Row:
    """Of so many drawn bedside drives, how many read more at their own limit than a fault's."""
    draws = np.random.default_rng(SEED)

    def draw(name: str) -> npt.NDArray[np.float64]:
        row, limit = parameter.CLINICAL[name], parameter.SPREAD_LIMIT
        cut = np.clip(draws.standard_normal(machines), -limit, limit)
        return np.asarray(row.value + row.spread * cut)

    told = PROFILE.newton_per_a * draw("drive_a_per_n") * draw("current_gain")
    rest_n = draw("insertion_friction_v") / preset.load_v_per_n(_values({}))
    read = draw("drive_force_n") * told + rest_n * (told - 1.0)
    limit_n = governor_limit.FORCE_MARGIN * PROFILE.drive_force_n
    return {
        "machines": machines,
        "beyond": int(np.sum(read > limit_n)),
        "most_n": float(read.max()),
    }
