"""One automated cycle on the twin, from named choices to a trace."""

from collections.abc import Callable
from time import perf_counter
from typing import NamedTuple

import numpy as np

from opensuction.control.compensation import KIND_OF_NAME, CompensationKind
from opensuction.kernel.requests import NO_REQUESTS, START
from opensuction.procedure.protocol import PROTOCOLS, Protocol
from opensuction.settings.choice import choose
from opensuction.settings.toml_file import load_toml
from opensuction.settings.validation import validate
from opensuction.simulation import bench, closed_loop, trace
from opensuction.simulation.bench import Identification, Rig
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.outcome import Outcome, outcome
from opensuction.simulation.trace import Columns
from opensuction.twin import preset

APPROACHES = {"travel": "travel"}
"""Ways to find the stopping point."""
CYCLE_RUN = 2
"""Number of the noise stream of cycles; identification has another."""
LIMIT_S = 180.0
"""No cycle lasts longer: every phase has a limit of its own."""
PIECE_S = 0.05
"""Simulated time between two reports of progress."""


class Choice(NamedTuple):
    """What a person chose, as names."""

    machine: str
    protocol: str
    """Name of a preset or path of a TOML file."""
    approach: str
    compensation: str
    seed: int


class Prepared(NamedTuple):
    """A cycle ready to run."""

    choice: Choice
    rig: Rig
    protocol: Protocol
    kind: CompensationKind
    identification: Identification | None
    """None where the compensation needs none."""
    loop: Loop
    start: LoopState


class Progress(NamedTuple):
    """Where a running cycle is."""

    time_s: float
    phase: int
    tip_mm: float
    valve_open_ratio: float
    vacuum_mmhg: float


def find_protocol(name: str) -> Protocol:
    """Protocol preset by name, or from a file if the name ends in ``.toml``.

    Raises InputError for an unknown name or a file that is not a protocol.
    """
    if name.endswith(".toml"):
        return validate(Protocol, load_toml(name), name)
    return choose(name, PROTOCOLS, "protocol")


def check(choice: Choice) -> tuple[Protocol, CompensationKind]:
    """Refuse unknown names and bad files before anything slow begins; raises InputError."""
    choose(choice.machine, preset.TABLES, "machine")
    choose(choice.approach, APPROACHES, "approach")
    kind = choose(choice.compensation, KIND_OF_NAME, "compensation")
    return find_protocol(choice.protocol), kind


def prepare(choice: Choice, tell: Callable[[str], None] = lambda _: None) -> Prepared:
    """Draw the machine, identify it where the compensation needs that, and plan the cycle.

    tell: called with a line of progress. Raises InputError for bad names, files and plans.
    """
    protocol, kind = check(choice)
    rig = bench.rig(choice.machine, choice.seed)
    calibration = bench.uncalibrated(rig.profile)
    bench.assemble(rig, protocol, kind, calibration, CYCLE_RUN)  # refuse before the slow part
    identification = None
    if kind != CompensationKind.NONE:
        tell("Identifying this machine: head 0 to 100 mm and back, twice, tip under the laser")
        identification = bench.identify(rig)
        calibration = identification.calibration
    loop, start = bench.assemble(rig, protocol, kind, calibration, CYCLE_RUN)
    return Prepared(choice, rig, protocol, kind, identification, loop, start)


def play(prepared: Prepared, watch: Callable[[Progress], None]) -> Columns:
    """Run the cycle in pieces; ``watch`` hears of each and may take its time."""
    table = trace.rows(LIMIT_S)
    piece = round(PIECE_S / DT_S)
    state, done, requests = prepared.start, 0, START
    while done < len(table):
        state, ticks = closed_loop.run(prepared.loop, state, requests, table[done : done + piece])
        requests = NO_REQUESTS
        done += ticks
        watch(_progress(table[done - 1]))
        if ticks < piece:
            break
        if closed_loop.is_resting(state.controller.procedure.phase):
            break
    return trace.by_name(table[:done])


_INDEX = {name: i for i, name in enumerate(COLUMNS)}


def _progress(row: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Progress:
    return Progress(
        time_s=float(row[_INDEX["time_s"]]),
        phase=int(row[_INDEX["phase"]]),
        tip_mm=float(row[_INDEX["truth.tip_mm"]]),
        valve_open_ratio=float(row[_INDEX["truth.valve_open_ratio"]]),
        vacuum_mmhg=float(row[_INDEX["readings.line_vacuum_mmhg"]]),
    )


def tracked_span_s(prepared: Prepared) -> float | None:
    """Span over which tracking is scored: the paper's cycle is, 0 to 29 s of its reference."""
    if not prepared.protocol.bench_only:
        return None
    protocol = prepared.protocol
    return (
        protocol.travel_mm / protocol.insertion_mm_per_s
        + protocol.dwell_s
        + protocol.travel_mm / protocol.withdrawal_mm_per_s
    )


def figures(prepared: Prepared, columns: Columns) -> Outcome:
    """Figures of the cycle."""
    secretion_ml = float(np.sum(preset.secretions_ml(prepared.rig.values)))
    return outcome(columns, prepared.protocol.travel_mm, secretion_ml, tracked_span_s(prepared))


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
