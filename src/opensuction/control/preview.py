"""The Prandtl-Ishlinskii model inverted under a reference that is known ahead, or is not.

With preview the procedure says in which direction the tip will move next and when. The head then
crosses the gap while the tip stands still, stops where the first play is about to engage, and
begins its run-in a moment before the reference does: over the rounded corner of the loop the tip
follows slowly at first, and the head, bounded in speed and acceleration, could not catch up.
Without preview the gap is crossed once the reference has turned.
Source: [calc-preview].

A model of plays whose gain changes with the place, inverted under a reference known ahead.

The way is that of `preview`, and so are its goals; output, slope and inverse are those of a table
of plays with lines over them. So a Preisach model or a play readout drives a head as a
Prandtl-Ishlinskii model does, which is the same with one gain a play.
Source: [calc-preview].
"""

from typing import NamedTuple

from opensuction.control import motion_profile
from opensuction.control.backlash_inverse import STEEPEST, HeadState
from opensuction.control.motion_profile import HeadLimits, Profile
from opensuction.hysteresis import play_sum
from opensuction.hysteresis.bank import play_lines, turning_point
from opensuction.hysteresis.bank.play_lines import Table
from opensuction.hysteresis.play_sum import PlaySum
from opensuction.kernel.compiled import compiled

TOUCH_MM = 0.05
"""Tip motion by which the gap counts as crossed: half of the laser's noise."""
EARLY_MM = 0.5
"""Furthest the modelled tip may move ahead of a reference that is about to start."""
STILL_MM = 0.02
"""Error at which a head that follows a standing reference lets it be: a few encoder steps."""
FOLLOWED = 3.0
"""[design] The tip comes with the head at once where the head's way to a target is at most so many
times the tip's; across a gap it is tens of times as far."""
REHEARSED_S = 2.0
"""How long after the reference's start a run-in is judged."""


class RunIn(NamedTuple):
    """Time by which the head begins to move before the reference, s."""

    inwards_s: float
    outwards_s: float


@compiled
def is_followed(distance_mm: float, missing_mm: float) -> bool:
    """True where moving the tip by what is missing costs no gap. distance_mm: the head's way."""
    return 0.0 < abs(distance_mm) <= FOLLOWED * abs(missing_mm)


class Goal(NamedTuple):
    """Goal of the modelled tip, and the direction in which it comes there."""

    target_mm: float
    target_mm_per_s: float
    direction: float
    """+1.0 towards the carina, -1.0 back, 0.0: the head stays where it is."""


@compiled
def aim_now(
    model: PlaySum, state: HeadState, reference_mm: float, reference_mm_per_s: float
) -> Goal:
    """The goal of a tick that knows only where the reference is and goes now."""
    direction = 0.0
    if reference_mm_per_s != 0.0:
        direction = 1.0 if reference_mm_per_s > 0.0 else -1.0
    else:
        missing_mm = reference_mm - play_sum.output_mm(model, state.plays_mm, state.head_mm)
        distance = play_sum.inverse_step(model, state.plays_mm, state.head_mm, reference_mm)
        if abs(missing_mm) > STILL_MM or is_followed(distance, missing_mm):
            direction = 1.0 if missing_mm > 0.0 else -1.0
    return Goal(reference_mm, reference_mm_per_s, direction)


@compiled
def aim_ahead(
    run_in: RunIn,
    reference_mm: float,
    reference_mm_per_s: float,
    direction: float,
    starts_in_s: float,
) -> Goal:
    """The goal of a tick under a reference that is known ahead.

    direction: of the tip's next motion, +1.0 towards the carina, -1.0 back. starts_in_s: time until
    it begins, 0 while it lasts, below 0 where none is announced.
    """
    target_mm = reference_mm
    if reference_mm_per_s == 0.0 and starts_in_s > 0.0:
        run_in_s = run_in.inwards_s if direction > 0.0 else run_in.outwards_s
        early_mm = EARLY_MM if starts_in_s <= run_in_s else TOUCH_MM
        target_mm += direction * early_mm
    return Goal(target_mm, reference_mm_per_s, direction)


class Ahead(NamedTuple):
    """Way of the head to a goal, by a model."""

    distance_mm: float
    """Head travel to the target; where the tip is beyond it, by how much the head is early."""
    follow_mm_per_s: float
    """Velocity with which the head follows a target that moves, once it is there."""


