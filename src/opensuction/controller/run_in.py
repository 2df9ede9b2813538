"""Run-in of the head: its lead over the reference at a start, rehearsed on its model beforehand."""

import math
from collections.abc import Callable

from opensuction.control import model_preview, preview
from opensuction.control.head_path import HeadLimits
from opensuction.control.model_preview import Start
from opensuction.control.preview import RunIn
from opensuction.control.profile import Profile
from opensuction.hysteresis import play_sum
from opensuction.hysteresis.bank.play_table import Table
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.procedure.cycle.plan import TUBE_END_MM

RUN_INS_S = tuple(0.01 * step for step in range(16))
"""Run-ins that are tried: the best of the machines here lie at 0.04 to 0.1 s."""
LIKELY_RUN_IN_S = 0.06
"""Where the search begins; the nearer to the best, the sooner the others are seen to be worse."""
LONG_RUN_INS_S = (*RUN_INS_S, *(0.05 * step for step in range(4, 31)))
"""Likewise of a model whose tip creeps along while a gap is crossed: then the crossing itself is
what begins early, and 25 mm take 1.5 s."""
REHEARSAL_TICK_S = 0.001
"""The control loop's own tick."""
REHEARSED_MM = 90.0
"""Length of the rehearsed move: longer than what its start needs."""


def _best_s(run_ins_s: tuple[float, ...], rehearse: Callable[[float, float], float]) -> float:
    """The one of some run-ins that leaves the smallest tip error at the start of a move.

    rehearse: the error of a run-in, s; carried to its end while it is below the second number.
    """
    best = (math.inf, 0.0)
    for run_in_s in sorted(run_ins_s, key=lambda run_in_s: abs(run_in_s - LIKELY_RUN_IN_S)):
        # A rehearsal ends as soon as it is worse than the best one before.
        best = min(best, (float(rehearse(run_in_s, best[0])), run_in_s))
    return best[1]


def find(
    model: PrandtlIshlinskii,
    table: Table | None,
    limits: HeadLimits,
    speeds_mm_per_s: tuple[float, float],
) -> RunIn:
    """The best run-ins inwards and outwards.

    table: of the model that drives; None: the plays do. speeds_mm_per_s: of the tip when it starts
    inwards and outwards. Where the gain changes with the place the start inwards is rehearsed at
    the tube's end, the one outwards deep inside. Raises InputError for too many plays.
    """
    inwards, outwards = (
        Profile(0.0, REHEARSED_MM, speed, limits.acceleration_mm_per_s2)
        for speed in speeds_mm_per_s
    )
    if table is not None:
        return RunIn(
            _of_table(table, limits, Start(TUBE_END_MM, 1.0, inwards)),
            _of_table(table, limits, Start(REHEARSED_MM, -1.0, outwards)),
        )
    plays = play_sum.bundle(model)
    return RunIn(*(_of_plays(plays, limits, move) for move in (inwards, outwards)))


def _of_plays(plays: play_sum.PlaySum, limits: HeadLimits, move: Profile) -> float:
    return _best_s(
        RUN_INS_S,
        lambda run_in_s, most: preview.rehearse(
            plays, limits, move, run_in_s, REHEARSAL_TICK_S, most
        ),
    )


def _of_table(table: Table, limits: HeadLimits, start: Start) -> float:
    return _best_s(
        LONG_RUN_INS_S,
        lambda run_in_s, most: model_preview.rehearse(
            table, limits, start, run_in_s, REHEARSAL_TICK_S, most
        ),
    )
