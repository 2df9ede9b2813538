"""The controller that is debugged is the controller that runs: compiled equals plain Python."""

from typing import NamedTuple

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.controller.calibration import Feedforward, assume_nominal
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import COLUMNS, LoopState
from tests.conformance.plain import run_plain
from tests.controller import drive
from tests.controller.drive import (
    ABORT,
    CHANGED,
    CONFIRM,
    NEVER,
    RESET,
    RETURN_TO_SERVICE,
    SERVICE,
    START,
    TEACH,
    Fault,
    When,
)

SHORT = PAPER._replace(travel_mm=1.0, cap_mm=6.0, dwell_s=2.1)
"""A whole cycle in twelve seconds: as plain Python a tick takes some 0.1 ms."""

CALIBRATION = assume_nominal(PUBLISHED, Feedforward(velocity_v_s_per_mm=1.28, friction_v=0.5))

START_TICKS = 6900
"""Of a cycle that nothing disturbs before: played once for all runs that have it in common."""


class Run(NamedTuple):
    """What happens from `START_TICKS` on, or from the beginning; ticks count from there."""

    kind: CompensationKind
    ticks: int
    pressed: dict[int, int]
    when: When = NEVER
    started: bool = False
    """Whether the cycle has gone on for `START_TICKS`."""


EXACT = CompensationKind.EXACT_INVERSE
RUNS = {
    "cycle": Run(CompensationKind.NONE, 11600, {0: START}),
    "started": Run(EXACT, START_TICKS, {0: START}),
    "stopped": Run(EXACT, 1700, {700: ABORT, 1690: RESET}, started=True),
    "hands": Run(
        EXACT,
        900,
        {0: SERVICE, 200: CHANGED, 300: RETURN_TO_SERVICE, 400: TEACH, 600: CONFIRM, 700: ABORT},
    ),
    "blind": Run(EXACT, 300, {200: RESET}, When(int(Fault.HEAD_NAN), 0, 50), started=True),
    "contact": Run(EXACT, 1000, {}, When(int(Fault.CONTACT_BOUNCING), 600, 1000), started=True),
}
SWEEP = {"direct": Run(CompensationKind.DIRECT_INVERSE, 7300, {0: START})}


def results() -> dict[str, list[list[float]]]:
    """Every column of every run, thinned to every seventh tick."""
    return tables_of(RUNS)


def more_results() -> dict[str, list[list[float]]]:
    """The same of the sweep."""
    return tables_of(SWEEP)


def tables_of(runs: dict[str, Run]) -> dict[str, list[list[float]]]:
    rig = rigs.rig("bench", 1, nominal=True)
    tables = {}
    ends: dict[str, LoopState] = {}
    for name, run in runs.items():
        protocol = SHORT if run.kind == CompensationKind.NONE else PAPER
        loop, parked = rigs.assemble(rig, protocol, run.kind, CALIBRATION, run=2)
        buttons = np.zeros(run.ticks, dtype=np.int64)
        for tick, bits in run.pressed.items():
            buttons[tick] = bits
        table = np.zeros((run.ticks, len(COLUMNS)))
        state = ends["started"] if run.started else parked
        ends[name] = drive.run(loop, state, buttons, run.when, table)
        tables[name] = [[float(value) for value in row] for row in table[::7]]
    return tables


@pytest.fixture(scope="module")
def compiled() -> dict[str, list[list[float]]]:
    return results()


def test_the_runs_reach_every_phase_of_a_cycle(compiled: dict[str, list[list[float]]]) -> None:
    column = COLUMNS.index("phase")
    seen = {Phase(int(row[column])) for rows in compiled.values() for row in rows}
    assert seen == set(Phase) - {
        Phase.BACKING_OFF,
        Phase.IDENTIFYING,
    }


def assert_equals_plain(compiled: dict[str, list[list[float]]], function: str) -> None:
    plain = run_plain("tests.conformance.test_controller_step", function)
    assert isinstance(plain, dict)
    assert plain.keys() == compiled.keys()
    for name, rows in compiled.items():
        # Fused multiply-adds differ in the last bit; the loop damps what that does.
        np.testing.assert_allclose(rows, plain[name], rtol=1e-9, atol=1e-9, err_msg=name)


@pytest.mark.sweep
def test_compiled_equals_plain_python(compiled: dict[str, list[list[float]]]) -> None:
    assert_equals_plain(compiled, "results")


@pytest.mark.sweep
def test_the_direct_inverse_equals_plain_python_too() -> None:
    assert_equals_plain(more_results(), "more_results")
