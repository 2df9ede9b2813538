"""Fault signatures of the line vacuum: pump, regulator, valve, canister and catheter.

Judged against the set point and the pump command that were let through, and against the cam. A
sound line rises to its set point as long as it is pumped, holds it (and up to 5 mmHg more) behind a
closed valve, keeps its vacuum while the pump rests for the insertion, falls to the equilibrium of
pump and free catheter when the valve opens, and vents on command.

Each detector has a precondition, and another detector covers the line where that does not hold.
That the set point is held presumes that it has been reached: until then the line must rise, from
`BEGUN_S` after the pump was told to. That a resting line keeps its vacuum presumes that there is
some: it is held to the most that it has had in this rest, from the first tick on, and the procedure
lets the tip go in only once a rest has shown it (`progress.is_kept`). A slide that opens with its
cam is the cam's (`valve_axis`). A thin catheter beside a running pump is seen by none of them: on
the way in no pump runs, and at its end it would suck there anyway.

Faults that look alike in the canister's vacuum are named by the table
in `docs/explanations/alarms.md`.

The vacuum sensor's reading without its noise and without its offset.

White noise of some mmHg lies in every reading and says nothing; what the line does takes longer. A
vented line is at the room's pressure: what is read there is the sensor's offset, as far as a sound
one can have it. A larger one stays in the reading, and the pre-use test refuses it.
"""

from typing import NamedTuple

from opensuction.kernel.arithmetic import add_up_duration, drop_tiny, extend_duration, flag
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings, is_number
from opensuction.kernel.record import make_zero
from opensuction.safety.condition import Condition
from opensuction.safety.limits import LineLimits

FILTER_S = 0.02
"""Time constant of the filter: of white noise a sixth is left, of a loss 20 ms are [computed]."""
ZERO_MMHG = 7.0
"""Offset up to which it is taken for the sensor's: 1 % of 500 mmHg, drift and what is left of the
noise; assumed."""
ZERO_S = 0.2
"""Time constant over which the offset is learnt; the pre-use test begins with a second without a
pump."""


class LineFilter(NamedTuple):
    """The reading, as it came and as it is taken."""

    raw_mmhg: float
    """Last reading that was one."""
    smooth_mmhg: float
    """It without its noise."""
    zero_mmhg: float
    """What of it is the sensor's offset."""
    heard: bool
    """There has been one: the first is believed at once."""


FILTER_START = make_zero(LineFilter)


@compiled
def vacuum_mmhg(state: LineFilter) -> float:
    """Vacuum in the line, as far as it is known."""
    return state.smooth_mmhg - state.zero_mmhg


@compiled
def step_filter(state: LineFilter, readings: Readings, vented: bool, dt_s: float) -> LineFilter:
    """Bring it up to this tick. vented: neither pump nor set point in the last tick."""
    raw = readings.line_vacuum_mmhg
    if not (readings.vacuum_valid and is_number(raw)):
        return state
    smooth = raw
    if state.heard:
        smooth = state.smooth_mmhg + (raw - state.smooth_mmhg) * (dt_s / (FILTER_S + dt_s))
    zero = state.zero_mmhg
    if vented and abs(smooth) <= ZERO_MMHG:
        zero += (smooth - zero) * (dt_s / (ZERO_S + dt_s))
    return LineFilter(
        raw_mmhg=raw, smooth_mmhg=drop_tiny(smooth), zero_mmhg=drop_tiny(zero), heard=True
    )


