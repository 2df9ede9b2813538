"""Clinical protocols: fitted to the patient and the machine, within the guidelines, or refused.

Depth comes from the patient's carina, time from the guideline's budget: whatever withdrawal and
valve leave of it is the dwell.
"""

from typing import NamedTuple

from opensuction.kernel.age_group import AgeGroup
from opensuction.kernel.errors import InputError
from opensuction.procedure import planner
from opensuction.procedure.guideline import GUIDELINES, Check, Planned, checks
from opensuction.procedure.planner import Abilities
from opensuction.procedure.protocol import Protocol
from opensuction.procedure.site import Site

TIME_MARGIN_S = 0.4
"""Kept free of the budget: servos settle, and the valve's seal closes a little after the cam."""
IN_AIRWAY_MARGIN_S = 3.0
"""Time in the airway over the plan that is a fault (DESIGN section 5)."""


class Template(NamedTuple):
    """A clinical protocol before it is fitted."""

    vacuum_mmhg: dict[AgeGroup, float]
    """Set point by age; an age that is missing is refused."""
    stop_short_mm: float
    """Travel approach: distance from the carina at which the tip stops."""
    window_mm: float
    """Contact approach: the carina may be this much nearer or farther than expected."""
    backoff_mm: float
    cap_margin_mm: float
    insertion_mm_per_s: float
    withdrawal_mm_per_s: float


ADULT = Template(
    vacuum_mmhg={AgeGroup.ADULT: 120.0},  # paper, section II-A: 80 to 120
    stop_short_mm=10.0,  # ACI: withdraw 1 to 2 cm before suction
    window_mm=8.0,  # a tube's tip moves by some 20 mm with the neck [K]; taught with it at rest
    backoff_mm=10.0,  # ACI, as above
    cap_margin_mm=5.0,  # the planner's least
    insertion_mm_per_s=10.0,  # paper, section II-A
    withdrawal_mm_per_s=30.0,  # DESIGN section 5
)
PAEDIATRIC = ADULT._replace(
    vacuum_mmhg={AgeGroup.CHILD: 100.0, AgeGroup.NEONATE: 80.0},  # paper 80-100; NTSP 60-80
    window_mm=6.0,  # 2 mm for the model, and up to 4 that a hand teaches too deep [computed]
    backoff_mm=8.0,
)

TEMPLATES = {"adult": ADULT, "paediatric": PAEDIATRIC}
"""Clinical protocols by name."""


def _dwell_s(draft: Protocol, abilities: Abilities, site: Site, by_contact: bool) -> float:
    """What the budget leaves for the dwell. Raises InputError if that is too little."""
    times = planner.timeline(draft, abilities, site, by_contact)
    budget = draft.negative_pressure_budget_s
    left = budget - times.withdrawal - times.stroke - TIME_MARGIN_S
    needed = times.stroke + planner.crossing_s(abilities, abilities.gap_out_mm)
    if left < needed:
        raise InputError(
            f"suction does not fit its budget: {budget:g} s - withdrawal {times.withdrawal:.1f} s "
            f"- valve closing {times.stroke:.1f} s - margin {TIME_MARGIN_S:g} s leave "
            f"{left:.1f} s of dwell, and valve opening {times.stroke:.1f} s and the gap of the way "
            f"back {needed - times.stroke:.1f} s need {needed:.1f} s: use a faster valve or "
            "withdrawal"
        )
    return left


def fitted(template: Template, abilities: Abilities, site: Site, by_contact: bool) -> Protocol:
    """The protocol for this patient on this machine.

    Raises InputError where age, budget or a guideline forbids it, with the arithmetic.
    """
    guideline = GUIDELINES[site.age]
    if site.age not in template.vacuum_mmhg:
        names = ", ".join(age.name.lower() for age in template.vacuum_mmhg)
        raise InputError(f"this protocol is for {names}, the patient is {site.age.name.lower()}")
    travel = site.carina_mm + (template.window_mm if by_contact else -template.stop_short_mm)
    draft = Protocol(
        travel_mm=travel,
        cap_mm=travel + template.cap_margin_mm,
        contact_from_mm=max(site.carina_mm - template.window_mm, 0.0) if by_contact else 0.0,
        backoff_mm=template.backoff_mm,
        insertion_mm_per_s=template.insertion_mm_per_s,
        withdrawal_mm_per_s=template.withdrawal_mm_per_s,
        dwell_s=0.0,
        vacuum_mmhg=template.vacuum_mmhg[site.age],
        negative_pressure_budget_s=guideline.negative_pressure_s,
        in_airway_budget_s=guideline.in_airway_s,
        bench_only=False,
    )
    dwelling = draft._replace(dwell_s=_dwell_s(draft, abilities, site, by_contact))
    planned_s = planner.timeline(dwelling, abilities, site, by_contact).in_airway
    final = dwelling._replace(
        in_airway_budget_s=min(planned_s + IN_AIRWAY_MARGIN_S, guideline.in_airway_s)
    )
    enforce(held_against_guidelines(final, abilities, site, by_contact))
    return final


def held_against_guidelines(
    protocol: Protocol, abilities: Abilities, site: Site, by_contact: bool
) -> list[Check]:
    """The clinical requirements of the paper's section II-A for a protocol, one by one."""
    times = planner.timeline(protocol, abilities, site, by_contact)
    return checks(
        site.age,
        Planned(
            vacuum_mmhg=protocol.vacuum_mmhg,
            negative_pressure_s=times.negative_pressure,
            in_airway_s=times.in_airway,
            catheter_mm=site.catheter_mm,
            tube_mm=site.tube_mm,
            speed_mm_per_s=protocol.insertion_mm_per_s,
        ),
    )


def enforce(found: list[Check]) -> None:
    """Refuse the first requirement that is not met; raises InputError with the numbers."""
    for check in found:
        if not check.ok:
            word = "below" if check.strict else "at most"
            raise InputError(
                f"{check.name} would be {check.value:.3g} {check.unit}".rstrip()
                + f", it should be {word} {check.limit:g} {check.unit}".rstrip()
                + f" ({check.source})"
            )
