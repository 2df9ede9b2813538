"""One automated cycle on the twin, from named choices to a trace."""

from collections.abc import Callable
from time import perf_counter
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control.compensation import CompensationKind
from opensuction.controller import setup
from opensuction.controller.calibration import Calibration
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import NO_REQUESTS, START, Requests
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import teaching
from opensuction.procedure.cycle.teaching import SENTENCES, Taught
from opensuction.procedure.planning import clinical, guideline
from opensuction.procedure.planning.clinical import Template
from opensuction.procedure.planning.guideline import GuidelineCheck
from opensuction.procedure.planning.protocol import Protocol
from opensuction.report.terminal import Moment
from opensuction.session.cycle import equipment, resolution
from opensuction.session.cycle.resolution import ResolvedCycle
from opensuction.simulation import closed_loop, self_calibration, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.simulation.outcome import Outcome, outcome
from opensuction.simulation.rig import Identification, Rig
from opensuction.simulation.trace import Columns, InputSpan, Watcher
from opensuction.twin import bedside

CONTACT_CARINA_MM = 65.0
"""Distance at which the bench's rubber carina stands for the contact approach (paper, Table II)."""
CYCLE_RUN = 2
"""Number of the noise stream of cycles; identification has another."""
LIMIT_S = 180.0
"""No cycle lasts longer: every phase has a limit of its own."""
AFTERMATH_S = 90.0
"""How long a patient is followed after the cycle."""
LEAST_TRAVEL_MM = 1.0
"""Shortest way below the tube that is worth planning."""
PIECE_S = 0.05
"""Simulated time between two reports of progress."""


class Prepared(NamedTuple):
    """A cycle ready to run."""

    resolved: ResolvedCycle
    rig: Rig
    protocol: Protocol
    """As it was fitted to patient and machine."""
    calibration: Calibration
    """What the compensation works with: identified before use, from a file, or nominal."""
    identification: Identification | None
    """None where the compensation needs none, or has its model from a file."""
    taught_mm: float | None
    """Carina's depth that the protocol was fitted to or held against; None on a bench."""
    loop: Loop
    start: LoopState


Watch = Callable[[Moment], None]
"""Hears of each piece of a cycle."""


def teach(resolved: ResolvedCycle, rig: Rig, calibration: Calibration) -> float:
    """Depth of the carina as a person measured it, or as a hand teaches it on the rig.

    A fault may make it too long. Raises InputError where what was taught is not taken.
    """
    wrong_mm = resolution.taught_error_mm(resolved.faults)
    if wrong_mm > 0.0:
        wrong_mm += teach(resolved._replace(faults=()), rig, calibration)
        guideline.check_plausible(rig.site.age, wrong_mm, "the taught length")
        return wrong_mm
    if resolved.choice.taught_mm is not None:
        return resolved.choice.taught_mm
    found = self_calibration.teach(rig, calibration)
    if found.taught != Taught.TAKEN:
        raise InputError(
            f"the travel length could not be taught: {SENTENCES[found.taught]}; give it with "
            "--taught"
        )
    return found.taught_mm


def fit(resolved: ResolvedCycle, rig: Rig, calibration: Calibration) -> Protocol:
    """The protocol for the rig's patient, whose depth is what was taught.

    A file's own numbers are held against that and the guidelines.
    """
    protocol, by_contact = resolved.protocol, resolved.by_contact
    able = setup.abilities(rig.profile, resolved.compensation, calibration, rig.site)
    if isinstance(protocol, Template):
        return clinical.fitted(protocol, able, rig.site, by_contact)
    if not protocol.bench_only:
        clinical.check_catheter(rig.site)
        clinical.check_depth(protocol, rig.site, by_contact)
        clinical.enforce(clinical.held_against_guidelines(protocol, able, rig.site, by_contact))
    return protocol


