"""The runs of a hazard: fault, instant, strength, seed; how each is prepared and run."""

from functools import lru_cache

from opensuction.evidence.safety_case import hazard, hazard_result
from opensuction.evidence.safety_case.hazard import Hazard
from opensuction.evidence.safety_case.hazard_result import HazardCase, HazardResult
from opensuction.kernel.errors import InputError
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.simulation.injection.injection import Injected
from opensuction.twin.fault.fault import FaultSite
from opensuction.twin.fault.fault_table import ROWS

COMPENSATION = "exact-inverse"
"""The command's own."""
MONITORED_S = 30.0
"""How long a patient at fault is followed: a saturation is shown 10 to 30 s late."""


def cases(one: Hazard, seeds: tuple[int, ...]) -> list[HazardCase]:
    """Every run of a hazard."""
    found = []
    for claim in one.claims:
        strengths = claim.strengths or [ROWS[claim.fault].default_strength]
        for phase in hazard.phases_of(claim):
            after = [0.0] if phase is None else claim.after_s
            found += [
                HazardCase(one.row.id, claim, strength, phase, after_s, seed)
                for strength in strengths
                for after_s in after
                for seed in seeds
            ]
    return found


def _written(case: HazardCase) -> str:
    """The fault of a set-up as a person writes it."""
    known = ROWS[case.claim.fault].strength
    return case.claim.name if known is None else f"{case.claim.name}={case.strength!r}"


@lru_cache(maxsize=4)
def _prepared(approach: str, patient: str, seed: int, set_up: tuple[str, ...]) -> Prepared:
    """A cycle ready to run; raises InputError where it is refused."""
    rig = RigChoice(patient=patient, seed=seed)
    choice = CycleChoice(rig, approach=approach, compensation=COMPENSATION, faults=set_up)
    return cycle_run.prepare(resolution.resolve(choice))


def run(case: HazardCase) -> HazardResult:
    """Run a case and hold it against its claim."""
    claim = case.claim
    at = AT_START if case.phase is None else FaultInstant(case.phase, case.after_s)
    one = Injection(claim.fault, at, case.strength)
    planned = (_written(case),) if ROWS[claim.fault].is_planned else ()
    try:
        prepared = _prepared(claim.approach, claim.patient, case.seed, planned)
    except InputError as refusal:
        return hazard_result.refused(case, str(refusal))
    later = () if planned else (one,)
    patient = claim.fault.site == FaultSite.PATIENT
    after_s = MONITORED_S if patient else injection.AFTERMATH_S
    done = injection.run(prepared.loop, prepared.start, later, after_s=after_s, seed=case.seed)
    found = done.faults[0] if later else Injected(one, 0.0, None)
    return hazard_result.judge(case, prepared, done.columns, found)
