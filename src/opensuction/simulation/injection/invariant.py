"""Invariants of every tick of a run under any fault, checked on the trace afterwards.

The *command side* is what the controller sends, judged by what it has read: no fault excuses a
breach. The effects on the patient are judged elsewhere: see `run_judgement`.

Predicates of safe states on a trace, by name.

Each is true or false in every tick. They are judged on the truth of the twin and on the commands
that the drives obeyed, not on what the controller has read.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.controller.record import Settings
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.oracle.exposure import trace_advance_mm
from opensuction.safety import condition_mask
from opensuction.safety.governor.limiter import ADVANCE_MM
from opensuction.safety.watch import valve_axis, watch
from opensuction.simulation.closed_loop import COLUMNS, DT_S
from opensuction.simulation.injection.injection import SIGNS
from opensuction.simulation.trace import Columns

Holds = npt.NDArray[np.bool_]
"""Whether something holds, one entry a tick."""

STANDING_MM_PER_S = 0.5
"""Head slower than this stands still."""
STANDING_S = 0.05
"""Time over which its speed is taken."""


class SafeBounds(NamedTuple):
    """Limits of the predicates; none has a default."""

    boundary_mm: float
    """Tip here or above is outside the patient."""
    vented_mmhg: float
    """Vacuum up to this is none."""
    vacuum_mmhg: float
    """Highest vacuum allowed."""
    contact_n: float
    """Force up to this is no contact."""


def _is_standing(columns: Columns, _bounds: SafeBounds) -> Holds:
    """The catheter head stands still."""
    ticks = round(STANDING_S / DT_S)
    head = columns["truth.head_mm"]
    before = np.concatenate((np.full(min(ticks, head.size), head[0]), head[:-ticks]))
    return np.asarray(np.abs(head - before) <= STANDING_MM_PER_S * STANDING_S)


def _is_not_inserted(columns: Columns, bounds: SafeBounds) -> Holds:
    """At every tick whether the tip has never been in the patient."""
    inside = columns["truth.tip_mm"] > bounds.boundary_mm
    return ~np.logical_or.accumulate(inside)


PREDICATES: dict[str, Callable[[Columns, SafeBounds], Holds]] = {
    "tip-outside": lambda columns, bounds: columns["truth.tip_mm"] <= bounds.boundary_mm,
    "valve-closed": lambda columns, _: columns["truth.valve_open_ratio"] == 0.0,
    "no-suction": lambda columns, bounds: columns["truth.tip_vacuum_mmhg"] <= bounds.vented_mmhg,
    "vented": lambda columns, bounds: columns["truth.line_vacuum_mmhg"] <= bounds.vented_mmhg,
    "vacuum-limited": lambda columns, bounds: (
        columns["truth.line_vacuum_mmhg"] <= bounds.vacuum_mmhg
    ),
    "torque-off": lambda columns, _: columns["commands.insertion_on"] == 0.0,
    "pump-off": lambda columns, _: columns["commands.pump_on"] == 0.0,
    "standing": _is_standing,
    "untouched": lambda columns, bounds: columns["truth.contact_n"] <= bounds.contact_n,
    "resting": lambda columns, _: np.isin(columns["phase"], RESTING),
    "not-inserted": _is_not_inserted,
}
"""Predicates by name."""


def holds(columns: Columns, names: Sequence[str], bounds: SafeBounds) -> Holds:
    """True where all of the named predicates hold, one entry a tick.

    Raises InputError for a name that is not known.
    """
    result = np.ones(columns["time_s"].size, dtype=np.bool_)
    for name in names:
        if name not in PREDICATES:
            raise InputError(f"unknown safe state '{name}': one of {', '.join(PREDICATES)}")
        result &= PREDICATES[name](columns, bounds)
    return result


def safe_s(columns: Columns, safe: Holds, from_s: float) -> float:
    """The instant from which a state holds to the end of the trace, at or after ``from_s``.

    nan where it does not hold at the end.
    """
    first = round(from_s / DT_S)
    if not safe[-1]:
        return float("nan")
    broken = np.flatnonzero(~safe[first:])
    tick = first if not broken.size else first + int(broken[-1]) + 1
    return float(columns["time_s"][tick])


Ticks = npt.NDArray[np.bool_]
Samples = npt.NDArray[np.float64]

SUCTION_PHASES = (Phase.OPENING, Phase.SUCTIONING, Phase.WITHDRAWING, Phase.ABORTING)
"""Phases in which the valve may be commanded open; in CHECKING with the line vented."""
ROUNDING = 1e-9
"""Positions of about 100 mm are rounded to 1e-14; a tick divides that by 1e-3."""


class Breach(NamedTuple):
    """One invariant that was broken: where first, and by how much at worst."""

    invariant: str
    time_s: float
    worst: float
    bound: float


Check = Callable[[Columns, Settings], Breach | None]

_READ = ("readings.cam_rad", "readings.cam_valid", "readings.head_mm", "readings.head_valid")
JUDGED = tuple(name for name in COLUMNS if name.startswith("commands.") or name in (*SIGNS, *_READ))
"""Columns that are looked at here: a campaign copies no others."""


def _breach(
    name: str, columns: Columns, broken: Ticks, values: Samples, bound: float
) -> Breach | None:
    """The breach in the ticks in which it is one; None where there are none."""
    if not broken.any():
        return None
    first = float(columns["time_s"][np.argmax(broken)])
    found = values[broken]
    worst = float(found[np.argmax(np.abs(found - bound))]) if np.isfinite(found).all() else np.nan
    return Breach(name, first, worst, bound)


def _above(name: str, columns: Columns, values: Samples, bound: float) -> Breach | None:
    return _breach(name, columns, values > bound, values, bound)


def _finite_commands(columns: Columns, _: Settings) -> Breach | None:
    for name, values in columns.items():
        if name.startswith("commands.") and not np.isfinite(values).all():
            return _breach(f"{name} is a number", columns, ~np.isfinite(values), values, 0.0)
    return None


def _voltage(columns: Columns, settings: Settings) -> Breach | None:
    volts = np.abs(columns["commands.insertion_v"])
    limit = settings.insertion_servo.voltage_limit_v
    return _above("voltage within the supply", columns, volts, limit)


def _torque_off(columns: Columns, _: Settings) -> Breach | None:
    for axis in ("insertion", "valve"):
        volts = np.abs(columns[f"commands.{axis}_v"])
        idle = np.where(columns[f"commands.{axis}_on"] > 0.0, 0.0, volts)
        found = _above(f"no voltage on the {axis} axis without torque", columns, idle, 0.0)
        if found is not None:
            return found
    return None


def _head_speed(columns: Columns, settings: Settings) -> Breach | None:
    """Inwards; on the way out a command may drop to where the head is."""
    driven = columns["commands.insertion_on"] > 0.0
    both = driven & np.concatenate(([False], driven[:-1]))
    step = np.concatenate(([0.0], np.diff(columns["commands.head_mm"])))
    limit = settings.limits.head_speed_mm_per_s + ROUNDING / DT_S
    speed = np.where(both, step / DT_S, 0.0)
    return _above("head command within its speed", columns, speed, limit)


def _is_parked_closed(columns: Columns, settings: Settings) -> Ticks:
    """Pre-use test with the valve read closed and the head parked: the relief valve's own test."""
    cam, off_mm = columns["readings.cam_rad"], columns["readings.head_mm"]
    off_mm = np.abs(off_mm - settings.limits.park_head_mm)
    closed = (cam >= -valve_axis.BEHIND_RAD) & (cam <= valve_axis.CLOSED_RAD)
    closed &= columns["readings.cam_valid"] > 0.0
    parked = (off_mm <= watch.PARKED_MM) & (columns["readings.head_valid"] > 0.0)
    found: Ticks = closed & parked & (columns["phase"] == Phase.CHECKING)
    return found