RATE_S = 0.1
"""Window over which the fall of the vacuum is measured; a sensor's noise of 1 mmHg is 10 mmHg/s."""
READY_SHARE = 0.9
"""Share of the set point from which the pump has built it up."""
BUILD_S = 5.0
"""Longest time for that; longer than the pre-use test waits (4.2 s), which names the pump then."""
CLOSED_SHARE = 0.94
"""Share of the set point below which vacuum is lost behind a closed valve: 5 mmHg, a sensor's
error (1 % of 500 mmHg; assumed), of a neonate's 80."""
BEGUN_S = 0.2
"""How long after a pump has been told to build the vacuum the line must rise: its own start, the
filter's 20 ms and `RATE_S` to see it; assumed."""
BUILDING_MMHG = 0.5
"""Above its average over `RATE_S` by so much a line that has not reached its set point still comes
nearer, 5 mmHg/s: the slowest that the pre-use test lets pass, of a neonate's line, does 9 at the
end, and noise of 1 mmHg is 0.14 behind the filter [computed]."""
RISING_MMHG = 2.0
"""Above its average over `RATE_S` by so much the vacuum is still being built up: 20 mmHg/s, a tenth
of what a pump gives and ten times what a sensor's noise makes of the average [computed]."""
CLOSED_LOW_S = 0.3
OPEN_LOW_S = 0.5
"""How long it may be too low: closed, and open; assumed."""
SLOW_SHARE_PER_S = 0.08
"""A fall slower than this share of the set point a second is a pump that stands still on a sound
line: that loses 2 % [computed], the pre-use test allows 5 %."""
REST_SETTLE_S = 0.3
"""How long after the pump came to rest behind an open valve the regulator may let the line down to
its set point: 17 ms, and `RATE_S` to see it [computed]. Behind a closed one it is held to no more
than the set point from the first tick on."""
REST_SHARE_PER_S = 0.06
"""Share of its vacuum that a resting line may lose in a second: the pre-use test allows 0.05, a
sound line loses 0.02, one whose valve is 30 % open on a thin catheter 0.1, or 5 % open on a thick
one 0.07 [computed]. A leak takes the same share all the way down; turbulent flow through a bore a
growing one."""
REST_FALL_MMHG = 1.4
"""Vacuum below what a resting line must keep that is a loss: a sensor's noise of 1 mmHg averaged
over `RATE_S` is 0.1, the most that a file may set twice that [computed]; 180 sound machines of up
to 3 standard deviations came to 0.3 [in-silico]."""
REST_LOW_S = 0.1
"""How long it may have less: then its fall, averaged over `RATE_S`, tells a leak from the valve. A
catheter's fall is at most 0.8 of its first rate by then, and a leak's of 7 mL/s per mmHg more than
that [computed]."""
REST_NOISE_MMHG_PER_S = 20.0
"""What a sensor's noise of 1 mmHg can add to that fall, two standard deviations [computed]."""
STEEP_RATIO = 1.5
"""A fall steeper than an open valve's by this is a leak."""
SMALL_RATIO = 2.0
"""A fall steeper than an open catheter's without a pump by this is a canister without room."""
CLOGGED_S = 4.6
"""How long an open valve may draw no flow: plugs of thick mucus do so for up to 4 s in sound
cycles [in-silico]."""
FLOW_SHARE = 0.25
"""Share of a free catheter's fall without a pump that shows that something is drawn: in 120 sound
cycles of children and neonates it was never less [in-silico]; a sound line loses 0.06 of it."""
FLOW_FADE = 2.0
"""How much more a tick with flow takes off than one without adds: noise of 1 mmHg is 2 mmHg/s of
the fall, half of what lies between a neonate's least flow and none [computed]."""
NO_FLOW_S = 0.3
"""How long an open line without a pump may draw less than that, once the regulator has settled:
with `REST_SETTLE_S` and `RATE_S` it is told 0.7 s after the valve has opened, in a dwell of 0.9."""
OVER_MMHG = 15.0
"""Vacuum over the set point: a regulator settles at most 5 mmHg above (300 mL/s / 60 mL/s/mmHg)
[computed], and a sensor's error of 5; assumed."""
OVER_REST_MMHG = 5.0
"""The same while the pump rests: nothing holds a sound line above its set point then, and a
sensor's error is 1.7. A pump that runs away against the weakest relief valve leaves 6.3 over a
child's set point, after that error [computed]."""
OVER_S = 0.5
"""How long it may be above: a new set point settles in 0.1 s."""
VENTED_S = 1.0
"""How long a line may take to vent with the pump off; 0.1 s when sound [computed]."""
DECAY_SHARE_PER_S = 0.01
"""A vacuum that is not vented and falls by this share a second has no pump behind it."""


class LineWatch(NamedTuple):
    """Watch on the line, up to this tick."""

    vacuum_mmhg: float
    """Last valid reading."""
    slow_mmhg: float
    """It averaged over `RATE_S`."""
    set_mmhg: float
    """Set point in that tick."""
    pumping_s: float
    """How long the pump has been commanded to run against a set point that was not raised."""
    built: bool
    """It has reached its set point since."""
    fall_mmhg_per_s: float
    """Steepest fall since the vacuum was last as high as its set point, 0 or negative."""
    rest_s: float
    """How long the pump has rested behind a closed valve."""
    kept_mmhg: float
    """Vacuum that a sound line has left by now."""
    rest_low_s: float
    """How long it has had less."""
    closed_low_s: float
    open_low_s: float
    clogged_s: float
    over_s: float
    unvented_s: float
    open_rest_s: float
    """How long the pump has rested behind an open valve."""
    no_flow_s: float
    """How long nothing has been drawn meanwhile."""


START = make_zero(LineWatch)


