"""Cycles of a trial written down by hand."""

from opensuction.evidence.trial.judged_cycle import Came, Case
from opensuction.oracle.harm import Harm
from opensuction.result.trial_result import Endpoints
from opensuction.simulation.injection.invariant import Breach
from opensuction.simulation.injection.run_judgement import LeftInside
from opensuction.twin.fault.fault import Fault

BREACH = Breach("a bound", 1.25, 2.5, 0.5)
HARM = Harm("force", 0.4, 0.3, "N")
STAYS = LeftInside("it is held fast", "Draw it out.", 0.5, in_time=True)
ENDPOINTS = Endpoints(1.5, 75.0, 95.0, 120.0, 22.0, 12.0, 0.1)


def came(*faults: Fault) -> tuple[Came, ...]:
    return tuple(Came(fault, 0.0, 5.0, counts=True) for fault in faults)


def case(number: int, *faults: Fault) -> Case:
    """A cycle in which these faults came and nothing was broken."""
    return Case(
        number=number,
        patient="adult-icu",
        approach="travel",
        seed=1_000_000,
        faults=came(*faults),
        completed=not faults,
        told=False,
        false_alarms=(),
        true_alarms=(),
        commands=(),
        breaches=(),
        unavoidable=(),
        left_inside=None,
        endpoints=ENDPOINTS,
        watched_s=10.0,
    )
