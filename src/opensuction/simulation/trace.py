"""Recorded runs of the closed loop: columns by name."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.controller import controller
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import Requests
from opensuction.simulation import closed_loop
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.twin.machine import machine as twin
from opensuction.twin.plant import PlantState

Columns = dict[str, npt.NDArray[np.float64]]
"""Trace of a run: one array for each column of `closed_loop.COLUMNS`, one entry a tick."""


class PhaseSpan(NamedTuple):
    """One phase of a run, from its first tick to the first tick of the next."""

    phase: Phase
    start_s: float
    end_s: float


def power_up(loop: Loop, plant: PlantState, catheter_age_s: float) -> LoopState:
    """Closed loop at its first tick, the plant as given, its head read by the encoder."""
    head_mm = twin.read(loop.machine, plant.machine).head_mm
    return LoopState(
        tick=0,
        controller=controller.start(loop.controller, head_mm, catheter_age_s),
        machine=plant.machine,
        bedside=plant.bedside,
    )


def rows(limit_s: float) -> npt.NDArray[np.float64]:
    """Room for a trace of at most ``limit_s``."""
    return np.zeros((round(limit_s / DT_S), len(COLUMNS)))


def by_name(table: npt.NDArray[np.float64]) -> Columns:
    """Rows as columns by name."""
    return {name: np.ascontiguousarray(table[:, i]) for i, name in enumerate(COLUMNS)}


def record(
    loop: Loop, state: LoopState, requests: Requests, limit_s: float
) -> tuple[LoopState, Columns]:
    """Run until the machine rests again, at most ``limit_s``; returns the state and the trace."""
    table = rows(limit_s)
    state, ticks = closed_loop.run(loop, state, requests, table)
    return state, by_name(table[:ticks])


def phase_spans(trace: Columns) -> list[PhaseSpan]:
    """Phases of a run in order."""
    phase, time_s = trace["phase"], trace["time_s"]
    starts = np.concatenate(([0], np.flatnonzero(np.diff(phase)) + 1))
    ends = np.append(time_s[starts[1:]], time_s[-1] + DT_S)
    return [
        PhaseSpan(Phase(int(phase[i])), float(time_s[i]), float(end))
        for i, end in zip(starts, ends, strict=True)
    ]
