"""Axes of the machine: DC motor with gear, the valve's cam, a hand on the catheter head.

Both axes have a DC motor with gear, referred to its output. The electrical time constant (0.02 ms
for a 1524T024SR: 1.67 mH over 79.3 ohm) is a fiftieth of a tick, so the current is settled; what
remains is linear of first order and is integrated exactly within a tick: exponentially while the
voltage rules, at constant acceleration while the drive's current limit does.

The cam lifts in proportion to its angle, so the spring's torque, force times lift per radian,
grows with the angle and nowhere vanishes: without motor torque the valve closes from any opening.

The hand is there while the insertion drive's torque is off. It imposes a speed: it is stronger than
friction and shorted motor together ([computed] 1.3 N of friction, at most 5 N of braking at the
drive's current limit; a hand gives tens of newtons), so the axis follows it, and encoder, gear,
conduit and tip follow the axis as they always do. It feels the force at the tip, which [assumed]
reaches it through the catheter it grips, and answers after its reaction time. While the drive has
torque the hand yields to it.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero
from opensuction.twin.parameter import SPREAD_LIMIT
from opensuction.twin.parameter_row import Parameter


class ValveMechanism(NamedTuple):
    """The cam pushes the valve open, the spring pushes it back."""

    stroke_rad: float
    """Cam angle of the full stroke (30 degrees)."""
    slide_mm: float
    """Travel of the valve at the full stroke (s = 5 mm)."""
    seal_mm: float
    """Travel before the seal opens."""
    spring_preload_v: float
    """Load of the closed spring on the valve axis, as the voltage that balances it."""
    spring_v_per_rad: float
    stop_rad: float
    """End stop, this far behind the closed position."""
    least_ratio: float
    """The slide closes no further: 0, but where it sticks open or its seal is torn."""
    most_ratio: float
    """The slide opens no further: 1, but where it has parted from the cam."""


@compiled
def slide_mm(valve: ValveMechanism, cam_rad: float) -> float:
    """Valve travel for a cam angle, in proportion between closed and full stroke."""
    return valve.slide_mm * min(max(cam_rad / valve.stroke_rad, 0.0), 1.0)


@compiled
def open_ratio(valve: ValveMechanism, cam_rad: float) -> float:
    """Share of the valve's full opening, 0 to 1."""
    past_seal = slide_mm(valve, cam_rad) - valve.seal_mm
    lifted = past_seal / (valve.slide_mm - valve.seal_mm)
    return min(max(lifted, valve.least_ratio), valve.most_ratio)


@compiled
def load_v(valve: ValveMechanism, cam_rad: float) -> float:
    """Load of the spring on the valve axis, as a voltage; none once the cam has let go."""
    if cam_rad <= 0.0:
        return 0.0
    return valve.spring_preload_v + valve.spring_v_per_rad * cam_rad


class DcAxis(NamedTuple):
    """An axis in units of its output (mm for insertion, rad for the valve)."""

    speed_per_v: float
    """No-load speed for each volt, without friction (1/s per volt)."""
    time_constant_s: float
    """Mechanical time constant: speed reached to 63 % after a step of voltage."""
    voltage_limit_v: float
    """Supply."""
    friction_v: float
    """Coulomb friction as the voltage that just overcomes it."""
    force_v: float
    """Current limit as the voltage that drives that current at standstill."""
    encoder_step: float
    """Resolution of the encoder."""
    brakes_when_off: bool
    """Whether the drive shorts the motor's windings when its torque is off; else it is open."""
    polarity: float
    """1; -1 where the motor's wires are swapped."""


class AxisMotion(NamedTuple):
    """State of an axis."""

    position: float
    velocity: float
    drive_v: float
    """Voltage that drives current: supply minus back-EMF, limited; proportional to current."""


@compiled
def _free_run(
    axis: DcAxis, motion: AxisMotion, drive_v: float, limited: bool, brake_v: float, dt_s: float
) -> AxisMotion:
    """Motion of a moving axis against a constant braking voltage (friction and load)."""
    gain = axis.speed_per_v
    tau = axis.time_constant_s
    if limited:
        acceleration = gain * (drive_v - brake_v) / tau
        velocity = motion.velocity + acceleration * dt_s
        position = motion.position + (motion.velocity + velocity) * 0.5 * dt_s
    else:
        final = motion.velocity + gain * (drive_v - brake_v)
        decay = math.exp(-dt_s / tau)
        velocity = final + (motion.velocity - final) * decay
        position = motion.position + final * dt_s + (motion.velocity - final) * tau * (1.0 - decay)
    return AxisMotion(position=position, velocity=velocity, drive_v=drive_v)