def _refuse_early(resolved: ResolvedCycle, rig: Rig, calibration: Calibration) -> None:
    """Refuse before the slow part what no taught depth can make possible.

    Nothing is easier to fit than the least depth at which a tip can stop short of the carina, and
    the depth of a file waits for what is taught. Raises InputError.
    """
    first, found, given_mm = rig, resolved.protocol, resolved.choice.taught_mm
    if isinstance(found, Template):
        least_mm = teaching.PLAUSIBLE[rig.site.age].least_mm
        first = with_depth(rig, max(least_mm, found.stop_short_mm + LEAST_TRAVEL_MM))
    elif not resolved.equipment.on_bench:
        first = with_depth(rig, rigs.NO_CARINA_MM if given_mm is None else given_mm)
    protocol = fit(resolved, first, calibration)
    kind, by_contact = resolved.compensation, resolved.by_contact
    setup.plan_settings(first.profile, protocol, kind, calibration, by_contact, first.site)


def prepare(
    resolved: ResolvedCycle,
    tell: Callable[[str], None] = lambda _: None,
    what: str = "One suction cycle",
) -> Prepared:
    """Draw the machine, identify it and teach it where that is needed, and plan the cycle.

    tell: called with a line of progress. what: is prepared, for the first of them.
    Raises InputError for what cannot be planned.
    """
    choice, kind = resolved.choice, resolved.compensation
    at_patient = not resolved.equipment.on_bench
    rig = resolved.equipment.draw()
    if resolved.by_contact and not rig.machine.has_patient:
        rig = rigs.with_carina(rig, CONTACT_CARINA_MM)
    calibration = rigs.uncalibrated(rig.profile)
    if resolved.parameter_file is not None:
        calibration = equipment.calibration(resolved.parameter_file, choice.compensation, rig.kind)
    _refuse_early(resolved, rig, calibration)
    tell(f"{what} on the digital twin: {resolved.chosen}")
    identification, taught_mm, known = None, None, calibration
    if resolved.parameter_file is not None:
        tell(f"Compensating with the model of {choice.compensation}")
    elif kind != CompensationKind.NONE or at_patient:
        tell("Identifying this machine before use: the head over its stroke, the tip under a laser")
        identification = rigs.identify(rig)
        known = identification.calibration
        if kind == CompensationKind.MODEL_PREVIEW:
            tell("Holding every model of plays against the others, on strokes left out in turn")
            known = equipment.with_lines(rig, known)
    if at_patient:
        taught_mm = teach(resolved, rig, known)
        rig = with_depth(rig, taught_mm)
    if kind == CompensationKind.NONE:
        identification = None
    else:
        calibration = known
    prepared = assemble(resolved, rig, calibration)
    return prepared._replace(identification=identification, taught_mm=taught_mm)


def assemble(resolved: ResolvedCycle, rig: Rig, calibration: Calibration) -> Prepared:
    """The cycle of a rig that is calibrated and taught; its gaps may be changed only now."""
    kind, by_contact = resolved.compensation, resolved.by_contact
    protocol = fit(resolved, rig, calibration)
    rig = self_calibration.with_widths(rig, resolved.choice.gap_scale)
    rig = self_calibration.with_offset(rig, resolved.choice.tip_shift_mm)
    loop, start = rigs.assemble(rig, protocol, kind, calibration, CYCLE_RUN, by_contact)
    return Prepared(resolved, rig, protocol, calibration, None, None, loop, start)


def oxygenate(prepared: Prepared) -> Prepared:
    """The cycle with pre-oxygenation given or skipped, as it was chosen; its time begins after it.

    A prepared cycle that is played without is one that was skipped.
    """
    chosen = prepared.resolved.choice.preoxygenation
    loop, start = resolution.give(prepared.loop, prepared.start, chosen)
    return prepared._replace(loop=loop, start=start._replace(tick=0))


def with_depth(rig: Rig, carina_mm: float) -> Rig:
    """The same rig, its controller told that the carina is at this depth."""
    return rig._replace(site=rig.site._replace(carina_mm=carina_mm))