@compiled
def _average(
    state: LineWatch, vacuum_mmhg: float, set_mmhg: float, pumping: bool, dt_s: float
) -> float:
    """Vacuum averaged over `RATE_S`; afresh while the regulator brings it down to its set point."""
    if pumping and vacuum_mmhg >= set_mmhg:
        return vacuum_mmhg
    return drop_tiny(state.slow_mmhg + (vacuum_mmhg - state.slow_mmhg) * (dt_s / (RATE_S + dt_s)))


@compiled
def _steepen(state: LineWatch, vacuum_mmhg: float, set_mmhg: float, slow_mmhg: float) -> float:
    """Steepest fall so far, once the set point has been reached and lost again."""
    if vacuum_mmhg >= set_mmhg:
        return 0.0
    return min(state.fall_mmhg_per_s, (vacuum_mmhg - slow_mmhg) / RATE_S)


@compiled
def _keep(state: LineWatch, slow_mmhg: float, set_mmhg: float, resting: bool, dt_s: float) -> float:
    """Vacuum that a sound line has left at rest; what is over the set point the regulator takes."""
    there_mmhg = min(slow_mmhg, set_mmhg)
    if not resting:
        return there_mmhg
    # Never below what there is: a loss is noticed by its rate, however long the rest before.
    return max(drop_tiny(state.kept_mmhg - REST_SHARE_PER_S * state.kept_mmhg * dt_s), there_mmhg)


@compiled
def step(
    limits: LineLimits,
    state: LineWatch,
    vacuum_mmhg: float,
    set_mmhg: float,
    pump_on: bool,
    is_open: bool,
    is_closed: bool,
    dt_s: float,
) -> LineWatch:
    """Bring it up to this tick.

    set_mmhg, pump_on: what was let through in the last tick. is_open, is_closed: the valve is
    commanded to be, and its cam is there.
    """
    pumping = pump_on and set_mmhg > 0.0
    paused = not pump_on and set_mmhg > 0.0
    vented = not pump_on and set_mmhg == 0.0
    raised = set_mmhg > state.set_mmhg
    slow = _average(state, vacuum_mmhg, set_mmhg, pumping, dt_s)
    pumping_s = extend_duration(state.pumping_s, pumping and not raised, dt_s)
    built = (pumping and vacuum_mmhg >= READY_SHARE * set_mmhg) or (
        (pumping or paused) and state.built and not raised
    )
    judged = pumping and (built or pumping_s > BEGUN_S)
    building = not built and pumping_s <= BUILD_S
    rising = vacuum_mmhg > slow + (BUILDING_MMHG if building else RISING_MMHG)
    lost = vacuum_mmhg < CLOSED_SHARE * set_mmhg and not rising
    closed_low = judged and is_closed and lost
    late = judged and not building
    open_low = late and is_open and vacuum_mmhg < limits.open_low_share * set_mmhg
    clogged = pumping and is_open and vacuum_mmhg > limits.clogged_share * set_mmhg
    unvented = vented and vacuum_mmhg > OVER_MMHG
    over_mmhg = OVER_MMHG if pump_on else OVER_REST_MMHG
    over = set_mmhg > 0.0 and vacuum_mmhg > set_mmhg + over_mmhg
    rest_s = extend_duration(state.rest_s, paused and is_closed, dt_s)
    open_rest_s = extend_duration(state.open_rest_s, paused and is_open and limits.rests_open, dt_s)
    least_fall = FLOW_SHARE * limits.bore_fall_mmhg_per_s
    kept_open = open_rest_s > REST_SETTLE_S and (slow - vacuum_mmhg) / RATE_S < least_fall
    # How long nothing has been drawn in this rest: noise breaks it off now and then.
    no_flow_s = (
        add_up_duration(state.no_flow_s, kept_open, FLOW_FADE, dt_s) if open_rest_s > 0.0 else 0.0
    )
    kept = _keep(state, slow, set_mmhg, rest_s > 0.0, dt_s)
    fall = _steepen(state, vacuum_mmhg, set_mmhg, slow) if built else 0.0
    return LineWatch(
        vacuum_mmhg=vacuum_mmhg,
        slow_mmhg=slow,
        set_mmhg=set_mmhg,
        pumping_s=pumping_s,
        built=built,
        fall_mmhg_per_s=fall,
        rest_s=rest_s,
        kept_mmhg=kept,
        rest_low_s=extend_duration(state.rest_low_s, slow < kept - REST_FALL_MMHG, dt_s),
        closed_low_s=extend_duration(state.closed_low_s, closed_low, dt_s),
        open_low_s=extend_duration(state.open_low_s, open_low, dt_s),
        clogged_s=extend_duration(state.clogged_s, clogged, dt_s),
        open_rest_s=open_rest_s,
        no_flow_s=no_flow_s,
        over_s=extend_duration(state.over_s, over, dt_s),
        unvented_s=extend_duration(state.unvented_s, unvented, dt_s),
    )


