"""Compensation of the transmission by name: desired tip position in, head command out.

One record carries them all, chosen by ``kind``: a type for each would compile everything above
it once more.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from opensuction.control import backlash_inverse, motion_profile, preview
from opensuction.control.backlash_inverse import Curves, HeadState
from opensuction.control.motion_profile import HeadLimits
from opensuction.control.preview import RunIn
from opensuction.hysteresis import modified_dahl, play_sum, prandtl_ishlinskii
from opensuction.hysteresis.bank import play_lines, turning_point
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.play_sum import NO_PLAYS, PlaySum
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import by_name


class CompensationKind(IntEnum):
    """Compensators; the numbers are stored in recordings: never renumber."""

    NONE = 0
    """The head follows the reference (paper Fig. 7(a))."""
    DIRECT_INVERSE = 1
    """The paper's scheme as printed (Fig. 7(b), eqs. (7) and (8))."""
    EXACT_INVERSE = 2
    """The same model solved exactly; the gap is crossed while the tip stands still."""
    GAP_WIDTH = 3
    """One backlash width, added once the reference turns: a `Curves` of two parallel lines."""
    LOOKUP_TABLE = 4
    """Recorded curves, one for each direction, changed once the reference turns."""
    PRANDTL_ISHLINSKII = 5
    """Plays inverted exactly, without knowing what comes next."""
    PREVIEW = 6
    """The same with the reference known ahead: gap crossed before it moves, start prepared."""
    MODEL_PREVIEW = 7
    """Any model of plays with lines over them (Preisach, play readout), likewise known ahead."""


KIND_OF_NAME = by_name(CompensationKind)
"""Compensators by their name on the command line and in files."""

RUNS_IN = (CompensationKind.PREVIEW, CompensationKind.MODEL_PREVIEW)
"""Kinds whose head begins to move a moment before the reference does."""
LOOKS_AHEAD = (CompensationKind.EXACT_INVERSE, *RUNS_IN)
"""Kinds that cross the gap before the reference moves; the procedure plans the time for it."""
ON_PLAYS = (CompensationKind.PRANDTL_ISHLINSKII, CompensationKind.PREVIEW)
"""Kinds on the Prandtl-Ishlinskii model."""
ON_CURVES = (CompensationKind.GAP_WIDTH, CompensationKind.LOOKUP_TABLE)
"""Kinds on a curve for each direction."""
ON_TABLE = (*ON_CURVES, CompensationKind.MODEL_PREVIEW)
"""Kinds whose numbers go apart, as `Branches`."""
FED_FORWARD = (*LOOKS_AHEAD, CompensationKind.PRANDTL_ISHLINSKII)
"""Kinds whose servo gets velocity and friction feedforward; the others keep the paper's PD."""


Branches = Array
"""Of a kind on curves: heads inwards and outwards, shape (2, n). Of `MODEL_PREVIEW`: the
`play_table.Table` of its model. Any other kind has None, and then nothing of them is compiled.
Apart from the `Compensation`, for a reference to an array in a record is counted at every hand."""


class CurvesGrid(NamedTuple):
    """Depths of the entries of `Curves`."""

    first_mm: float
    spacing_mm: float


class Compensation(NamedTuple):
    """Compensator with its model and its limits."""

    kind: int
    limits: HeadLimits
    model: ModifiedDahl
    plays: PlaySum
    curves: CurvesGrid
    """Where the entries of the branches are; the heads there go apart: see `Branches`."""
    run_in: RunIn


class Rest(NamedTuple):
    """End of a long retract; the plays' positions follow from it."""

    head_mm: float
    lag_mm: float


def choose(
    kind: CompensationKind,
    limits: HeadLimits,
    model: ModifiedDahl,
    plays: PrandtlIshlinskii,
    curves: Curves,
    run_in: RunIn,
) -> Compensation:
    """A compensation of a kind; its `branches` go with it.

    curves: of the kind that uses them: parallel lines for `GAP_WIDTH`.
    Raises InputError for more plays than there is room for, where the kind is on them.
    """
    return Compensation(
        kind=int(kind),
        limits=limits,
        model=model,
        plays=play_sum.bundle(plays) if kind in ON_PLAYS else NO_PLAYS,
        curves=CurvesGrid(curves.first_mm, curves.spacing_mm),
        run_in=run_in,
    )


def branches(kind: CompensationKind, curves: Curves, lines: PlayLines) -> Branches | None:
    """The numbers that go with a compensation of a kind; see `choose`."""
    if kind in ON_CURVES:
        return np.array([curves.inwards_mm, curves.outwards_mm])
    if kind == CompensationKind.MODEL_PREVIEW:
        return play_lines.tabulate(lines)
    return None


