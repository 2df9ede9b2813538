"""A governor on its own: limits, sound readings, and a head that does what it is told."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from opensuction.kernel.interface import NO_MONITOR, Readings, Setpoints, is_number
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.safety import limits as safety_limits
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode_trips
from opensuction.safety.governor import governor
from opensuction.safety.governor.governor import GovernorState, Verdict
from opensuction.safety.head import head_vote
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.limits import (
    DriveLimits,
    Limits,
    LineLimits,
    ValveLimits,
    WindowLimits,
)
from opensuction.safety.watch import valve_axis
from opensuction.safety.watch.watch_state import Watch
from tests.settled import settled

DT_S = 0.001
NAN = float("nan")
INF = float("inf")

PARK_MM = -3.4
TIP = safety_limits.bound_tip(gain=0.9677, offset_mm=-7.151, gap_mm=22.18)

LIMITS = Limits(
    tip=TIP,
    drive=DriveLimits(
        newton_per_a=833.0,
        moving_mass_kg=16.4,
        jam_n=1.4,
        force_n=6.0,
        supply_v=24.0,
        mm_per_s_per_v=18.8 / 24.0,
        volts_per_a=1298.0,
        gaining_least_mm_per_s2=100.0,
        gaining_most_mm_per_s2=600.0,
    ),
    window=WindowLimits(from_mm=-INF, by_mm=INF),
    valve=ValveLimits(open_rad=0.52, stroke_s=10.0),
    line=LineLimits(
        open_low_share=0.35,
        clogged_share=0.95,
        rests_open=False,
        open_fall_mmhg_per_s=84.0,
        bore_fall_mmhg_per_s=307.0,
        bore_fall_mmhg_per_s_per_root=28.0,
        parked_closed_mmhg=190.0,
    ),
    cap_mm=95.0,
    outside_mm=float(safety_limits.deepest_mm(TIP, safety_limits.assume_anywhere(TIP, PARK_MM)))
    + 1.0,
    mouth_mm=INF,
    park_head_mm=PARK_MM,
    head_speed_mm_per_s=20.0,
    head_mm_per_s2=1e9,
    braking_mm_per_s2=200.0,
    leaving_mm_per_s=17.0,
    following_mm=8.0,
    stalled_mm=0.11,
    vacuum_mmhg=150.0,
    negative_pressure_s=0.5,
    in_airway_s=0.8,
    contact_s=0.3,
    driven_contact_s=INF,
    withdrawal_s=0.4,
    patient=safety_limits.limits_of(AgeGroup.ADULT, 0.0, monitored=False),
)
"""As on the bench, with times short enough to wait for, and a head that starts at once."""

HEAD_CAP_MM = float(safety_limits.head_cap_mm(TIP, LIMITS.cap_mm))


def above(value: float) -> float:
    """The least number that is more."""
    return math.nextafter(value, INF)


def below(value: float) -> float:
    """The greatest number that is less."""
    return math.nextafter(value, -INF)


def changed(record: Any, values: Mapping[str, object]) -> Any:
    """The same record with some values changed, named as ``durations.inside_s``."""
    for path, value in values.items():
        name, _, rest = path.partition(".")
        record = record._replace(
            **{name: changed(getattr(record, name), {rest: value}) if rest else value}
        )
    return record


def sound(head_mm: float) -> Readings:
    """Readings with nothing wrong, valve closed."""
    return Readings(
        head_mm=head_mm,
        head_valid=True,
        carriage_mm=head_mm,
        carriage_valid=True,
        cam_rad=0.0,
        cam_valid=True,
        line_vacuum_mmhg=10.0,
        vacuum_valid=True,
        contact_closed=False,
        contact_valid=True,
        mouth_clear=True,
        insertion_current_a=0.0,
        monitor=NO_MONITOR,
    )


def turning(time_s: float, head_mm: float, cam_rad: float = 0.3) -> Readings:
    """A sound machine with its cam there, not quite at rest: farther than its sensor's noise."""
    away_rad = math.copysign(2.0 * valve_axis.STILL_RAD, cam_rad)
    moved = round(time_s / DT_S) % 20 < 10
    return sound(head_mm)._replace(cam_rad=cam_rad + (away_rad if moved else 0.0))