@compiled
def lead(distance_mm: float, further_mm: float, direction: float, dt_s: float) -> Ahead:
    """The way to a target that lies ahead. further_mm: to where it will be a tick later."""
    # At rest where the next instant lies across the gap.
    follow_mm_per_s = (further_mm - distance_mm) / dt_s
    if follow_mm_per_s * direction < 0.0:
        follow_mm_per_s = 0.0
    return Ahead(distance_mm, follow_mm_per_s)


@compiled
def wait(goal: Goal, missing_mm: float, slope: float) -> Ahead:
    """The target is behind: let it catch up, by the distance the head is early.

    missing_mm: tip that is missing, signed. slope: of the tip, where the head moves on.
    """
    per_tip = min(1.0 / slope, STEEPEST) if slope > 0.0 else STEEPEST
    return Ahead(missing_mm * per_tip, goal.target_mm_per_s * per_tip)


@compiled
def is_too_far(goal: Goal, missing_mm: float, head_mm_per_s: float) -> bool:
    """True where a head at rest has brought the tip beyond a target that stands."""
    return (
        goal.target_mm_per_s == 0.0
        and missing_mm * goal.direction < 0.0
        and head_mm_per_s * goal.direction <= 0.0
    )


@compiled
def pursue(
    limits: HeadLimits, ahead: Ahead, direction: float, head_mm_per_s: float, dt_s: float
) -> float:
    """Velocity of a head that goes in one direction or not at all."""
    velocity = motion_profile.step(
        limits, ahead.distance_mm, ahead.follow_mm_per_s, head_mm_per_s, dt_s
    )
    if velocity * direction < 0.0:
        velocity = 0.0  # turning back would open the gap again
    return velocity


@compiled
def step(
    model: PlaySum, limits: HeadLimits, state: HeadState, goal: Goal, dt_s: float
) -> HeadState:
    """Head on its way to a goal in one direction.

    It does not move against it but waits, for that would open the gap again: but where it came to
    rest too far, and the tip comes back with it at once.
    """
    plays, head, direction = state.plays_mm, state.head_mm, goal.direction
    velocity = 0.0
    if direction != 0.0:
        missing_mm = goal.target_mm - play_sum.output_mm(model, plays, head)
        if is_too_far(goal, missing_mm, state.head_mm_per_s):
            distance = play_sum.inverse_step(model, plays, head, goal.target_mm)
            direction = -direction if is_followed(distance, missing_mm) else direction
        if missing_mm * direction >= 0.0:
            distance = play_sum.inverse_step(model, plays, head, goal.target_mm)
            further = distance
            if goal.target_mm_per_s != 0.0:
                ahead_mm = goal.target_mm + goal.target_mm_per_s * dt_s
                further = play_sum.inverse_step(model, plays, head, ahead_mm)
            ahead = lead(distance, further, direction, dt_s)
        else:
            slope = play_sum.advance_slope(model, plays, head, direction)
            ahead = wait(goal, missing_mm, slope)
        velocity = pursue(limits, ahead, direction, state.head_mm_per_s, dt_s)
    head = head + velocity * dt_s
    return state._replace(
        head_mm=head, head_mm_per_s=velocity, plays_mm=play_sum.step(model, plays, head)
    )


@compiled
def rehearse(
    model: PlaySum,
    limits: HeadLimits,
    move: Profile,
    run_in_s: float,
    dt_s: float,
    most: float,
) -> float:
    """Sum of squared tip errors, mm2 s, of a start from rest after a long retract.

    move: the reference, inwards. The head has crossed the gap and begins ``run_in_s`` early.
    most: above it the sum is not carried to its end; infinite for all of it.
    """
    plays = play_sum.retracted_positions_mm(model, 0.0)
    start_mm = play_sum.output_mm(model, plays, 0.0)
    travel = play_sum.inverse_step(model, plays, 0.0, start_mm + TOUCH_MM)
    state = HeadState(travel, 0.0, 0.0, play_sum.step(model, plays, travel))
    squares = 0.0
    for tick in range(int((run_in_s + REHEARSED_S) / dt_s)):
        time_s = tick * dt_s - run_in_s
        moved_mm, velocity = motion_profile.at(move, time_s)
        reference_mm = start_mm + moved_mm - move.start_mm
        goal = aim_ahead(RunIn(run_in_s, run_in_s), reference_mm, velocity, 1.0, max(-time_s, 0.0))
        state = step(model, limits, state, goal, dt_s)
        tip = play_sum.output_mm(model, state.plays_mm, state.head_mm)
        error_mm = tip - start_mm - moved_mm + move.start_mm
        squares += error_mm * error_mm * dt_s
        if squares > most:
            break
    return squares


