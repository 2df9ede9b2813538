"""A model of plays whose gain changes with the place, inverted under a reference known ahead.

The way is that of `preview`, and so are its goals; output, slope and inverse are those of a table
of plays with lines over them. So a Preisach model or a play readout drives a head as a
Prandtl-Ishlinskii model does, which is the same with one gain a play.
Source: [calc-preview].
"""

from typing import NamedTuple

from opensuction.control import preview, profile
from opensuction.control.exact_inverse import HeadState
from opensuction.control.head_path import HeadLimits
from opensuction.control.preview import REHEARSED_S, TOUCH_MM, Goal, RunIn
from opensuction.control.profile import Profile
from opensuction.hysteresis.bank import play_table, turning_point
from opensuction.hysteresis.bank.play_table import Table
from opensuction.kernel.compiled import compiled


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
        lag_mm=play_table.step_lag(table, state.lag_mm, head_mm - state.head_mm),
        plays_mm=turning_point.step(state.plays_mm, state.head_mm, head_mm),
    )


@compiled
def tip_mm(table: Table, state: HeadState) -> float:
    """Tip of a state."""
    positions = play_table.positions_mm(table, state.plays_mm, state.head_mm)
    return play_table.output_mm(table, positions, state.lag_mm)


@compiled
def step(table: Table, limits: HeadLimits, state: HeadState, goal: Goal, dt_s: float) -> HeadState:
    """Head on its way to a goal in one direction; when it turns back, as in `preview.step`."""
    head, lag, direction = state.head_mm, state.lag_mm, goal.direction
    velocity = 0.0
    if direction != 0.0:
        positions = play_table.positions_mm(table, state.plays_mm, head)
        missing_mm = goal.target_mm - play_table.output_mm(table, positions, lag)
        if preview.is_too_far(goal, missing_mm, state.head_mm_per_s):
            distance = play_table.inverse_step(table, positions, head, lag, goal.target_mm)
            direction = -direction if preview.is_followed(distance, missing_mm) else direction
        if missing_mm * direction >= 0.0:
            distance = play_table.inverse_step(table, positions, head, lag, goal.target_mm)
            further = distance
            if goal.target_mm_per_s != 0.0:
                ahead_mm = goal.target_mm + goal.target_mm_per_s * dt_s
                further = play_table.inverse_step(table, positions, head, lag, ahead_mm)
            ahead = preview.lead(distance, further, direction, dt_s)
        else:
            slope = play_table.advance_slope(table, positions, head, lag, direction)
            ahead = preview.wait(goal, missing_mm, slope)
        velocity = preview.pursue(limits, ahead, direction, state.head_mm_per_s, dt_s)
    return advance(table, state, head + velocity * dt_s, velocity)


@compiled
def at_rest(table: Table, tip_mm: float, direction: float) -> HeadState:
    """State of a head at rest after a long travel in a direction that ended with the tip there."""
    head = play_table.saturated_head_mm(table, tip_mm, direction)
    lag_mm = float(-direction * table[0, play_table.DECAY])
    return HeadState(head, 0.0, lag_mm, play_table.turns_after_travel(direction, head))


@compiled
def cross(table: Table, state: HeadState, beyond_mm: float) -> HeadState:
    """State once the gap is crossed and the tip has moved by ``beyond_mm``, signed."""
    positions = play_table.positions_mm(table, state.plays_mm, state.head_mm)
    here_mm = play_table.output_mm(table, positions, state.lag_mm)
    move_mm = play_table.inverse_step(
        table, positions, state.head_mm, state.lag_mm, here_mm + beyond_mm
    )
    return advance(table, state, state.head_mm + move_mm, 0.0)


@compiled
def rehearse(
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
        moved_mm, speed = profile.at(start.move, time_s)
        reference_mm = start.tip_mm + direction * (moved_mm - start.move.start_mm)
        goal = preview.aim_ahead(
            run_in, reference_mm, direction * speed, direction, max(-time_s, 0.0)
        )
        state = step(table, limits, state, goal, dt_s)
        error_mm = tip_mm(table, state) - reference_mm
        squares += error_mm * error_mm * dt_s
        if squares > most:
            break
    return squares
