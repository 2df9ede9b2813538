"""A machine at a patient's bed, with people at its buttons."""

from functools import cache

from opensuction.control.compensation import CompensationKind
from opensuction.controller import setup
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning import clinical
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import Loop, LoopState
from opensuction.simulation.trace import Columns, phase_spans

EXACT = CompensationKind.EXACT_INVERSE
PROTOCOLS = {
    "adult-icu": clinical.ADULT,
    "child-10kg": clinical.PAEDIATRIC,
    "neonate": clinical.PAEDIATRIC,
}


@cache
def at_bed(patient: str) -> tuple[Loop, LoopState]:
    """The nominal clinical machine at a patient, parked."""
    rig = rigs.rig("clinical", 1, nominal=True, patient=patient)
    calibration = rigs.uncalibrated(rig.profile)
    able = setup.abilities(rig.profile, EXACT, calibration, rig.site)
    protocol = clinical.fitted(PROTOCOLS[patient], able, rig.site, by_contact=False)
    return rigs.assemble(rig, protocol, EXACT, calibration, run=2)


def hurried(rest_s: float) -> tuple[Loop, LoopState]:
    """A neonate who rests between two passes for less time than any should, s."""
    loop, state = at_bed("neonate")
    settings = loop.controller
    passes = settings.service.passes._replace(rest_s=rest_s)
    service = settings.service._replace(passes=passes)
    return loop._replace(controller=settings._replace(service=service)), state


def starts_s(columns: Columns) -> list[float]:
    """When cycles began."""
    return [span.start_s for span in phase_spans(columns) if span.phase == Phase.CHECKING]


def count(columns: Columns, phase: Phase) -> int:
    """How often a phase was entered."""
    return sum(span.phase == phase for span in phase_spans(columns))