@compiled
def curves_of(compensation: Compensation, heads_mm: Branches) -> Curves:
    """The curves of a kind that is on them."""
    grid = compensation.curves
    return Curves(grid.first_mm, grid.spacing_mm, heads_mm[0], heads_mm[1])


def head_after_travel_mm(
    compensation: Compensation, heads_mm: Branches | None, tip_mm: float, direction: float
) -> float:
    """Head with the tip at a depth that was reached by a long way in (+1.0) or out (-1.0)."""
    if compensation.kind in ON_PLAYS:
        plays = play_sum.unbundle(compensation.plays)
        return float(prandtl_ishlinskii.saturated_head_mm(plays, tip_mm, direction))
    if heads_mm is not None:
        if compensation.kind == CompensationKind.MODEL_PREVIEW:
            return float(play_lines.saturated_head_mm(heads_mm, tip_mm, direction))
        inner, outer = backlash_inverse.branches_mm(curves_of(compensation, heads_mm), tip_mm)
        return inner if direction > 0.0 else outer
    if compensation.kind == CompensationKind.NONE:
        return tip_mm
    model = compensation.model
    lag = direction * float(modified_dahl.saturation_mm(model))
    return (tip_mm + lag - model.offset_mm) / model.slope


def rest(compensation: Compensation, heads_mm: Branches | None, reference_mm: float) -> Rest:
    """Head and lag after a long retract that ended with the tip on ``reference_mm``."""
    head = head_after_travel_mm(compensation, heads_mm, reference_mm, -1.0)
    lag = float(modified_dahl.saturation_mm(compensation.model))
    if compensation.kind in ON_CURVES:
        lag = 0.5 * (head_after_travel_mm(compensation, heads_mm, reference_mm, 1.0) - head)
    elif heads_mm is not None:
        lag = float(heads_mm[0, play_lines.DECAY])
    return Rest(head_mm=head, lag_mm=lag)


def park(compensation: Compensation, at: Rest) -> HeadState:
    """State of a head at rest after a long retract."""
    state: HeadState = after_retract(compensation, at, at.head_mm, 0.0)
    return state


@compiled
def step(
    compensation: Compensation,
    heads_mm: Branches | None,
    state: HeadState,
    reference_mm: float,
    reference_mm_per_s: float,
    direction: float,
    starts_in_s: float,
    dt_s: float,
) -> HeadState:
    """Head command of one tick.

    heads_mm: the compensation's branches. reference_mm, reference_mm_per_s: desired tip motion
    (y_r). direction: +1.0 when the tip's next motion is towards the carina, -1.0 when it is back.
    starts_in_s: time until it begins, 0 while it lasts, below 0 where none is announced.
    """
    if compensation.kind == CompensationKind.EXACT_INVERSE:
        return backlash_inverse.step(
            compensation.model,
            compensation.limits,
            state,
            reference_mm,
            reference_mm_per_s,
            direction,
            dt_s,
        )
    if compensation.kind in ON_PLAYS:
        if compensation.kind == CompensationKind.PREVIEW:
            goal = preview.aim_ahead(
                compensation.run_in, reference_mm, reference_mm_per_s, direction, starts_in_s
            )
        else:
            goal = preview.aim_now(compensation.plays, state, reference_mm, reference_mm_per_s)
        return preview.step(compensation.plays, compensation.limits, state, goal, dt_s)
    if heads_mm is not None:
        return _by_table(
            compensation,
            heads_mm,
            state,
            reference_mm,
            reference_mm_per_s,
            direction,
            starts_in_s,
            dt_s,
        )
    return _follow_now(compensation, state, reference_mm, reference_mm_per_s, dt_s)


@compiled
def _by_table(
    compensation: Compensation,
    heads_mm: Branches,
    state: HeadState,
    reference_mm: float,
    reference_mm_per_s: float,
    direction: float,
    starts_in_s: float,
    dt_s: float,
) -> HeadState:
    """Head command of the kinds whose numbers go apart."""
    if compensation.kind == CompensationKind.MODEL_PREVIEW:
        goal = preview.aim_ahead(
            compensation.run_in, reference_mm, reference_mm_per_s, direction, starts_in_s
        )
        return preview.step_model(heads_mm, compensation.limits, state, goal, dt_s)
    return backlash_inverse.step_lookup_table(
        curves_of(compensation, heads_mm),
        compensation.limits,
        state,
        reference_mm,
        reference_mm_per_s,
        dt_s,
    )


