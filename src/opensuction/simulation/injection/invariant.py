"""What must hold in every tick of a run under any fault, checked on the trace afterwards.

There are two kinds. The *command side* is what the controller sends, judged by what it has read: no
fault excuses a breach. The *physical bounds* are what happens to the patient: they hold without a
fault and under any single one, raised for some faults by `fault_allowance`.
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.controller.record import Settings
from opensuction.kernel.phase import Phase
from opensuction.safety import condition_mask
from opensuction.safety.governor.limiter import ADVANCE_MM
from opensuction.safety.watch import valve_axis, watch
from opensuction.simulation.closed_loop import COLUMNS, DT_S
from opensuction.simulation.injection import fault_allowance
from opensuction.simulation.injection.fault_allowance import PhysicalBound
from opensuction.simulation.injection.injection import SIGNS
from opensuction.simulation.outcome import VENTED_MMHG
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault import Fault

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

_READ = (
    "readings.cam_rad",
    "readings.cam_valid",
    "readings.head_mm",
    "readings.head_valid",
    "truth.contact_n",
    "truth.tip_mm",
    "truth.tip_vacuum_mmhg",
)
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


def advance_mm(position_mm: Samples, counts: Ticks) -> Samples:
    """Net advance so far within each unbroken stretch in which ``counts`` holds; 0 elsewhere."""
    found = np.zeros_like(position_mm)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], counts.astype(np.int8), [0]))))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        part = position_mm[start:end]
        found[start:end] = part - np.minimum.accumulate(part)
    return found


def duration_s(counts: Ticks) -> Samples:
    """For how long ``counts`` has held without a break, in each tick."""
    index = np.arange(counts.size)
    last_off = np.maximum.accumulate(np.where(counts, -1, index))
    return np.where(counts, index - last_off, 0) * DT_S


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
    closed = (np.abs(cam) <= valve_axis.CLOSED_RAD) & (columns["readings.cam_valid"] > 0.0)
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
    cuts = [mask for mask in np.unique(masks) if condition_mask.cuts_vacuum(int(mask))]
    cut = np.isin(masks, cuts)
    broken = cut & (_is_opening(columns) | (columns["commands.pump_on"] > 0.0))
    return _breach("no vacuum where a trip cuts it", columns, broken, masks.astype(float), 0.0)


def _command_advance(columns: Columns, settings: Settings) -> Breach | None:
    """By what was read: the head command does not advance while the valve is commanded open."""
    told_open = columns["commands.cam_rad"] > 0.0
    told_open &= columns["commands.valve_on"] > 0.0
    driven = columns["commands.insertion_on"] > 0.0
    driven &= columns["phase"] != Phase.CHECKING
    advance = advance_mm(columns["commands.head_mm"], told_open & driven)
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


class Grace(NamedTuple):
    """Times that the machine needs once it has noticed, on top of a limit."""

    closing_s: float
    """From the order to close until no vacuum is left at the tip."""
    withdrawal_s: float
    """From the command to withdraw until the tip is out, or the drive's torque is off."""


FORCE_N = 0.3
"""Peak force on the carina [design-force]."""
CLOSING_S = 2.5
"""The cam's stroke of 2 s at the paper's 15 deg/s, and the line's venting."""
EXCESS_S = 0.5
"""How long vacuum above its limit may act: noticed after .2 s, vented within .3 s."""


def grace(settings: Settings) -> Grace:
    """What the settings' machine needs."""
    return Grace(closing_s=CLOSING_S, withdrawal_s=settings.limits.withdrawal_s)


def _is_inside(columns: Columns, settings: Settings) -> Ticks:
    inside: Ticks = columns["truth.tip_mm"] > settings.limits.outside_mm
    return inside


def _is_sucking(columns: Columns) -> Ticks:
    sucking: Ticks = columns["truth.tip_vacuum_mmhg"] > VENTED_MMHG
    return sucking


def _advance(columns: Columns, _: Settings) -> Samples:
    return advance_mm(columns["truth.tip_mm"], _is_sucking(columns))


def _negative_pressure(columns: Columns, settings: Settings) -> Samples:
    return duration_s(_is_sucking(columns) & _is_inside(columns, settings))


def _in_airway(columns: Columns, settings: Settings) -> Samples:
    """A catheter that cannot be drawn out is left without torque, vented, to a person's hand."""
    let_go = (columns["commands.insertion_on"] == 0.0) & ~_is_sucking(columns)
    return duration_s(_is_inside(columns, settings) & ~let_go)


def _excess(columns: Columns, settings: Settings) -> Samples:
    """At the tip, in the airway: what the line holds behind a closed valve harms nobody."""
    felt = np.where(_is_inside(columns, settings), columns["truth.tip_vacuum_mmhg"], 0.0)
    return duration_s(felt > settings.limits.vacuum_mmhg)


class PhysicalCheck(NamedTuple):
    """A bound of what happens to the patient."""

    bound: PhysicalBound
    values: Callable[[Columns, Settings], Samples]
    limit: Callable[[Settings], float]
    """Where no fault raises it."""


PHYSICAL: tuple[PhysicalCheck, ...] = (
    PhysicalCheck(
        PhysicalBound.TIP,
        lambda columns, _: columns["truth.tip_mm"],
        lambda settings: settings.limits.cap_mm,
    ),
    PhysicalCheck(
        PhysicalBound.FORCE, lambda columns, _: columns["truth.contact_n"], lambda _: FORCE_N
    ),
    PhysicalCheck(PhysicalBound.ADVANCE, _advance, lambda _: ADVANCE_MM),
    PhysicalCheck(
        PhysicalBound.SUCTION,
        _negative_pressure,
        lambda settings: settings.limits.negative_pressure_s + grace(settings).closing_s,
    ),
    PhysicalCheck(
        PhysicalBound.AIRWAY,
        _in_airway,
        lambda settings: settings.limits.in_airway_s + grace(settings).withdrawal_s,
    ),
    PhysicalCheck(PhysicalBound.VACUUM, _excess, lambda _: EXCESS_S),
)
"""Bounds that hold under any single fault, too."""


def physical(columns: Columns, settings: Settings, faults: Iterable[Fault] = ()) -> list[Breach]:
    """Physical bounds that were broken.

    faults: those that came; the bound is raised by what the worst of them adds.
    """
    came = tuple(faults)
    found = []
    for one in PHYSICAL:
        limit = fault_allowance.raise_limit(one.bound, one.limit(settings), came)
        found.append(_above(one.bound.value, columns, one.values(columns, settings), limit))
    return [breach for breach in found if breach is not None]
