"""Under which limits a person teaches the travel length, and which lengths are plausible."""

import math

from opensuction.kernel.age_group import AgeGroup
from opensuction.kernel.errors import InputError
from opensuction.procedure.cycle.teaching import PLAUSIBLE
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.procedure.planning.protocol import Protocol

SEARCH_MARGIN_MM = 10.0
"""Beyond the plausible depth at which the governor takes the catheter out of the hand; assumed."""
IDLE_VACUUM_MMHG = 80.0
"""Set point of the plan that teaching runs under; the pump stays off."""
IDLE_DWELL_S = 2.0
"""Dwell of the plan that teaching runs under; no cycle is started with it."""


def protocol(age: AgeGroup, vacuum_mmhg: float) -> Protocol:
    """Limits under which a person teaches: the plausible range is the cap, no cycle is planned.

    vacuum_mmhg: any the machine can hold; the pump stays off.
    """
    guideline = GUIDELINES[age]
    most_mm = PLAUSIBLE[age].most_mm
    return Protocol(
        travel_mm=most_mm,
        cap_mm=most_mm + SEARCH_MARGIN_MM,
        insertion_mm_per_s=guideline.speed_mm_per_s,
        withdrawal_mm_per_s=guideline.speed_mm_per_s,
        contact_from_mm=0.0,
        backoff_mm=0.0,
        dwell_s=IDLE_DWELL_S,
        nothing_comes_s=0.0,
        vacuum_mmhg=vacuum_mmhg,
        negative_pressure_budget_s=60.0,  # the valve stays closed
        in_airway_budget_s=60.0,  # of the plan; the governor's limit is the guideline's
        bench_only=False,
    )


def check_plausible(age: AgeGroup, taught_mm: float, what: str) -> None:
    """Refuse a length that no such patient has. Raises InputError with the arithmetic.

    what: names the length in the message.
    """
    least, most = PLAUSIBLE[age]
    if least <= taught_mm <= most:
        return
    if not math.isfinite(taught_mm):
        raise InputError(
            f"{what} {taught_mm:g} mm is no length: measure from the tube's lower end to the "
            f"carina, {least:g} to {most:g} mm"
        )
    beyond = least - taught_mm if taught_mm < least else taught_mm - most
    where = "short of the least" if taught_mm < least else "beyond the most"
    limit = least if taught_mm < least else most
    raise InputError(
        f"{what} {taught_mm:g} mm is {beyond:.3g} mm {where} plausible for {age.name.lower()}, "
        f"{limit:g} mm: measure again from the tube's lower end to the carina, {least:g} to "
        f"{most:g} mm"
    )
