"""Fig. 5 of the paper and what its published parameters imply: the inverse that is none.

With c < 2 beta the smoothed backlash runs the wrong way after each reversal. Everything here is
computed from the paper's numbers; no twin takes part.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control import backlash_inverse, motion_profile
from opensuction.control.backlash_inverse import AT_REST, HeadState
from opensuction.control.motion_profile import Profile
from opensuction.evidence.paper.claim import ARITHMETIC, COMPUTED, PaperClaim
from opensuction.hysteresis import modified_dahl, play
from opensuction.hysteresis.modified_dahl import (
    PUBLISHED,
    ModifiedDahl,
    reversal_slope,
    saturation_mm,
)
from opensuction.kernel.compiled import compiled
from opensuction.report.sheet import Curve, Plot, Section
from opensuction.simulation.closed_loop import DT_S

STEP_MM = 0.001
"""Head step with which the reversal is walked."""
STROKE_MM = 100.0
"""Of the plotted loop: the paper's excitation."""
TRAVEL_MM, SPEED_MM_PER_S, DWELL_S = 90.0, 9.0, 9.0
"""The paper's trapezoid, section IV-B."""
QUICK_MM_PER_S2 = 1e6
"""The paper's reference has corners: it reaches its speed within a tick."""

Values = npt.NDArray[np.float64]


class Reversal(NamedTuple):
    """Reversal of the published model after saturation; distances in mm, all positive."""

    wrong_way_mm: float
    """How far the tip first moves against the head."""
    at_head_mm: float
    """Head travel at which it is farthest."""
    regained_mm: float
    """Head travel after which the tip is back where it turned."""
    head_mm: Values
    tip_mm: Values


def reversal() -> Reversal:
    """Walk the published model from saturation through a reversal, away from the carina."""
    head = np.arange(0.0, 30.0, STEP_MM)
    advanced = -saturation_mm(PUBLISHED)
    tip = modified_dahl.simulate(PUBLISHED, -head, advanced)
    moved = tip - tip[0]
    farthest = int(np.argmax(moved))
    back = farthest + int(np.argmax(moved[farthest:] <= 0.0))
    return Reversal(
        float(moved[farthest]), float(head[farthest]), float(head[back]), head, tip - tip[0]
    )


@cache
def trapezoid_mm() -> tuple[Values, Values]:
    """Time and desired tip position of the paper's cycle, at the controller's ticks; to read."""
    way_in = Profile(0.0, TRAVEL_MM, SPEED_MM_PER_S, QUICK_MM_PER_S2)
    way_out = Profile(TRAVEL_MM, 0.0, SPEED_MM_PER_S, QUICK_MM_PER_S2)
    travel_s = TRAVEL_MM / SPEED_MM_PER_S
    time_s = np.arange(0.0, 2.0 * travel_s + DWELL_S, DT_S)
    turn_s = travel_s + DWELL_S
    reference = np.array(
        [
            motion_profile.at(way_in, t)[0]
            if t < turn_s
            else motion_profile.at(way_out, t - turn_s)[0]
            for t in time_s
        ]
    )
    for shared in (time_s, reference):
        shared.setflags(write=False)
    return time_s, reference


def printed_commands(
    reference_mm: Values, model: ModifiedDahl = PUBLISHED
) -> tuple[Values, Values]:
    """Head command (u_FF) and estimated lag of the printed scheme along a reference, mm.

    The lag starts saturated by a preceding retract, the head at u(0).
    """
    rows = _printed_rows(model, reference_mm, AT_REST)
    return rows[:, 0], rows[:, 1]


@compiled
def _printed_rows(model: ModifiedDahl, reference_mm: Values, state: HeadState) -> Values:
    """Head command and lag, shape (n, 2). state: what else a head remembers."""
    lag = saturation_mm(model)
    head = (reference_mm[0] - lag - model.offset_mm) / model.slope
    state = state._replace(head_mm=head, lag_mm=lag)
    rows = np.empty((reference_mm.size, 2))
    for i in range(reference_mm.size):
        state = backlash_inverse.direct_step(model, state, reference_mm[i], DT_S)
        rows[i, 0] = state.head_mm
        rows[i, 1] = state.lag_mm
    return rows


