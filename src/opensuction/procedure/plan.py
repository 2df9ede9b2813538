"""The plan of one run: a protocol fitted to machine and patient, in the form the tick needs."""

import math
from typing import NamedTuple

from opensuction.control.profile import Profile
from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import Phase


class Motion(NamedTuple):
    """How the tip moves."""

    target_mm: float
    insertion_mm_per_s: float
    withdrawal_mm_per_s: float
    abort_mm_per_s: float
    acceleration_mm_per_s2: float
    park_head_mm: float
    """Head position at which the machine is parked."""
    settle_mm: float
    """The head has arrived when it is this near to its command."""


class Excitation(NamedTuple):
    """Identification: the head follows half of (1 - cos), starting from rest."""

    range_mm: float
    period_s: float
    duration_s: float


class PhaseLimits(NamedTuple):
    """Longest durations, s; phases that wait for a person have none."""

    checking: float
    preloading: float
    inserting: float
    opening: float
    suctioning: float
    withdrawing: float
    closing: float
    aborting: float
    identifying: float


class Plan(NamedTuple):
    """What the procedure follows. Times are s, vacuum is mmHg."""

    motion: Motion
    excitation: Excitation
    preload_s: float
    """Time given to the head to take up the gap before insertion."""
    dwell_s: float
    """From the reference's arrival at the target to the start of the way back."""
    gap_lead_s: float
    """Last part of the dwell, in which the gap of the way back is crossed."""
    vacuum_mmhg: float
    cam_open_rad: float
    bench_only: bool
    """Nobody is on the machine: it may be identified."""
    limits_s: PhaseLimits


@compiled
def way_in(motion: Motion, start_mm: float) -> Profile:
    """Insertion from where the reference is."""
    return Profile(
        start_mm=start_mm,
        end_mm=motion.target_mm,
        speed_mm_per_s=motion.insertion_mm_per_s,
        acceleration_mm_per_s2=motion.acceleration_mm_per_s2,
    )


@compiled
def way_out(motion: Motion, start_mm: float, speed_mm_per_s: float) -> Profile:
    """Withdrawal to the parked reference."""
    return Profile(
        start_mm=start_mm,
        end_mm=0.0,
        speed_mm_per_s=speed_mm_per_s,
        acceleration_mm_per_s2=motion.acceleration_mm_per_s2,
    )


@compiled
def phase_limit_s(limits: PhaseLimits, phase: int) -> float:
    """Longest duration of a phase; infinite where a person is awaited."""
    if phase == Phase.CHECKING.value:
        return limits.checking
    if phase == Phase.PRELOADING.value:
        return limits.preloading
    if phase == Phase.INSERTING.value:
        return limits.inserting
    if phase == Phase.OPENING.value:
        return limits.opening
    if phase == Phase.SUCTIONING.value:
        return limits.suctioning
    if phase == Phase.WITHDRAWING.value:
        return limits.withdrawing
    if phase == Phase.CLOSING.value:
        return limits.closing
    if phase == Phase.ABORTING.value:
        return limits.aborting
    if phase == Phase.IDENTIFYING.value:
        return limits.identifying
    return math.inf
