"""Clinical protocols: fitted to the patient and the machine, within the guidelines, or refused.

Depth comes from the patient's carina, time from the guideline's budget: whatever withdrawal and
valve leave of it is the dwell.
"""

from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.procedure.planning import planner
from opensuction.procedure.planning.guideline import (
    GUIDELINES,
    SOURCES,
    Guideline,
    GuidelineCheck,
    checks,
)
from opensuction.procedure.planning.planner import Abilities
from opensuction.procedure.planning.protocol import Protocol, Site

TIME_MARGIN_S = 0.4
"""Kept free of the budget: servos settle, and the valve's seal closes a little after the cam."""
FR_PER_MM = 3.0
"""Size of a catheter in Fr for each mm of its outer diameter [ISO-8836]."""
HIGH_PEEP_CMH2O = 10.0
"""From this on the lung is held open by it, and suction that takes it away closes units
[Maggiore-2003]."""
HIGH_PEEP_BUDGET_S = 10.0
"""Longest suction there: stiff lungs drawn at random lose up to 55 mL a second, and 11 mL/kg (620
mL in a person of 56 kg) are too much; 13 s came to 655 [in-silico]."""
TAUGHT_TOO_DEEP_MM = 4.0
"""By how much at most a hand teaches a carina deeper than it is [in-silico]."""
IN_AIRWAY_MARGIN_S = 3.0
"""Time in the airway over the plan that is a fault [design-airway]."""


class Template(NamedTuple):
    """A clinical protocol before it is fitted; `TEMPLATE_MEANINGS` says what each value is."""

    vacuum_mmhg: dict[AgeGroup, float]
    stop_short_mm: float
    window_mm: float
    backoff_mm: float
    cap_margin_mm: float
    insertion_mm_per_s: float
    withdrawal_mm_per_s: float
    nothing_comes_s: float


TEMPLATE_MEANINGS: dict[str, str] = {
    "vacuum_mmhg": "set point by age; an age that is missing is refused",
    "stop_short_mm": "approach by travel: distance from the carina at which the tip stops",
    "window_mm": "approach by contact: the carina may be this much nearer or farther than expected",
    "backoff_mm": "approach by contact: distance from the carina at which suction takes place",
    "cap_margin_mm": "the cap lies this much beyond the deepest stopping point",
    "insertion_mm_per_s": "speed inwards beyond the tube's end",
    "withdrawal_mm_per_s": "speed on the way out",
    "nothing_comes_s": "time without mucus that ends the dwell",
}

ADULT = Template(
    vacuum_mmhg={AgeGroup.ADULT: 120.0},
    stop_short_mm=13.0,
    window_mm=8.0,
    backoff_mm=10.0,
    cap_margin_mm=5.0,
    insertion_mm_per_s=10.0,
    withdrawal_mm_per_s=30.0,
    nothing_comes_s=0.75,
)
PAEDIATRIC = ADULT._replace(
    vacuum_mmhg={AgeGroup.CHILD: 100.0, AgeGroup.NEONATE: 80.0},
    stop_short_mm=10.0,
    window_mm=6.0,
    backoff_mm=8.0,
)

TEMPLATE_SOURCES: dict[str, str] = {
    "vacuum_mmhg": "[paper] II-A: adults 80 to 120, children 80 to 100; neonates [NTSP] 60 to 80",
    "stop_short_mm": "[ACI-2014] withdraw 1 to 2 cm before suction, and for adults the 2 to 3 mm "
    "that a hand teaches too deep [computed]; a child's trachea leaves no room for them",
    "window_mm": "[assumed] a tube's tip moves by some 20 mm with the neck [K]; taught with it at "
    "rest; children: 2 mm for the model and up to 4 that a hand teaches too deep [computed]",
    "backoff_mm": "[ACI-2014] as above; less in a short trachea [assumed]",
    "cap_margin_mm": "[design] the planner's least",
    "insertion_mm_per_s": "[paper] II-A: around 10",
    "withdrawal_mm_per_s": "[design] leaves most of the budget to the dwell",
    "nothing_comes_s": "[in-silico] docs/evidence/2026-11-23-suction-ends.md",
}
"""Where the values of the clinical protocols come from."""

TEMPLATES = {"adult": ADULT, "paediatric": PAEDIATRIC}
"""Clinical protocols by name."""


def suction_budget_s(site: Site) -> float:
    """Longest suction of a patient, by age and PEEP."""
    allowed = GUIDELINES[site.age].negative_pressure_s
    return min(allowed, HIGH_PEEP_BUDGET_S) if site.peep_cmh2o >= HIGH_PEEP_CMH2O else allowed