@compiled
def _follow_now(
    compensation: Compensation,
    state: HeadState,
    reference_mm: float,
    reference_mm_per_s: float,
    dt_s: float,
) -> HeadState:
    """Head command of the kinds that know only where the reference is and goes now."""
    if compensation.kind == CompensationKind.DIRECT_INVERSE:
        return backlash_inverse.direct_step(compensation.model, state, reference_mm, dt_s)
    return state._replace(head_mm=reference_mm, head_mm_per_s=reference_mm_per_s)


@compiled
def after_retract(
    compensation: Compensation, at: Rest, head_mm: float, head_mm_per_s: float
) -> HeadState:
    """State with the memory of a long retract, the head being commanded to some position."""
    if compensation.kind == CompensationKind.MODEL_PREVIEW:
        turns = turning_point.after_retract(at.head_mm)
        return HeadState(head_mm, head_mm_per_s, at.lag_mm, turns)
    plays = play_sum.retracted_positions_mm(compensation.plays, at.head_mm)
    return HeadState(head_mm, head_mm_per_s, at.lag_mm, plays)


@compiled
def advance(
    compensation: Compensation,
    heads_mm: Branches | None,
    state: HeadState,
    head_mm: float,
    speed: float,
) -> HeadState:
    """State once the head has gone somewhere for another reason than the tip, at a speed, mm/s."""
    there = state._replace(head_mm=head_mm, head_mm_per_s=speed)
    if heads_mm is not None:
        if compensation.kind == CompensationKind.MODEL_PREVIEW:
            return preview.advance(heads_mm, state, head_mm, speed)
        return there
    if compensation.kind in ON_PLAYS:
        return there._replace(plays_mm=play_sum.step(compensation.plays, state.plays_mm, head_mm))
    move = head_mm - state.head_mm
    return there._replace(lag_mm=modified_dahl.step(compensation.model, state.lag_mm, move))


@compiled
def home(
    compensation: Compensation,
    heads_mm: Branches | None,
    state: HeadState,
    park_head_mm: float,
    speed_mm_per_s: float,
    dt_s: float,
) -> HeadState:
    """Head command of one tick on the way to its park position, whatever the tip does.

    speed_mm_per_s: no faster than this, nor than the compensation's limits.
    A head that was on its way elsewhere stops at once.
    """
    distance = park_head_mm - state.head_mm
    velocity = state.head_mm_per_s if state.head_mm_per_s * distance > 0.0 else 0.0
    limits = HeadLimits(
        speed_mm_per_s=min(speed_mm_per_s, compensation.limits.speed_mm_per_s),
        acceleration_mm_per_s2=compensation.limits.acceleration_mm_per_s2,
    )
    velocity = motion_profile.step(limits, distance, 0.0, velocity, dt_s)
    return advance(compensation, heads_mm, state, state.head_mm + velocity * dt_s, velocity)


@compiled
def loading_tip_mm(compensation: Compensation, parked_head_mm: float, reading_mm: float) -> float:
    """Tip that the model gives for a head pushed in to ``reading_mm`` from where it parks, mm.

    The loading branch after a retract: the gap is taken up on the way. Of every compensation,
    also of none, whose machine still has a nominal model. Source: [paper] eqs. (3) and (4).
    """
    model = compensation.model
    lag = modified_dahl.step(model, modified_dahl.saturation_mm(model), reading_mm - parked_head_mm)
    return modified_dahl.output_mm(model, reading_mm, lag)


@compiled
def at_contact(
    compensation: Compensation, heads_mm: Branches | None, at: Rest, reading_mm: float
) -> tuple[HeadState, float]:
    """State with the head stopped where it was measured, and the tip position this gives, mm.

    From rest to there the head went in all the way; its command may be further, where it was held.
    """
    begun = after_retract(compensation, at, at.head_mm, 0.0)
    there = advance(compensation, heads_mm, begun, reading_mm, 0.0)
    if compensation.kind in ON_CURVES and reading_mm > at.head_mm:
        there = there._replace(lag_mm=-at.lag_mm)
    tip = reading_mm
    if compensation.kind in ON_PLAYS:
        tip = play_sum.output_mm(compensation.plays, there.plays_mm, reading_mm)
    elif heads_mm is not None:
        tip = _tip_by_table(compensation, heads_mm, there)
    elif compensation.kind != CompensationKind.NONE:
        tip = modified_dahl.output_mm(compensation.model, reading_mm, there.lag_mm)
    return there, tip


@compiled
def _tip_by_table(compensation: Compensation, heads_mm: Branches, there: HeadState) -> float:
    """Tip of the kinds whose numbers go apart."""
    if compensation.kind == CompensationKind.MODEL_PREVIEW:
        return float(preview.tip_mm(heads_mm, there))
    curves, outwards = curves_of(compensation, heads_mm), there.lag_mm > 0.0
    return float(backlash_inverse.tip_mm(curves, there.head_mm, outwards))
