"""One automated cycle on the twin, from named choices to a trace."""

from collections.abc import Callable
from time import perf_counter
from typing import NamedTuple

import numpy as np

from opensuction.control.compensation import CompensationKind
from opensuction.controller import setup
from opensuction.controller.setup import Calibration
from opensuction.evidence import compensation_choice
from opensuction.kernel.errors import InputError
from opensuction.kernel.requests import NO_REQUESTS, START
from opensuction.procedure import clinical
from opensuction.procedure.clinical import TEMPLATES, Template
from opensuction.procedure.guideline import Check
from opensuction.procedure.protocol import PROTOCOLS, Protocol
from opensuction.settings.choice import choose
from opensuction.settings.identification_file import Identified
from opensuction.settings.toml_file import load_toml
from opensuction.settings.validation import validate
from opensuction.simulation import bench, closed_loop, trace
from opensuction.simulation.bench import Identification, Rig
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.outcome import Outcome, outcome
from opensuction.simulation.trace import Columns
from opensuction.twin.patient_parameter import TABLES

APPROACHES = {"travel": False, "contact": True}
"""Ways to find the stopping point, and whether it is the contact switch that does."""
CONTACT_CARINA_MM = 65.0
"""Distance at which the bench's rubber carina stands for the contact approach (paper, Table II)."""
CYCLE_RUN = 2
"""Number of the noise stream of cycles; identification has another."""
LIMIT_S = 180.0
"""No cycle lasts longer: every phase has a limit of its own."""
AFTERMATH_S = 90.0
"""How long a patient is followed after the cycle."""
PIECE_S = 0.05
"""Simulated time between two reports of progress."""


class Choice(NamedTuple):
    """What a person chose, as names."""

    machine: str | None
    """None: the bench for a protocol that is for the bench only, else the clinical machine."""
    protocol: str
    """Name of a preset or path of a TOML file."""
    approach: str
    compensation: str
    """Name of a compensator, or path of a parameter file that names one and holds its model."""
    seed: int
    patient: str = bench.DEFAULT_PATIENT
    """Who lies at a clinical machine; the bench has nobody."""


class Prepared(NamedTuple):
    """A cycle ready to run."""

    choice: Choice
    rig: Rig
    protocol: Protocol
    kind: CompensationKind
    calibration: Calibration
    """What the compensation works with: identified before use, from a file, or nominal."""
    identification: Identification | None
    """None where the compensation needs none, or has its model from a file."""
    parameter_file: Identified | None
    """The file that the compensation has its model from."""
    loop: Loop
    start: LoopState


class Progress(NamedTuple):
    """Where a running cycle is."""

    time_s: float
    phase: int
    tip_mm: float
    valve_open_ratio: float
    vacuum_mmhg: float


def find_protocol(name: str) -> Protocol | Template:
    """Protocol preset by name, or from a file if the name ends in ``.toml``.

    Raises InputError for an unknown name or a file that is not a protocol.
    """
    if name.endswith(".toml"):
        return validate(Protocol, load_toml(name), name)
    known: dict[str, Protocol | Template] = {**TEMPLATES, **PROTOCOLS}
    return choose(name, known, "protocol")


def machine_of(choice: Choice) -> str:
    """The machine that was named; else the bench for a protocol that is for the bench only."""
    if choice.machine is not None:
        choose(choice.machine, bench.PROFILES, "machine")
        return choice.machine
    found = find_protocol(choice.protocol)
    return "bench" if isinstance(found, Protocol) and found.bench_only else "clinical"


def check(choice: Choice) -> tuple[Protocol | Template, CompensationKind]:
    """Refuse unknown names and bad files before anything slow begins; raises InputError."""
    found = find_protocol(choice.protocol)
    machine = machine_of(choice)
    choose(choice.approach, APPROACHES, "approach")
    choose(choice.patient, TABLES, "patient")
    kind, _ = compensation_choice.chosen(choice.compensation)
    bench_only = isinstance(found, Protocol) and found.bench_only
    if bench_only and machine != "bench":
        raise InputError(
            f"protocol '{choice.protocol}' is for the bench only: it breaks a guideline's limit; "
            "use --machine bench or another protocol"
        )
    if not bench_only and machine == "bench":
        raise InputError(
            f"protocol '{choice.protocol}' is for a patient and the bench has none: use "
            "--machine clinical or --protocol paper"
        )
    return found, kind


def _fitted(
    found: Protocol | Template,
    rig: Rig,
    kind: CompensationKind,
    calibration: Calibration,
    by_contact: bool,
) -> Protocol:
    """The protocol for the rig's patient; a file's own numbers are held against the guidelines."""
    able = setup.abilities(rig.profile, kind, calibration, rig.site)
    if isinstance(found, Template):
        return clinical.fitted(found, able, rig.site, by_contact)
    if not found.bench_only:
        clinical.enforce(clinical.held_against_guidelines(found, able, rig.site))
    return found


