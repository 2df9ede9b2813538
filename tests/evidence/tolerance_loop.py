"""Sensors' noise on the governor's own functions, for as long as one likes: how often each trips.

What is measured stands, or moves as in a cycle.
"""

from typing import NamedTuple

from opensuction.kernel.arithmetic import extend_duration
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings
from opensuction.kernel.record import make_zero
from opensuction.procedure.cycle import check
from opensuction.procedure.cycle.check import CheckPlan, CheckSeen
from opensuction.safety import invalid_ticks
from opensuction.safety.governor import judgement
from opensuction.safety.head import drive_force, head_vote
from opensuction.safety.limits import DriveLimits, LineLimits, ValveLimits
from opensuction.safety.watch import head_watch, vacuum_signature, valve_axis
from opensuction.twin.sensor import sensor
from opensuction.twin.sensor.sensor import Measured, Sensors, SensorState

DT_S = 0.001
LEARNING_TICKS = 2000
"""A vented line, or a head at home, before it counts."""
REST_TICKS = 5000
"""How long a line rests before its vacuum is built up again."""
PARK_MM = 0.0
READ = make_zero(Readings)._replace(
    head_valid=True, carriage_valid=True, cam_valid=True, vacuum_valid=True, contact_valid=True
)
CALM = make_zero(Measured)
"""Nothing is there to be measured."""
AT_HOME = head_vote.start(PARK_MM, read=True)


class Line(NamedTuple):
    """A line that keeps its vacuum, or loses a share of it every second while its pump rests."""

    vacuum_mmhg: float
    set_mmhg: float
    pumping: bool
    leak_per_s: float


@compiled
def count_line(
    limits: LineLimits, sensors: Sensors, line: Line, start: SensorState, ticks: int
) -> int:
    """How often something is wrong with a line; it begins vented."""
    state = start
    filtered, seen, count, wrong = (
        vacuum_signature.FILTER_START,
        vacuum_signature.START,
        0,
        False,
    )
    vacuum = 0.0
    for tick in range(ticks):
        learning = tick < LEARNING_TICKS
        if learning:
            vacuum = 0.0
        elif (tick - LEARNING_TICKS) % REST_TICKS == 0 or line.pumping:
            vacuum = line.vacuum_mmhg
        else:
            vacuum -= vacuum * line.leak_per_s * DT_S
        state = sensor.step(sensors, state, CALM._replace(vacuum_mmhg=vacuum), DT_S)
        readings = READ._replace(line_vacuum_mmhg=state.vacuum_mmhg)
        vented = learning or (line.set_mmhg == 0.0 and not line.pumping)
        filtered = vacuum_signature.step_filter(filtered, readings, vented, DT_S)
        if learning:
            continue
        if not line.pumping and (tick - LEARNING_TICKS) % REST_TICKS == 0:
            seen = vacuum_signature.START
        seen = vacuum_signature.step(
            limits,
            seen,
            vacuum_signature.vacuum_mmhg(filtered),
            line.set_mmhg,
            line.pumping,
            False,
            True,
            DT_S,
        )
        now = vacuum_signature.judge(limits, seen, False) != 0
        if now and not wrong:
            count += 1
        wrong = now
    return count


@compiled
def count_refusals(
    plan: CheckPlan, sensors: Sensors, item: int, line: Line, start: SensorState, tests: int
) -> int:
    """How many pre-use tests of so many fail at an item of the line."""
    failed, state = 0, start
    seen = CheckSeen(True, True, 0.0, 0.0, True, True)
    for _ in range(tests):
        filtered, vacuum = vacuum_signature.FILTER_START, 0.0
        for tick in range(LEARNING_TICKS + 200):
            vacuum = line.vacuum_mmhg if tick >= LEARNING_TICKS else 0.0
            state = sensor.step(sensors, state, CALM._replace(vacuum_mmhg=vacuum), DT_S)
            readings = READ._replace(line_vacuum_mmhg=state.vacuum_mmhg)
            filtered = vacuum_signature.step_filter(filtered, readings, tick < LEARNING_TICKS, DT_S)
        tested = check.UNTESTED._replace(item=item)
        while tested.item == item and tested.failed == 0:
            vacuum -= vacuum * line.leak_per_s * DT_S
            state = sensor.step(sensors, state, CALM._replace(vacuum_mmhg=vacuum), DT_S)
            readings = READ._replace(line_vacuum_mmhg=state.vacuum_mmhg)
            filtered = vacuum_signature.step_filter(filtered, readings, False, DT_S)
            taken = readings._replace(line_vacuum_mmhg=vacuum_signature.vacuum_mmhg(filtered))
            tested = check.step(plan, tested, taken, seen, DT_S)
        failed += 1 if tested.failed != 0 else 0
    return failed


