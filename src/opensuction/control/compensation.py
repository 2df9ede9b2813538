"""Compensation of the transmission by name: desired tip position in, head command out.

One record carries them all, chosen by ``kind``: a type for each would compile everything above
it once more.
"""

from enum import IntEnum
from typing import NamedTuple

from opensuction.control import direct_inverse, exact_inverse, head_path
from opensuction.control.direct_inverse import EstimatedLag
from opensuction.control.exact_inverse import HeadState
from opensuction.control.head_path import HeadLimits
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.kernel.compiled import compiled


class CompensationKind(IntEnum):
    """Compensators; the numbers are stored in recordings: never renumber."""

    NONE = 0
    """The head follows the reference (paper Fig. 7(a))."""
    DIRECT_INVERSE = 1
    """The paper's scheme as printed (Fig. 7(b), eqs. (7) and (8))."""
    EXACT_INVERSE = 2
    """The same model solved exactly; the gap is crossed while the tip stands still."""


KIND_OF_NAME = {
    "none": CompensationKind.NONE,
    "direct-inverse": CompensationKind.DIRECT_INVERSE,
    "exact-inverse": CompensationKind.EXACT_INVERSE,
}


class Compensation(NamedTuple):
    """Which compensator, on which model, within which limits."""

    kind: int
    model: ModifiedDahl
    limits: HeadLimits


def parked(compensation: Compensation, reference_mm: float) -> HeadState:
    """State after a long retract that ended with the tip on ``reference_mm``."""
    lag = float(modified_dahl.saturation_mm(compensation.model))
    head = reference_mm
    if compensation.kind != CompensationKind.NONE:
        head = (reference_mm - lag - compensation.model.offset_mm) / compensation.model.slope
    return HeadState(head_mm=head, head_mm_per_s=0.0, lag_mm=lag)


@compiled
def step(
    compensation: Compensation,
    state: HeadState,
    reference_mm: float,
    reference_mm_per_s: float,
    direction: float,
    dt_s: float,
) -> HeadState:
    """Head command of one tick.

    reference_mm, reference_mm_per_s: desired tip motion (y_r). direction: +1.0 when the tip's
    next motion is towards the carina, -1.0 when it is back.
    """
    if compensation.kind == CompensationKind.EXACT_INVERSE.value:
        return exact_inverse.step(
            compensation.model,
            compensation.limits,
            state,
            reference_mm,
            reference_mm_per_s,
            direction,
            dt_s,
        )
    if compensation.kind == CompensationKind.DIRECT_INVERSE.value:
        printed = direct_inverse.step(
            compensation.model, EstimatedLag(state.head_mm, state.lag_mm), reference_mm
        )
        velocity = (printed.head_mm - state.head_mm) / dt_s
        return HeadState(printed.head_mm, velocity, printed.lag_mm)
    return HeadState(reference_mm, reference_mm_per_s, state.lag_mm)


@compiled
def home(
    compensation: Compensation,
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
    velocity = head_path.step(limits, distance, 0.0, velocity, dt_s)
    move = velocity * dt_s
    return HeadState(
        head_mm=state.head_mm + move,
        head_mm_per_s=velocity,
        lag_mm=modified_dahl.step(compensation.model, state.lag_mm, move),
    )


@compiled
def pushed_mm(compensation: Compensation, parked_head_mm: float, reading_mm: float) -> float:
    """Tip that the model gives for a head pushed in to ``reading_mm`` from where it parks, mm.

    The loading branch after a retract: the gap is taken up on the way. Of every compensation,
    also of none, whose machine still has a nominal model. Source: paper.txt eqs. (3) and (4).
    """
    model = compensation.model
    lag = modified_dahl.step(model, modified_dahl.saturation_mm(model), reading_mm - parked_head_mm)
    return modified_dahl.output_mm(model, reading_mm, lag)


@compiled
def stopped(
    compensation: Compensation, state: HeadState, reading_mm: float
) -> tuple[HeadState, float]:
    """State with the head stopped where it was measured, and the tip position this gives, mm."""
    move = reading_mm - state.head_mm
    lag = modified_dahl.step(compensation.model, state.lag_mm, move)
    tip = reading_mm
    if compensation.kind != CompensationKind.NONE.value:
        tip = modified_dahl.output_mm(compensation.model, reading_mm, lag)
    return HeadState(reading_mm, 0.0, lag), tip
