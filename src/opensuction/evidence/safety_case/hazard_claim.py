"""A row of the hazard table: what can go wrong, the faults that show it, what must then happen.

How a table is read is `hazard`; what runs of it, `hazard_case`.

Risk of a hazard before and after its controls: severity and probability of the harm.

The words are those of [ISO-14971]; levels, matrix and every estimate are this project's own
judgement, for no machine is in the field. `docs/safety/risk.md` shows them.
"""

from enum import Enum
from typing import Annotated, NamedTuple, TypeVar

from annotated_types import Ge, Le

from opensuction.evidence.campaign.sound_machine import AIRWAY, Shows
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import CYCLE
from opensuction.safety.condition import Condition
from opensuction.safety.handling import Priority
from opensuction.session.cycle.resolution import APPROACHES
from opensuction.twin.fault.fault import BY_NAME, Fault
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES

Level = TypeVar("Level", bound=Enum)


class HarmSeverity(Enum):
    """Severity of a harm, least first."""

    NEGLIGIBLE = "negligible"
    MINOR = "minor"
    SERIOUS = "serious"
    CRITICAL = "critical"


SEVERITY_WORDS = {
    HarmSeverity.NEGLIGIBLE: "inconvenience; nothing to treat",
    HarmSeverity.MINOR: "passes by itself, or is put right by the next suctioning",
    HarmSeverity.SERIOUS: "injury that must be treated, or a longer stay",
    HarmSeverity.CRITICAL: "death, or injury that stays, where nobody helps in time",
}


class HarmProbability(Enum):
    """Probability of a harm in a cycle, least first."""

    IMPROBABLE = "improbable"
    REMOTE = "remote"
    OCCASIONAL = "occasional"
    PROBABLE = "probable"
    FREQUENT = "frequent"


PROBABILITY_WORDS = {
    HarmProbability.IMPROBABLE: "less than 1 in 1,000,000 cycles",
    HarmProbability.REMOTE: "1 in 1,000,000 to 1 in 100,000",
    HarmProbability.OCCASIONAL: "1 in 100,000 to 1 in 10,000",
    HarmProbability.PROBABLE: "1 in 10,000 to 1 in 1,000",
    HarmProbability.FREQUENT: "more than 1 in 1,000",
}


class Acceptability(Enum):
    """Acceptability of a risk."""

    ACCEPTABLE = "acceptable"
    REDUCE = "reduce"
    """To be reduced as far as it can be, and weighed against the benefit."""
    UNACCEPTABLE = "unacceptable"


_A, _R, _U = Acceptability.ACCEPTABLE, Acceptability.REDUCE, Acceptability.UNACCEPTABLE
MATRIX = {
    severity: dict(zip(HarmProbability, row, strict=True))
    for severity, row in {
        HarmSeverity.NEGLIGIBLE: (_A, _A, _A, _A, _R),
        HarmSeverity.MINOR: (_A, _A, _A, _R, _U),
        HarmSeverity.SERIOUS: (_A, _R, _R, _U, _U),
        HarmSeverity.CRITICAL: (_R, _R, _U, _U, _U),
    }.items()
}
"""Acceptability by severity, then by probability."""


class RiskEstimate(NamedTuple):
    """Estimate of a hazard's risk beyond its severity; in the table, the section ``risk``."""

    probability: HarmProbability
    """Of the harm of the row's severity, with the machine of [paper]: no governor, watch or
    alarm."""
    residual_severity: HarmSeverity
    """Of the harm that is left with the row's controls."""
    residual_probability: HarmProbability
    because: str
    """Why the controls change it so far and no further."""


def rank(level: Enum) -> int:
    """Place of a level among those of its kind, 0 for the least."""
    return list(type(level)).index(level)


def check(severity: HarmSeverity, risk: RiskEstimate) -> None:
    """Raises InputError where controls make it worse, change nothing, or say nothing."""
    if not risk.because.strip():
        raise InputError("because: is empty; say why the controls change it so far")
    before, after = (
        (severity, risk.probability),
        (
            risk.residual_severity,
            risk.residual_probability,
        ),
    )
    for name, old, new in zip(
        ("residual_severity", "residual_probability"), before, after, strict=True
    ):
        if rank(new) > rank(old):
            raise InputError(
                f"{name}: '{new.value}' is above '{old.value}' before the controls; no control "
                "may make it worse"
            )
    if before == after:
        raise InputError(
            f"residual_probability: '{risk.residual_probability.value}' as before, and no less "
            "severe; controls that change nothing are none"
        )


