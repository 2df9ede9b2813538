"""Flow of the suction line with a free catheter, against which the procedure detects mucus."""

import math

from opensuction.controller.governor_limit import WALLS_MM, bore_ml_per_s_per_root
from opensuction.controller.machine_profile import MachineProfile
from opensuction.kernel.constant import ATMOSPHERE_MMHG, ML_PER_S
from opensuction.procedure.suction.line_flow import SAMPLE_S, FreeFlow

REST_FREE_SHARE = 0.8
"""Share of a free catheter's flow from which only gas comes, seen while the pump rests. Mucus takes
.6 of the tip (assumed) and leaves .4; a canister half full makes .8 of that."""
CRITICAL_ML_PER_S_PER_MM = 27.1
"""Flow at the critical Reynolds number of 2,300 for each mm of bore [computed]: a thin bore has no
less at `THIN_MMHG`, for below it flow is laminar and meets less resistance."""
THIN_MMHG = 100.0
"""[computed] A bore of 1.5 mm is between laminar and turbulent there."""
NOISE_MMHG = 2.0
"""White noise of the vacuum sensor at `SAMPLE_S`; assumed."""
FLOW_ERROR = 0.1
"""Standard deviation that this noise may leave in the flow, as share of a free catheter's: half of
the way to where it is told from mucus."""
LEAST_WINDOW_S = 0.1
"""Shortest time over which the flow is measured beside a running pump; assumed."""


def _window_s(fall_mmhg_per_s: float) -> float:
    """Time in which a line fitted to the noise leaves that much of a fall.

    The slope of a line through n readings deviates by sqrt(12 / n) / T times what they do.
    """
    spread = math.sqrt(12.0 * SAMPLE_S) * NOISE_MMHG
    return float((spread / (FLOW_ERROR * fall_mmhg_per_s)) ** (2.0 / 3.0))


def free_flow(
    profile: MachineProfile, catheter_mm: float, vacuum_mmhg: float, at_rest: bool
) -> FreeFlow:
    """As the profile has the line, for a catheter of that outer diameter and a set point.

    at_rest: the pump rests with the valve open (`LineLimits.rests_open`). Beside a running pump the
    line is at its set point while mucus comes: what the pump takes out there bounds the flow.
    """
    pump = profile.pump_l_per_min * ML_PER_S
    per_mmhg = pump / profile.pump_occluded_mmhg
    thin = CRITICAL_ML_PER_S_PER_MM * (catheter_mm - WALLS_MM) / math.sqrt(THIN_MMHG)
    per_root = max(bore_ml_per_s_per_root(catheter_mm), thin)
    drawn = per_root * math.sqrt(vacuum_mmhg)
    canister = profile.canister_ml / ATMOSPHERE_MMHG
    window_s, free_share = _window_s(drawn / canister), REST_FREE_SHARE
    if not at_rest:
        window_s = max(window_s, LEAST_WINDOW_S)
        free_share = 0.5 * (1.0 + (pump - per_mmhg * vacuum_mmhg) / drawn)
    return FreeFlow(
        window_s=window_s,
        pump_ml_per_s=pump,
        pump_ml_per_s_per_mmhg=per_mmhg,
        bore_ml_per_s_per_root_mmhg=per_root,
        canister_ml_per_mmhg=canister,
        free_share=free_share,
        at_rest=at_rest,
    )