class Start(NamedTuple):
    """A start that is rehearsed: at rest, after a long travel the other way."""

    tip_mm: float
    direction: float
    """Of the motion that begins."""
    move: Profile
    """How far the tip goes, and how fast; inwards, whatever the direction."""


@compiled
def advance(table: Table, state: HeadState, head_mm: float, head_mm_per_s: float) -> HeadState:
    """State once the head has gone somewhere in one monotone move, at a speed, mm/s."""
    return HeadState(
        head_mm=head_mm,
        head_mm_per_s=head_mm_per_s,
        lag_mm=play_lines.step_lag(table, state.lag_mm, head_mm - state.head_mm),
        plays_mm=turning_point.step(state.plays_mm, state.head_mm, head_mm),
    )


@compiled
def tip_mm(table: Table, state: HeadState) -> float:
    """Tip of a state."""
    positions = play_lines.positions_mm(table, state.plays_mm, state.head_mm)
    return play_lines.output_mm(table, positions, state.lag_mm)


@compiled
def step_model(
    table: Table, limits: HeadLimits, state: HeadState, goal: Goal, dt_s: float
) -> HeadState:
    """Head on its way to a goal in one direction; when it turns back, as in `preview.step`."""
    head, lag, direction = state.head_mm, state.lag_mm, goal.direction
    velocity = 0.0
    if direction != 0.0:
        positions = play_lines.positions_mm(table, state.plays_mm, head)
        missing_mm = goal.target_mm - play_lines.output_mm(table, positions, lag)
        if is_too_far(goal, missing_mm, state.head_mm_per_s):
            distance = play_lines.inverse_step(table, positions, head, lag, goal.target_mm)
            direction = -direction if is_followed(distance, missing_mm) else direction
        if missing_mm * direction >= 0.0:
            distance = play_lines.inverse_step(table, positions, head, lag, goal.target_mm)
            further = distance
            if goal.target_mm_per_s != 0.0:
                ahead_mm = goal.target_mm + goal.target_mm_per_s * dt_s
                further = play_lines.inverse_step(table, positions, head, lag, ahead_mm)
            ahead = lead(distance, further, direction, dt_s)
        else:
            slope = play_lines.advance_slope(table, positions, head, lag, direction)
            ahead = wait(goal, missing_mm, slope)
        velocity = pursue(limits, ahead, direction, state.head_mm_per_s, dt_s)
    return advance(table, state, head + velocity * dt_s, velocity)


@compiled
def at_rest(table: Table, tip_mm: float, direction: float) -> HeadState:
    """State of a head at rest after a long travel in a direction that ended with the tip there."""
    head = play_lines.saturated_head_mm(table, tip_mm, direction)
    lag_mm = float(-direction * table[0, play_lines.DECAY])
    return HeadState(head, 0.0, lag_mm, play_lines.turns_after_travel(direction, head))


@compiled
def cross(table: Table, state: HeadState, beyond_mm: float) -> HeadState:
    """State once the gap is crossed and the tip has moved by ``beyond_mm``, signed."""
    positions = play_lines.positions_mm(table, state.plays_mm, state.head_mm)
    here_mm = play_lines.output_mm(table, positions, state.lag_mm)
    move_mm = play_lines.inverse_step(
        table, positions, state.head_mm, state.lag_mm, here_mm + beyond_mm
    )
    return advance(table, state, state.head_mm + move_mm, 0.0)


@compiled
def rehearse_model(
    table: Table, limits: HeadLimits, start: Start, run_in_s: float, dt_s: float, most: float
) -> float:
    """Sum of squared tip errors, mm2 s, of a start from rest: as `preview.rehearse`.

    The head has crossed the gap and begins ``run_in_s`` early. most: above it the sum is not
    carried to its end; infinite for all of it.
    """
    direction = start.direction
    rest = at_rest(table, start.tip_mm, -direction)
    state = cross(table, rest, direction * TOUCH_MM)
    run_in, squares = RunIn(run_in_s, run_in_s), 0.0
    for tick in range(int((run_in_s + REHEARSED_S) / dt_s)):
        time_s = tick * dt_s - run_in_s
        moved_mm, speed = motion_profile.at(start.move, time_s)
        reference_mm = start.tip_mm + direction * (moved_mm - start.move.start_mm)
        goal = aim_ahead(run_in, reference_mm, direction * speed, direction, max(-time_s, 0.0))
        state = step_model(table, limits, state, goal, dt_s)
        error_mm = tip_mm(table, state) - reference_mm
        squares += error_mm * error_mm * dt_s
        if squares > most:
            break
    return squares