SET_UP = "set-up"
"""Phase of faults that are there before the start."""
ALL = "all"
CONTACT = tuple(phase.name.lower() for phase in CYCLE)
PHASES = {"travel": tuple(name for name in CONTACT if name != "backing_off"), "contact": CONTACT}
"""Phases of a cycle in order, by approach: where a fault can come."""
SPANS = (AIRWAY, ALL, SET_UP)
"""What phases can name besides."""
PATIENTS = tuple(PATIENT_TABLES)
MOST_MS = 60_000.0
"""A later alarm or safe state is none: a run is watched for so long after it has come to rest, and
no patient of the table has longer (adult: 30 s, [calc-apnoea])."""


UNHEARD = frozenset(
    {
        Condition.PATIENT_SETTINGS_UNCONFIRMED,
        Condition.CALIBRATION_OUT_OF_RANGE,
        Condition.RECORDER_LOST,
        Condition.CONSOLE_LOST,
    }
)
"""Conditions that nothing in a cycle on the twin raises: an alarm that nobody can hear is none."""


class SafeState(NamedTuple):
    """A safe state in words, and what must hold together, to the end of the run."""

    words: str
    predicates: tuple[str, ...]
    """Names of `safe_state` predicates; all hold."""


SAFE_STATES = {
    "out-without-suction": SafeState(
        "the tip is outside the patient and no vacuum reaches it", ("tip-outside", "no-suction")
    ),
    "out-without-vacuum": SafeState(
        "the tip is outside the patient and the line is vented",
        ("tip-outside", "no-suction", "vented"),
    ),
    "not-inserted": SafeState("the tip never comes into the patient", ("not-inserted",)),
}
"""By name. A catheter that stays inside is none of them, with or without torque."""


class Response(Enum):
    """Required response to a fault."""

    ALARM = "alarm"
    """Alarm and safe state within their bounds."""
    ALARM_OR_LIMITS = "alarm-or-limits"
    """The same, or a whole cycle within every limit as if nothing were wrong."""
    ALARM_LIMITS_OR_REFUSAL = "alarm-limits-or-refusal"
    """Any of them, or the cycle is refused before anything moves."""
    NOT_MEASURED = "not-measured"
    """It would be an alarm, but nothing in the twin could raise it: an open gap, and it fails."""
    REFUSAL = "refusal"
    """It is refused before anything moves; a message on the spot, no alarm."""


class Raiser(Enum):
    """Source of an alarm."""

    CONTROLLER = "controller"
    DRIVES = "drives"
    """The drives, their watchdog or the power supply, on the annunciator: the controller is what
    failed."""


REFUSES = (Response.REFUSAL, Response.ALARM_LIMITS_OR_REFUSAL)
"""Where a refusal before the start answers a fault."""
NEEDS_NO_ALARM = (Response.ALARM_OR_LIMITS, Response.ALARM_LIMITS_OR_REFUSAL)
"""Where a whole cycle within every limit does."""

BoundMs = Annotated[float, Ge(0), Le(MOST_MS)]


class HazardClaim(NamedTuple):
    """A fault and what must follow it: the part of a row that runs."""

    name: str
    """Of the fault."""
    strengths: list[float]
    """None given: the fault's usual one."""
    phases: list[str]
    after_s: list[float]
    """How long into the phase; none given: all over it, each seed at another share of it."""
    shows: Shows
    approach: str
    """Or all."""
    patient: str | list[str]
    """Or all."""
    only_because: str
    """Why it does not apply to the others."""
    response: Response
    alarm: list[str]
    """Conditions of which any tells a person what is wrong, the most likely first."""
    priority: Priority
    raised_by: Raiser
    safe_state: str
    detected_ms: BoundMs
    safe_ms: BoundMs
    by_age: bool
    """Whether a smaller patient has less time; what waits for a sensor's own delay does not."""
    allowed: list[str]
    """Bounds of the patient to which is added what the fault makes unavoidable."""
    because: str

    @property
    def fault(self) -> Fault:
        """The fault of this name."""
        return BY_NAME[self.name]

    @property
    def approaches(self) -> tuple[str, ...]:
        """Approaches that it is run with."""
        return tuple(APPROACHES) if self.approach == ALL else (self.approach,)

    @property
    def patients(self) -> tuple[str, ...]:
        """Patients that it is run on."""
        named = [self.patient] if isinstance(self.patient, str) else self.patient
        return PATIENTS if ALL in named else tuple(named)


class HazardRow(NamedTuple):
    """A row of the table in words."""

    id: str
    hazard: str
    cause: str
    effect: str
    severity: HarmSeverity
    detection: str
    control: str
    requirements: list[str]


class Hazard(NamedTuple):
    """A hazard and the faults that show it."""

    row: HazardRow
    claims: tuple[HazardClaim, ...]
    risk: RiskEstimate | None = None
    """None where its table does not estimate it."""


def spans_of(claim: HazardClaim, approach: str) -> list[str]:
    """Phases of an approach, or `SPANS`, that the fault comes in."""
    if ALL in claim.phases:
        return [*PHASES[approach]]
    return [name for name in claim.phases if name in (*PHASES[approach], *SPANS)]