@compiled
def step(
    axis: DcAxis, motion: AxisMotion, volts: float, on: bool, load_v: float, dt_s: float
) -> AxisMotion:
    """Advance an axis by one tick.

    volts: amplifier command, clamped to the supply. on: torque enabled; off, the windings are
    open or, where the drive ``brakes_when_off``, shorted: the motor brakes itself.
    load_v: force of the load against positive motion, as the voltage that would balance it.
    Returns the motion after ``dt_s`` seconds.
    """
    drive_v = 0.0
    limited = True
    if on or axis.brakes_when_off:
        wired_v = axis.polarity * volts
        supply_v = min(max(wired_v, -axis.voltage_limit_v), axis.voltage_limit_v) if on else 0.0
        wanted_v = supply_v - motion.velocity / axis.speed_per_v
        drive_v = min(max(wanted_v, -axis.force_v), axis.force_v)
        limited = drive_v != wanted_v
    net_v = drive_v - load_v
    if motion.velocity == 0.0:
        if abs(net_v) <= axis.friction_v:
            return AxisMotion(position=motion.position, velocity=0.0, drive_v=drive_v)
        direction = 1.0 if net_v > 0.0 else -1.0
    else:
        direction = 1.0 if motion.velocity > 0.0 else -1.0
    moved = _free_run(axis, motion, drive_v, limited, load_v + direction * axis.friction_v, dt_s)
    if moved.velocity * direction <= 0.0:
        # Friction can stop an axis but never turn it round: it rests until the next tick decides.
        # Within the tick it brakes evenly, so it stops after this share of it.
        share = motion.velocity / (motion.velocity - moved.velocity)
        rest = motion.position + 0.5 * motion.velocity * share * dt_s
        return AxisMotion(position=rest, velocity=0.0, drive_v=drive_v)
    return moved


@compiled
def stopped(motion: AxisMotion, least: float, most: float) -> AxisMotion:
    """Motion of an axis after its end stops, which it hits without a bounce."""
    if least <= motion.position <= most:
        return motion
    end = least if motion.position < least else most
    return AxisMotion(position=end, velocity=0.0, drive_v=motion.drive_v)


@compiled
def encoder(axis: DcAxis, motion: AxisMotion) -> float:
    """Position as the encoder reports it, rounded to its step."""
    return math.floor(motion.position / axis.encoder_step + 0.5) * axis.encoder_step


HAND_PURPOSE = 2_000_000
"""Streams from here on draw the hands of run 0, 1, 2, ..."""

HAND_PARAMETERS: dict[str, Parameter] = {
    "quick_mm_per_s": Parameter(25.0, 2.0, "mm/s", "speed inside the tube", "[assumed]", 5.0, 60.0),
    "slow_mm_per_s": Parameter(
        8.0,
        0.8,
        "mm/s",
        "speed beyond it",
        "[assumed] below the 10 of nurses, [paper] II-A",
        2.0,
        20.0,
    ),
    "out_mm_per_s": Parameter(30.0, 3.0, "mm/s", "speed on the way back", "[assumed]", 5.0, 60.0),
    "acceleration_mm_per_s2": Parameter(
        150.0, 0.0, "mm/s2", "of the hand", "[assumed]", 50.0, 1000.0
    ),
    "felt_n": Parameter(
        0.08,
        0.01,
        "N",
        "force at the tip that is felt",
        "[assumed] as the contact switch's",
        0.02,
        0.3,
    ),
    "reaction_s": Parameter(0.25, 0.04, "s", "from feeling to stopping", "[assumed]", 0.1, 1.0),
    "confirm_s": Parameter(
        0.2,
        0.04,
        "s",
        "from stopping to confirming",
        "[assumed] a button under the thumb",
        0.05,
        2.0,
    ),
    "hold_s": Parameter(0.1, 0.0, "s", "from confirming to drawing back", "[assumed]", 0.05, 5.0),
    "mark_mm": Parameter(
        0.0, 0.15, "mm", "error of the mark at which it lets go", "[assumed]", -2.0, 2.0
    ),
}
"""How people push: value, spread between people, unit, meaning, source, plausible range."""