def prepare(choice: Choice, tell: Callable[[str], None] = lambda _: None) -> Prepared:
    """Draw the machine, identify it where the compensation needs that, and plan the cycle.

    tell: called with a line of progress. Raises InputError for bad names, files and plans.
    """
    found, kind = check(choice)
    by_contact = APPROACHES[choice.approach]
    rig = bench.rig(machine_of(choice), choice.seed, patient=choice.patient)
    if by_contact and not rig.machine.has_patient:
        rig = bench.with_carina(rig, CONTACT_CARINA_MM)
    _, identified = compensation_choice.chosen(choice.compensation)
    calibration = bench.uncalibrated(rig.profile)
    if identified is not None:
        tell(f"Compensating with the model of {choice.compensation}")
        calibration = compensation_choice.calibration(
            identified, choice.compensation, rig.profile.transmission
        )
    protocol = _fitted(found, rig, kind, calibration, by_contact)
    # Refuse before the slow part.
    bench.assemble(rig, protocol, kind, calibration, CYCLE_RUN, by_contact)
    identification = None
    if kind != CompensationKind.NONE and identified is None:
        tell("Identifying this machine before use: the head over its stroke, the tip under a laser")
        identification = bench.identify(rig)
        calibration = identification.calibration
        protocol = _fitted(found, rig, kind, calibration, by_contact)
    loop, start = bench.assemble(rig, protocol, kind, calibration, CYCLE_RUN, by_contact)
    return Prepared(
        choice, rig, protocol, kind, calibration, identification, identified, loop, start
    )


def play(prepared: Prepared, watch: Callable[[Progress], None]) -> Columns:
    """Run the cycle in pieces; ``watch`` hears of each and may take its time.

    A patient is followed for a while longer: saturation is lowest after the catheter is out.
    """
    after_s = AFTERMATH_S if prepared.rig.machine.has_patient else 0.0
    table = trace.rows(LIMIT_S + after_s)
    piece = round(PIECE_S / DT_S)
    most = round(LIMIT_S / DT_S)
    state, done, requests = prepared.start, 0, START
    while done < most:
        state, ticks = closed_loop.run(prepared.loop, state, requests, table[done : done + piece])
        requests = NO_REQUESTS
        done += ticks
        watch(_progress(table[done - 1]))
        if closed_loop.is_resting(state.controller.procedure.phase):
            break
    after = round(after_s / DT_S)
    if after:
        closed_loop.run(prepared.loop, state, NO_REQUESTS, table[done : done + after])
    return trace.by_name(table[: done + after])


_INDEX = {name: i for i, name in enumerate(COLUMNS)}


def _progress(row: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Progress:
    return Progress(
        time_s=float(row[_INDEX["time_s"]]),
        phase=int(row[_INDEX["phase"]]),
        tip_mm=float(row[_INDEX["truth.tip_mm"]]),
        valve_open_ratio=float(row[_INDEX["truth.valve_open_ratio"]]),
        vacuum_mmhg=float(row[_INDEX["readings.line_vacuum_mmhg"]]),
    )


def checks(prepared: Prepared) -> list[Check]:
    """The clinical requirements of the paper's section II-A, held against the plan."""
    able = setup.abilities(
        prepared.rig.profile, prepared.kind, prepared.calibration, prepared.rig.site
    )
    return clinical.held_against_guidelines(prepared.protocol, able, prepared.rig.site)


def stopping_mm(prepared: Prepared) -> float:
    """Where suction is meant to take place: the travel, or off the carina that is touched."""
    if APPROACHES[prepared.choice.approach]:
        return prepared.rig.machine.airway.carina_mm - prepared.protocol.backoff_mm
    return prepared.protocol.travel_mm


def tracked_span_s(prepared: Prepared) -> float | None:
    """Span over which tracking is scored: the paper's cycle is, 0 to 29 s of its reference."""
    if not prepared.protocol.bench_only or APPROACHES[prepared.choice.approach]:
        return None
    protocol = prepared.protocol
    return (
        protocol.travel_mm / protocol.insertion_mm_per_s
        + protocol.dwell_s
        + protocol.travel_mm / protocol.withdrawal_mm_per_s
    )


def figures(prepared: Prepared, columns: Columns) -> Outcome:
    """Figures of the cycle."""
    secretion_ml = float(np.sum(prepared.start.machine.airway.secretion_ml))
    return outcome(
        columns,
        stopping_mm(prepared),
        secretion_ml,
        tracked_span_s(prepared),
        breathing=prepared.rig.machine.has_patient,
    )


def warm_up(prepared: Prepared) -> None:
    """One tick, so that whatever must be compiled or loaded is."""
    closed_loop.run(prepared.loop, prepared.start, START, trace.rows(DT_S))


def realtime_factor(prepared: Prepared) -> float:
    """Simulated time over the time that the compiled simulation alone takes, trace included.

    The second of two runs into the same trace: the first pays for fresh memory.
    """
    table = trace.rows(LIMIT_S)
    closed_loop.run(prepared.loop, prepared.start, START, table)
    began_s = perf_counter()
    _, ticks = closed_loop.run(prepared.loop, prepared.start, START, table)
    return ticks * DT_S / (perf_counter() - began_s)