def play(prepared: Prepared, watch: Watch | None = None) -> Columns:
    """Run the cycle; ``watch`` hears of each piece and may take its time."""
    return played(prepared, prepared.start, START, watch)[1]


def played(
    prepared: Prepared, state: LoopState, requests: Requests, watch: Watch | None = None
) -> tuple[LoopState, Columns]:
    """Run one cycle from a state of the loop; the state afterwards, and the trace.

    A patient is followed for a while longer: saturation is lowest after the catheter is out.
    """
    watcher = trace.NOBODY
    if watch is not None:
        watcher = call_by_piece(watch)
    state, columns = trace.record(prepared.loop, state, requests, LIMIT_S, watcher=watcher)
    if not prepared.rig.machine.has_patient:
        return state, columns
    state, after = trace.record(prepared.loop, state, NO_REQUESTS, AFTERMATH_S)
    return state, trace.join([columns, after])


def run(
    prepared: Prepared, state: LoopState, requests: Requests, watch: Watch | None = None
) -> InjectedRun:
    """As `played`, with what the controller got in it."""
    after, columns = played(prepared, state, requests, watch)
    span = InputSpan(
        first=0,
        ticks=columns["time_s"].size,
        tick=state.tick,
        requests=requests,
        set_by=trace.BEGUN,
        state=state.controller,
    )
    return InjectedRun(after, columns, (), columns, spans=(span,))


_WATCHED = tuple(
    COLUMNS.index(name)
    for name in (
        "phase",
        "time_s",
        "truth.tip_mm",
        "truth.valve_open_ratio",
        "readings.line_vacuum_mmhg",
    )
)
"""Columns of a `Moment`."""


def call_by_piece(watch: Watch) -> Watcher:
    """Watcher that calls ``watch`` with the last row of each piece of the trace."""

    def hear(row: npt.NDArray[np.float64]) -> None:
        phase, *values = (float(row[index]) for index in _WATCHED)
        watch(Moment(Phase(int(phase)).name.lower(), *values))

    return Watcher(hear, PIECE_S)


def checks(prepared: Prepared) -> list[GuidelineCheck]:
    """The clinical requirements of the paper's section II-A, held against the plan."""
    kind, by_contact = prepared.resolved.compensation, prepared.resolved.by_contact
    able = setup.abilities(prepared.rig.profile, kind, prepared.calibration, prepared.rig.site)
    return clinical.held_against_guidelines(prepared.protocol, able, prepared.rig.site, by_contact)


def stopping_mm(prepared: Prepared) -> float:
    """Planned depth of suction: the travel, or off the carina that is touched."""
    if prepared.resolved.by_contact:
        return prepared.rig.machine.airway.carina_mm - prepared.protocol.backoff_mm
    return prepared.protocol.travel_mm


def tracked_span_s(prepared: Prepared) -> float | None:
    """Span over which tracking is scored: the paper's cycle is, 0 to 29 s of its reference."""
    if not prepared.protocol.bench_only or prepared.resolved.by_contact:
        return None
    protocol = prepared.protocol
    return (
        protocol.travel_mm / protocol.insertion_mm_per_s
        + protocol.dwell_s
        + protocol.travel_mm / protocol.withdrawal_mm_per_s
    )


def secretion_ml(prepared: Prepared, duration_s: float) -> float:
    """Secretions that lay there when the cycle began, and what came within a time.

    Those that suction cannot reach are among them.
    """
    around = prepared.start.bedside
    produced_ml = float(np.sum(around.produced_ml_per_s)) * duration_s
    return bedside.sum_secretion_ml(around) + produced_ml


def figures(prepared: Prepared, columns: Columns) -> Outcome:
    """Figures of the cycle; the share removed is of what was there and what came meanwhile."""
    return outcome(
        columns,
        prepared.rig.machine,
        stopping_mm(prepared),
        secretion_ml(prepared, columns["time_s"].size * DT_S),
        tracked_span_s(prepared),
        prepared.loop.controller.limits.cap_mm,
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