def staying(head_mm: float) -> Setpoints:
    """A proposal to stay there with the valve closed, and to pump the line to what it has."""
    return Setpoints(
        head_mm=head_mm,
        head_mm_per_s=0.0,
        insertion_on=True,
        valve_open=False,
        pump_on=True,
        vacuum_mmhg=10.0,
    )


class Tick(NamedTuple):
    """What went in and came out."""

    time_s: float
    readings: Readings
    allowed: Setpoints
    verdict: Verdict
    state: GovernorState


Propose = Callable[[float], Setpoints]
"""Proposal for a time in s."""
Report = Callable[[float, float], Readings]
"""Readings for a time in s and the head command of the last tick, which the head has reached."""


def follows(_time_s: float, head_mm: float) -> Readings:
    """A sound machine."""
    return sound(head_mm)


def borne_v(limits: Limits, seen: Watch, readings: Readings) -> float:
    """Volts that bear a current and the head's own speed out."""
    current = readings.insertion_current_a if math.isfinite(readings.insertion_current_a) else 0.0
    back_v = seen.speed_mm_per_s / limits.drive.mm_per_s_per_v
    return limits.drive.volts_per_a * current + back_v


def believed(limits: Limits, seen: Watch, readings: Readings) -> HeadVote:
    """A vote that takes the encoder's word; where it says nothing the head is not seen."""
    read = readings.head_valid and is_number(readings.head_mm)
    return head_vote.start(readings.head_mm if read else seen.head_mm, read=True)._replace(
        driven_v=borne_v(limits, seen, readings),
        unseen_ticks=0 if read else seen.vote.unseen_ticks + 1,
    )


locate = settled(governor.locate)
govern = settled(governor.step)


def step(
    limits: Limits,
    state: GovernorState,
    proposal: Setpoints,
    readings: Readings,
    overrun: bool,
    dt_s: float,
) -> tuple[GovernorState, Setpoints, Verdict]:
    """A tick of the governor, the head where the encoder has it."""
    vote = believed(limits, state.watch, readings)
    return govern(limits, state, proposal, readings, vote, overrun, dt_s)


def run(
    seconds: float,
    propose: Propose,
    report: Report = follows,
    state: GovernorState | None = None,
    overrun: Callable[[float], bool] = lambda _: False,
    limits: Limits = LIMITS,
) -> list[Tick]:
    """Run a governor; begins parked unless a state is given."""
    state = governor.start(limits, PARK_MM) if state is None else state
    ticks = []
    for i in range(round(seconds / DT_S)):
        time_s = i * DT_S
        readings = report(time_s, state.last.head_mm)
        volts = borne_v(limits, state.watch, readings)
        vote = locate(limits, state, readings, volts, DT_S)
        state, allowed, verdict = govern(
            limits, state, propose(time_s), readings, vote, overrun(time_s), DT_S
        )
        ticks.append(Tick(time_s, readings, allowed, verdict, state))
    return ticks


def at(head_mm: float) -> GovernorState:
    """A governor that has seen the head drawn back to this position, at rest there."""
    started: GovernorState = changed(
        governor.start(LIMITS, head_mm), {"watch.advance.coast_mm_per_s": 0.0}
    )
    return started


def ahead(state: GovernorState, command_mm: float, mm_per_s: float = 0.0) -> GovernorState:
    """The same governor, its command ahead of the head."""
    last = state.last._replace(head_mm=command_mm, head_mm_per_s=mm_per_s)
    return state._replace(last=last)


def first(ticks: list[Tick], code: Condition) -> Tick:
    """The tick in which a trip appeared."""
    return next(tick for tick in ticks if code in decode_trips(tick.verdict.trips))


def tripped(ticks: list[Tick]) -> set[Condition]:
    """All trips of a run."""
    return set(decode_trips(ticks[-1].verdict.trips))
