"""Protocols by name: what a cycle shall do, before it is fitted to machine and patient."""

from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Le


class Protocol(NamedTuple):
    """What a person sets. Each value of a preset carries its source beside it."""

    travel_mm: Annotated[float, Gt(0), Le(130)]
    """Tip travel from the lower end of the tube to the stopping point."""
    cap_mm: Annotated[float, Gt(0), Le(140)]
    """Deepest tip position ever allowed; at least 5 mm beyond the travel."""
    insertion_mm_per_s: Annotated[float, Gt(0), Le(30)]
    withdrawal_mm_per_s: Annotated[float, Gt(0), Le(60)]
    contact_from_mm: Annotated[float, Ge(0), Le(130)]
    """Contact approach: contact at a lesser depth is a fault; the search ends at ``travel_mm``."""
    backoff_mm: Annotated[float, Ge(0), Le(30)]
    """Contact approach: distance from the carina at which suction takes place."""
    dwell_s: Annotated[float, Ge(0), Le(30)]
    """From arrival at the stopping point to the start of withdrawal, valve stroke included."""
    vacuum_mmhg: Annotated[float, Ge(20), Le(150)]
    negative_pressure_budget_s: Annotated[float, Gt(0), Le(60)]
    """Longest time from the valve's leaving its seat to its return."""
    in_airway_budget_s: Annotated[float, Gt(0), Le(60)]
    bench_only: bool
    """Breaks a guideline's limit on purpose: never for a patient."""


PAPER = Protocol(
    travel_mm=90.0,  # paper, section IV-B
    cap_mm=95.0,  # 5 mm beyond: the least margin the planner accepts
    insertion_mm_per_s=9.0,  # paper, section IV-B
    withdrawal_mm_per_s=9.0,  # paper, section IV-A: same velocity back
    contact_from_mm=30.0,  # the paper's shortest distance is 45
    backoff_mm=0.0,  # paper: suction where the tip stopped
    dwell_s=9.0,  # paper, Fig. 9
    vacuum_mmhg=120.0,  # paper, section II-A: 80 to 120 for adults
    negative_pressure_budget_s=24.0,  # 9 s dwell + 10 s withdrawal + 2 s stroke = 21 s, and 3 s
    in_airway_budget_s=35.0,  # 10 + 9 + 10 s, and 6 s
    bench_only=True,  # guidelines ask for at most 15 s of negative pressure
)
"""The paper's cycle. Its 21 s of negative pressure exceed every guideline's 15 s."""

PROTOCOLS = {"paper": PAPER}
"""Protocols by name."""
