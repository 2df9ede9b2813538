"""The controller that is debugged is the controller that runs: compiled equals plain Python."""

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.controller.calibration import Feedforward, assume_nominal
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.kernel.phase import Phase
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import COLUMNS
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

RUNS: dict[str, tuple[CompensationKind, int, dict[int, int], When]] = {
    "cycle": (CompensationKind.NONE, 11600, {0: START}, NEVER),
    "direct": (CompensationKind.DIRECT_INVERSE, 7300, {0: START}, NEVER),
    "stopped": (CompensationKind.EXACT_INVERSE, 8600, {0: START, 7600: ABORT, 8590: RESET}, NEVER),
    "hands": (
        CompensationKind.EXACT_INVERSE,
        900,
        {0: SERVICE, 200: CHANGED, 300: RETURN_TO_SERVICE, 400: TEACH, 600: CONFIRM, 700: ABORT},
        NEVER,
    ),
    "blind": (
        CompensationKind.EXACT_INVERSE,
        7200,
        {0: START, 7100: RESET},
        When(int(Fault.HEAD_NAN), 6900, 6950),
    ),
    "contact": (
        CompensationKind.EXACT_INVERSE,
        7900,
        {0: START},
        When(int(Fault.CONTACT_BOUNCING), 7500, 7900),
    ),
}


def results() -> dict[str, list[list[float]]]:
    """Every column of every run, thinned to every seventh tick."""
    rig = rigs.rig("bench", 1, nominal=True)
    tables = {}
    for name, (kind, ticks, pressed, when) in RUNS.items():
        protocol = SHORT if kind == CompensationKind.NONE else PAPER
        loop, state = rigs.assemble(rig, protocol, kind, CALIBRATION, run=2)
        buttons = np.zeros(ticks, dtype=np.int64)
        for tick, bits in pressed.items():
            buttons[tick] = bits
        table = np.zeros((ticks, len(COLUMNS)))
        drive.run(loop, state, buttons, when, table)
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


def test_compiled_equals_plain_python(compiled: dict[str, list[list[float]]]) -> None:
    plain = run_plain("tests.conformance.test_controller_step", "results")
    assert isinstance(plain, dict)
    assert plain.keys() == compiled.keys()
    for name, rows in compiled.items():
        # Fused multiply-adds differ in the last bit; the loop damps what that does.
        np.testing.assert_allclose(rows, plain[name], rtol=1e-9, atol=1e-9, err_msg=name)