@compiled
def _rate(state: LineWatch) -> float:
    """Present rate of the vacuum, mmHg/s, over `RATE_S`."""
    return (state.vacuum_mmhg - state.slow_mmhg) / RATE_S


@compiled
def _judge_building(limits: LineLimits, state: LineWatch) -> int:
    """Conditions indicated by a vacuum that rises no more short of its set point.

    A pump that has stopped half-way leaves what it had built, and that may be what pump and free
    catheter agree on: both are told then. Less than that is the pump's alone.
    """
    lost = 1 << Condition.VACUUM_LOST
    if state.vacuum_mmhg >= limits.open_low_share * state.set_mmhg:
        return lost | 1 << Condition.VALVE_STUCK_OPEN
    return lost


@compiled
def _judge_closed(limits: LineLimits, state: LineWatch, parked_closed: bool) -> int:
    """Conditions indicated by a vacuum that is lost behind a closed valve, the pump running."""
    if not state.closed_low_s > CLOSED_LOW_S:
        return 0
    if not state.built and state.pumping_s <= BUILD_S:
        return 0 if parked_closed else _judge_building(limits, state)
    if state.fall_mmhg_per_s > -SLOW_SHARE_PER_S * state.set_mmhg:
        return 1 << Condition.VACUUM_LOST
    if state.fall_mmhg_per_s >= -STEEP_RATIO * limits.open_fall_mmhg_per_s:
        return 1 << Condition.VALVE_STUCK_OPEN
    return 1 << Condition.LINE_LEAKING


@compiled
def _judge_rest(limits: LineLimits, state: LineWatch) -> int:
    """Conditions indicated by a vacuum that is lost while the pump rests."""
    if not state.rest_low_s > REST_LOW_S:
        return 0
    beyond = -_rate(state) - REST_NOISE_MMHG_PER_S
    per_root = limits.bore_fall_mmhg_per_s_per_root
    # Both squared: the proof of the way out knows no roots.
    if beyond > 0.0 and beyond * beyond > per_root * per_root * state.kept_mmhg:
        return 1 << Condition.LINE_LEAKING
    return 1 << Condition.VALVE_STUCK_OPEN


@compiled
def _judge_open(limits: LineLimits, state: LineWatch) -> int:
    """Conditions indicated by too much or too little vacuum with the valve open."""
    stuffed = state.clogged_s > CLOGGED_S or state.no_flow_s > NO_FLOW_S
    clogged = flag(stuffed, Condition.LINE_CLOGGED)
    if not state.open_low_s > OPEN_LOW_S:
        return clogged
    if state.fall_mmhg_per_s < -SMALL_RATIO * limits.bore_fall_mmhg_per_s:
        return clogged | 1 << Condition.CANISTER_FULL
    return clogged | 1 << Condition.VACUUM_LOST


@compiled
def _judge_vented(state: LineWatch) -> int:
    """Conditions indicated by a vacuum that stays with the pump off."""
    if not state.unvented_s > VENTED_S:
        return 0
    if _rate(state) > -DECAY_SHARE_PER_S * state.vacuum_mmhg:
        return 1 << Condition.PUMP_RUNAWAY
    return 1 << Condition.VACUUM_EXCEEDED


@compiled
def judge(limits: LineLimits, state: LineWatch, parked_closed: bool) -> int:
    """Mask of what is wrong with the line.

    parked_closed: the tip is parked behind a closed valve, where the pre-use test looks for leaks,
    and for a pump that does not build the vacuum.
    """
    low_s = state.closed_low_s + state.rest_low_s + state.open_low_s
    if low_s + state.clogged_s + state.no_flow_s + state.over_s + state.unvented_s == 0.0:
        return 0
    return (
        _judge_closed(limits, state, parked_closed)
        | (0 if parked_closed else _judge_rest(limits, state))
        | _judge_open(limits, state)
        | flag(state.over_s > OVER_S, Condition.VACUUM_EXCEEDED)
        | _judge_vented(state)
    )


@compiled
def reset(state: LineWatch) -> LineWatch:
    """After a person's reset: the vacuum that is there, and nothing held against it."""
    return START._replace(
        vacuum_mmhg=state.vacuum_mmhg,
        slow_mmhg=state.slow_mmhg,
        set_mmhg=state.set_mmhg,
        kept_mmhg=state.slow_mmhg,
    )