def claims(found: Reversal, jump_mm: float) -> list[PaperClaim]:
    """Facts that follow from the published parameters. jump_mm: largest command in one tick.

    The paper prints none of them: both sides are computed from its parameters, on two ways.
    """
    near = "tolerance: rounding of what was computed by hand"
    slope, half_width_mm = (float(figure(PUBLISHED)) for figure in (reversal_slope, saturation_mm))
    rows = (
        ("slope right after a reversal, c - 2 beta", -0.740, slope, 0.001, "mm/mm"),
        ("tip moves the wrong way after a reversal", 2.47, found.wrong_way_mm, 0.01, "mm"),
        ("head travel to the farthest wrong point", 7.38, found.at_head_mm, 0.01, "mm"),
        ("head travel until the tip is back", 16.48, found.regained_mm, 0.02, "mm"),
        ("jump of the printed compensator in 1 ms", 2.62, jump_mm, 0.05, "mm"),
        ("half-width of the loop, beta / alpha", 11.09, half_width_mm, 0.01, "mm"),
    )
    return [
        PaperClaim(
            name,
            "parameters of section III-B",
            COMPUTED,
            ARITHMETIC,
            paper,
            ours,
            math.nan,
            tolerance,
            unit,
            (),
            near,
        )
        for name, paper, ours, tolerance, unit in rows
    ]


def _loop() -> Plot:
    head = 0.5 * STROKE_MM * (1.0 - np.cos(np.linspace(0.0, 4.0 * np.pi, 8001)))
    smooth = modified_dahl.simulate(PUBLISHED, head, saturation_mm(PUBLISHED))
    gap = float(modified_dahl.gap_mm(PUBLISHED)) / PUBLISHED.slope
    sharp = np.empty_like(head)
    output = head[0] + 0.5 * gap
    for i, value in enumerate(head.tolist()):
        output = play.step(gap, output, value)
        sharp[i] = PUBLISHED.slope * output + PUBLISHED.offset_mm
    kept = head.size // 2
    return Plot(
        "Fig. 5: backlash and its smooth form",
        "Head x (mm)",
        "Tip y (mm)",
        (
            Curve("backlash of the same width", sharp[kept:], "soft", True, head[kept:]),
            Curve("modified Dahl, published parameters", smooth[kept:], "tip", False, head[kept:]),
        ),
        caption="Second of two strokes. Where the head turns, the smooth form first goes the "
        "wrong way: its corners overshoot.",
    )


def section() -> tuple[Section, list[PaperClaim]]:
    """Fig. 5 and Fig. 7 on one page section, with the claims that belong to them."""
    found = reversal()
    time_s, reference = trapezoid_mm()
    head, lag = printed_commands(reference)
    jump = float(np.max(np.abs(np.diff(head))))
    plots = (
        _loop(),
        Plot(
            "After a reversal the model goes the wrong way",
            "Head travel since the reversal (mm)",
            "Tip (mm)",
            (Curve("tip, published parameters", found.tip_mm),),
            found.head_mm,
            f"{found.wrong_way_mm:.2f} mm the wrong way; back only after "
            f"{found.regained_mm:.2f} mm. Between the two no command exists that lets the tip "
            "follow a reference which simply turns round.",
        ),
        Plot(
            "Fig. 7(c): command and estimated lag of the printed scheme",
            "Time (s)",
            "mm",
            (
                Curve("desired tip y_r", reference, "reference", True),
                Curve("command u_FF", head, "head"),
                Curve("estimated lag z", lag, "tip-vacuum"),
            ),
            time_s,
            f"Where the reference turns, the command jumps by {jump:.2f} mm within 1 ms "
            f"({jump:.1f} m/s): no drive can follow, and the governor would not let it.",
        ),
    )
    text = (
        "Eqs. (3) and (4) with the published parameters have c - 2 beta = "
        f"{reversal_slope(PUBLISHED):.3f}: right after a reversal the modelled tip moves against "
        "the head. Eqs. (7) and (8) then have no continuous solution. The scheme is kept runnable "
        "as printed (one tick of delay in its loop) so that Table I can be reproduced; the product "
        "solves the inverse exactly and crosses the reversal as a gap.",
    )
    return Section("Backlash model and its inverse (Fig. 5, Fig. 7)", text, plots=plots), claims(
        found, jump
    )