class HandStage(IntEnum):
    """Stage of the hand's action."""

    AWAY = 0
    PUSHING = 1
    HOLDING = 2
    PULLING = 3
    LET_GO = 4


class Hand(NamedTuple):
    """Parameters of a hand; see `HAND_PARAMETERS`."""

    present: bool
    quick_until_mm: float
    """Head position up to which it pushes quickly: the tube's length on the scale."""
    quick_mm_per_s: float
    slow_mm_per_s: float
    out_mm_per_s: float
    acceleration_mm_per_s2: float
    felt_n: float
    reaction_s: float
    confirm_s: float
    hold_s: float
    park_mm: float
    """Head position at which it lets go."""


class HandState(NamedTuple):
    """State of the hand."""

    stage: int
    stage_s: float
    felt_s: float
    """Time since the tip's resistance was felt; 0 before."""


NOBODY = make_zero(Hand)
"""No hand is at the machine."""
AWAY = make_zero(HandState)
PUSHING = AWAY._replace(stage=1)


def draw_hand(park_head_mm: float, quick_mm: float, seed: int, run: int) -> Hand:
    """A person's hand. park_head_mm: where the head is parked. quick_mm: length of the tube way.

    seed, run: draw the person.
    """
    source = random_stream.stream(seed, HAND_PURPOSE + run)
    values = {}
    for name, parameter in HAND_PARAMETERS.items():
        draw, _, source = random_stream.normal_pair(source)
        cut = min(max(draw, -SPREAD_LIMIT), SPREAD_LIMIT)
        values[name] = parameter.value + parameter.spread * cut
    mark_mm = values.pop("mark_mm")
    return Hand(
        present=True,
        quick_until_mm=park_head_mm + quick_mm,
        park_mm=park_head_mm + mark_mm,
        **values,
    )


@compiled
def is_gripping(state: HandState) -> bool:
    """True where the hand decides the head's position."""
    return state.stage in (HandStage.PUSHING, HandStage.HOLDING, HandStage.PULLING)


def confirms_in_s(hand: Hand, state: HandState) -> float:
    """Time until the hand presses the button, s; at most 0 once it is due.

    While it has felt nothing, the least that is left; infinite for a hand that no longer will.
    """
    if state.stage == HandStage.PUSHING:
        return hand.reaction_s - state.felt_s + hand.confirm_s
    return hand.confirm_s - state.stage_s if state.stage == HandStage.HOLDING else math.inf


@compiled
def _wanted_mm_per_s(hand: Hand, stage: int, head_mm: float) -> float:
    if stage == HandStage.PUSHING:
        return hand.quick_mm_per_s if head_mm < hand.quick_until_mm else hand.slow_mm_per_s
    if stage == HandStage.PULLING:
        # It slows down before the mark.
        left_s = (head_mm - hand.park_mm) * 5.0
        return -min(hand.out_mm_per_s, max(left_s, hand.slow_mm_per_s * 0.1))
    return 0.0


@compiled
def _next_stage(hand: Hand, state: HandState, head_mm: float, felt_s: float) -> int:
    stage = state.stage
    if stage == HandStage.PUSHING and felt_s > hand.reaction_s:
        return HandStage.HOLDING
    if stage == HandStage.HOLDING and state.stage_s >= hand.confirm_s + hand.hold_s:
        return HandStage.PULLING
    if stage == HandStage.PULLING and head_mm <= hand.park_mm:
        return HandStage.LET_GO
    return stage


@compiled
def step_hand(
    hand: Hand, state: HandState, motion: AxisMotion, contact_n: float, dt_s: float
) -> tuple[HandState, AxisMotion]:
    """Advance hand and axis by one tick; the drive's torque is off.

    contact_n: force at the tip.
    """
    felt_s = state.felt_s
    if state.stage == HandStage.PUSHING and (contact_n >= hand.felt_n or felt_s > 0.0):
        felt_s += dt_s
    stage = _next_stage(hand, state, motion.position, felt_s)
    stage_s = state.stage_s + dt_s if stage == state.stage else 0.0
    reach = hand.acceleration_mm_per_s2 * dt_s
    wanted = _wanted_mm_per_s(hand, stage, motion.position)
    velocity = min(max(wanted, motion.velocity - reach), motion.velocity + reach)
    position = motion.position + 0.5 * (motion.velocity + velocity) * dt_s
    return (
        HandState(stage=stage, stage_s=stage_s, felt_s=felt_s),
        AxisMotion(position=position, velocity=velocity, drive_v=0.0),
    )