@compiled
def count_cam(
    limits: ValveLimits, sensors: Sensors, cam_rad: float, start: SensorState, ticks: int
) -> int:
    """How often a cam that stands where it should is taken for one that does not follow."""
    truth = CALM._replace(cam_rad=cam_rad)
    state = start
    opened, axis, count, wrong = cam_rad > 0.25 * limits.open_rad, valve_axis.START, 0, False
    for _ in range(ticks):
        state = sensor.step(sensors, state, truth, DT_S)
        axis = valve_axis.step(limits, axis, opened, False, state.cam_rad, DT_S)
        now = valve_axis.is_stuck(limits, axis)
        if now and not wrong:
            count += 1
        wrong = now
    return count


class Head(NamedTuple):
    """A head that goes to and fro, with play between motor and head."""

    in_mm_per_s: float
    out_mm_per_s: float
    stroke_mm: float
    play_mm: float
    step_mm: float
    sucking: bool


@compiled
def count_head(
    limits: DriveLimits, sensors: Sensors, head: Head, start: SensorState, ticks: int
) -> int:
    """How often motor and catheter head are apart, or one is voted out; it begins at home."""
    motor_mm, carriage_mm, speed, inwards = PARK_MM, PARK_MM + 0.5 * head.play_mm, 0.0, True
    state = start
    vote, apart_s, count, wrong = AT_HOME, 0.0, 0, False
    limit_s = judgement.DISAGREE_SUCKING_S if head.sucking else judgement.DISAGREE_S
    share = DT_S / (head_watch.SPEED_WINDOW_S + DT_S)
    for tick in range(ticks):
        if tick > LEARNING_TICKS:
            motor_mm += DT_S * (head.in_mm_per_s if inwards else -head.out_mm_per_s)
            if motor_mm >= head.stroke_mm:
                inwards = False
            elif motor_mm <= 2.0:
                inwards = True
            half = 0.5 * head.play_mm
            carriage_mm = min(max(carriage_mm, motor_mm - half), motor_mm + half)
        truth = CALM._replace(
            head_mm=sensor.quantise(motor_mm, head.step_mm), carriage_mm=carriage_mm
        )
        state = sensor.step(sensors, state, truth, DT_S)
        readings = READ._replace(head_mm=state.head_mm, carriage_mm=state.carriage_mm)
        before = vote
        vote = head_vote.step(limits, vote, readings, False, 0.0, speed, apart_s > limit_s, DT_S)
        vote = head_vote.learn(vote, before, readings, PARK_MM, DT_S)
        speed += share * ((vote.head_mm - before.head_mm - vote.jumped_mm) / DT_S - speed)
        off = head_watch.is_disagreeing(readings, vote, invalid_ticks.NONE, head.sucking)
        apart_s = extend_duration(apart_s, off and tick > LEARNING_TICKS, DT_S)
        now = apart_s > limit_s or vote.encoder_out or vote.carriage_out
        if now and not wrong:
            count += 1
        wrong = now
    return count


class Pull(NamedTuple):
    """A drive that works against a force at a speed."""

    force_n: float
    mm_per_s: float
    amperes_per_n: float
    volts: float
    rest_n: float
    """What it works against at rest, where its current sensor's offset is learnt."""
    rest_v: float
    step_mm: float


@compiled
def count_pull(
    limits: DriveLimits, sensors: Sensors, pull: Pull, start: SensorState, ticks: int
) -> tuple[int, int]:
    """How often that is taken for a jam, and for more than the drive's own limit."""
    truth = CALM._replace(current_a=pull.force_n * pull.amperes_per_n)
    rest = CALM._replace(current_a=-pull.rest_n * pull.amperes_per_n)
    state = start
    force, speed, last_mm, motor_mm = drive_force.REST, 0.0, 0.0, 0.0
    jam_s, over_s, jams, overs, jam, over = 0.0, 0.0, 0, 0, False, False
    share = DT_S / (head_watch.SPEED_WINDOW_S + DT_S)
    for tick in range(ticks):
        learning = tick < LEARNING_TICKS
        volts = -pull.rest_v if learning else pull.volts
        if not learning:
            motor_mm += pull.mm_per_s * DT_S
        told = rest if learning else truth
        told = told._replace(head_mm=sensor.quantise(motor_mm, pull.step_mm))
        state = sensor.step(sensors, state, told, DT_S)
        gained = share * ((state.head_mm - last_mm) / DT_S - speed)
        force = drive_force.step(limits, force, state.current_a, volts, speed, gained, share, DT_S)
        speed += gained
        last_mm = state.head_mm
        settled = tick > 2 * LEARNING_TICKS
        jam_n = limits.jam_n + drive_force.unsure_n(force)
        jam_s = extend_duration(
            jam_s, settled and drive_force.is_above(force, force.resistance_n, jam_n), DT_S
        )
        over_s = extend_duration(
            over_s, settled and drive_force.is_above(force, force.force_n, limits.force_n), DT_S
        )
        if jam_s > judgement.JAM_S and not jam:
            jams += 1
        if over_s > judgement.OVERFORCE_S and not over:
            overs += 1
        jam, over = jam_s > judgement.JAM_S, over_s > judgement.OVERFORCE_S
    return jams, overs