def _dwell_s(draft: Protocol, abilities: Abilities, site: Site, by_contact: bool) -> float:
    """Dwell that the budget leaves. Raises InputError if that is too little."""
    times = planner.timeline(draft, abilities, site, by_contact)
    budget = draft.negative_pressure_budget_s
    left = budget - times.withdrawal - times.stroke - TIME_MARGIN_S
    needed = times.stroke + planner.crossing_s(abilities, abilities.gap_out_mm)
    if left < needed:
        by_peep = budget < GUIDELINES[site.age].negative_pressure_s
        reason = f" (PEEP of {site.peep_cmh2o:g} cmH2O)" if by_peep else ""
        raise InputError(
            f"suction does not fit its budget: {budget:g} s{reason} - "
            f"withdrawal {times.withdrawal:.1f} s "
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
    check_catheter(site)
    guideline = GUIDELINES[site.age]
    if site.age not in template.vacuum_mmhg:
        names = ", ".join(age.name.lower() for age in template.vacuum_mmhg)
        raise InputError(f"this protocol is for {names}, the patient is {site.age.name.lower()}")
    travel = site.carina_mm + (template.window_mm if by_contact else -template.stop_short_mm)
    if travel <= 0.0:
        raise InputError(
            f"the tip would stop inside the tube: carina {site.carina_mm:.1f} mm below it - "
            f"{template.stop_short_mm:g} mm to stop short = {travel:.1f} mm"
        )
    draft = Protocol(
        travel_mm=travel,
        cap_mm=travel + template.cap_margin_mm,
        contact_from_mm=max(site.carina_mm - template.window_mm, 0.0) if by_contact else 0.0,
        backoff_mm=template.backoff_mm,
        insertion_mm_per_s=template.insertion_mm_per_s,
        withdrawal_mm_per_s=template.withdrawal_mm_per_s,
        dwell_s=0.0,
        nothing_comes_s=template.nothing_comes_s,
        vacuum_mmhg=template.vacuum_mmhg[site.age],
        negative_pressure_budget_s=suction_budget_s(site),
        in_airway_budget_s=guideline.in_airway_s,
        bench_only=False,
    )
    dwelling = draft._replace(dwell_s=_dwell_s(draft, abilities, site, by_contact))
    planned_s = planner.timeline(dwelling, abilities, site, by_contact).in_airway
    final = dwelling._replace(
        in_airway_budget_s=min(planned_s + IN_AIRWAY_MARGIN_S, guideline.in_airway_s)
    )
    enforce(held_against_guidelines(final, abilities, site, by_contact))
    check_relief(abilities, site)
    return final


def check_catheter(site: Site) -> None:
    """Refuse a catheter too wide for the tube; raises InputError with the arithmetic."""
    limit = GUIDELINES[site.age].catheter_ratio
    ratio = site.catheter_mm / site.tube_mm
    if ratio >= limit:
        raise InputError(
            f"catheter over tube diameter would be {ratio:.3g} = {site.catheter_mm:.3g} mm / "
            f"{site.tube_mm:g} mm, it should be below {limit:g}: use a catheter under "
            f"{limit * site.tube_mm:.3g} mm ({FR_PER_MM * limit * site.tube_mm:.3g} Fr) "
            f"({SOURCES['catheter_ratio']})"
        )


def check_relief(abilities: Abilities, site: Site) -> None:
    """Refuse a relief valve that opens later than the age's highest vacuum; raises InputError."""
    limit = GUIDELINES[site.age].vacuum_mmhg
    if abilities.relief_mmhg > limit:
        raise InputError(
            f"the relief valve opens at {abilities.relief_mmhg:g} mmHg, and for this patient "
            f"({site.age.name.lower()}) it must at {limit:g} mmHg or less, for pump or regulator "
            f"may fail: set relief_mmhg of twin and controller ({SOURCES['vacuum_mmhg']})"
        )


def check_depth(protocol: Protocol, site: Site, by_contact: bool) -> None:
    """Refuse depths of a protocol file that are not this patient's; raises InputError.

    The patient's depth is what was taught, ``site.carina_mm``: nobody knows where the carina is,
    and a hand teaches it too deep. By travel the tip and its cap stay above the carina all the
    same; by contact it lies in the window, and the cap may be beyond it by the window and the
    planner's margin.
    """
    taught_mm, nearest_mm = site.carina_mm, site.carina_mm - TAUGHT_TOO_DEEP_MM
    window_mm = (ADULT if site.age == AgeGroup.ADULT else PAEDIATRIC).window_mm
    beyond_mm = window_mm + planner.CAP_MARGIN_MM if by_contact else -TAUGHT_TOO_DEEP_MM
    most_mm = taught_mm + beyond_mm
    if protocol.cap_mm > most_mm:
        sign, why = ("+", "") if by_contact else ("-", ", by which a hand may teach too deep,")
        raise InputError(
            f"cap_mm {protocol.cap_mm:g} mm is too deep for this patient, whose taught length is "
            f"{taught_mm:.1f} mm {sign} {abs(beyond_mm):g}{why} = {most_mm:.1f} mm below the tube: "
            f"set cap_mm to at most {most_mm:.1f} mm and travel_mm to at most "
            f"{most_mm - planner.CAP_MARGIN_MM:.1f} mm"
        )
    if by_contact and protocol.contact_from_mm >= nearest_mm:
        raise InputError(
            f"contact_from_mm {protocol.contact_from_mm:g} mm is not above this patient's carina, "
            f"which may be at the taught length {taught_mm:.1f} mm - {TAUGHT_TOO_DEEP_MM:g} = "
            f"{nearest_mm:.1f} mm: touching it would be taken for a fault"
        )


def held_against_guidelines(
    protocol: Protocol, abilities: Abilities, site: Site, by_contact: bool
) -> list[GuidelineCheck]:
    """The clinical requirements of the paper's section II-A for a protocol, one by one."""
    times = planner.timeline(protocol, abilities, site, by_contact)
    return checks(
        site.age,
        Guideline(
            vacuum_mmhg=protocol.vacuum_mmhg,
            negative_pressure_s=times.negative_pressure,
            in_airway_s=times.in_airway,
            catheter_ratio=site.catheter_mm / site.tube_mm,
            speed_mm_per_s=protocol.insertion_mm_per_s,
        ),
    )


def sentence(check: GuidelineCheck) -> str:
    """Sentence on a requirement that is not met, with the numbers."""
    word = "below" if check.strict else "at most"
    return (
        f"{check.name} would be {check.value:.3g} {check.unit}".rstrip()
        + f", it should be {word} {check.limit:g} {check.unit}".rstrip()
    )


def enforce(found: list[GuidelineCheck]) -> None:
    """Refuse the first requirement that is not met; raises InputError with the numbers."""
    for check in found:
        if not check.ok:
            raise InputError(f"{sentence(check)} ({check.source})")