def _vacuum_command(columns: Columns, settings: Settings) -> Breach | None:
    wanted, limit = columns["commands.vacuum_mmhg"], settings.limits.vacuum_mmhg
    highest = np.where(
        _is_parked_closed(columns, settings), settings.limits.line.parked_closed_mmhg, limit
    )
    return _breach("vacuum command within its limit", columns, wanted > highest, wanted, limit)


def _is_opening(columns: Columns) -> Ticks:
    """Ticks in which the valve is commanded to open further."""
    cam = columns["commands.cam_rad"]
    return np.concatenate(([False], np.diff(cam) > 0.0))


def _valve_phase(columns: Columns, _: Settings) -> Breach | None:
    unpowered = columns["commands.pump_on"] == 0.0
    testing = (columns["phase"] == Phase.CHECKING) & unpowered
    allowed = np.isin(columns["phase"], SUCTION_PHASES) | testing
    broken = _is_opening(columns) & ~allowed
    return _breach("valve told to open only for suction", columns, broken, columns["phase"], 0.0)


def _cut_by_trip(columns: Columns, _: Settings) -> Breach | None:
    masks = columns["verdict.trips"].astype(np.int64)
    begin = np.concatenate(([0], np.flatnonzero(np.diff(masks)) + 1))
    cuts = [mask for mask in {*masks[begin].tolist()} if condition_mask.cuts_vacuum(mask)]
    cut = np.isin(masks, cuts)
    broken = cut & (_is_opening(columns) | (columns["commands.pump_on"] > 0.0))
    return _breach("no vacuum where a trip cuts it", columns, broken, masks.astype(float), 0.0)


def _command_advance(columns: Columns, settings: Settings) -> Breach | None:
    """Breach, by the readings: the head command advances while the valve is commanded open."""
    told_open = columns["commands.cam_rad"] > 0.0
    told_open &= columns["commands.valve_on"] > 0.0
    driven = columns["commands.insertion_on"] > 0.0
    driven &= columns["phase"] != Phase.CHECKING
    advance = trace_advance_mm(columns["commands.head_mm"], told_open & driven)
    following = settings.limits.following_mm
    # The command may be behind the head by its following distance when the valve opens.
    return _above("no advance with the valve open", columns, advance, ADVANCE_MM + following)


COMMAND_SIDE: tuple[Check, ...] = (
    _finite_commands,
    _voltage,
    _torque_off,
    _head_speed,
    _vacuum_command,
    _valve_phase,
    _cut_by_trip,
    _command_advance,
)
"""Never broken, under any fault."""


def command_side(columns: Columns, settings: Settings) -> list[Breach]:
    """Invariants of what the controller sends that were broken; none ever should be.

    columns: with the commands that the controller sent (`injection.InjectedRun.sent`), not those
    that the drives obeyed: what a link loses or delays is no breach of the controller's.
    """
    found = (check(columns, settings) for check in COMMAND_SIDE)
    return [breach for breach in found if breach is not None]
