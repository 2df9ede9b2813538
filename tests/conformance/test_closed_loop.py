"""The loop that plays every run, as machine code: the same rows as plain Python, number for number.

Its machine code is made with vectorised straight-line code, unlike that of single steps
(docs/decisions/0020), so the whole of it is compared: both sides, the link between, the rows.
"""

from collections.abc import Callable

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.interface import NO_REQUESTS, START
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import closed_loop, wiring
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import COLUMNS
from opensuction.simulation.wiring import Wiring
from opensuction.twin.fault import link
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import FaultOnset
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine import fail_safe, machine
from tests.conformance.plain import run_plain
from tests.conformance.test_controller_step import CALIBRATION, SHORT

BENCH_TICKS = 11600
"""A whole cycle of the short protocol."""


def bench() -> list[list[float]]:
    """A whole cycle on the bench."""
    loop, parked = rigs.assemble(
        rigs.rig("bench", 1, nominal=True), SHORT, CompensationKind.NONE, CALIBRATION, run=2
    )
    table = np.zeros((BENCH_TICKS, len(COLUMNS)))
    closed_loop.run(loop, parked, START, table)
    return [[float(value) for value in row] for row in table[::7]]


def linked() -> list[list[float]]:
    """The exact inverse over a link with drives that watch, its encoder noisy: it is stopped."""
    loop, parked = rigs.assemble(
        rigs.rig("bench", 1, nominal=True), PAPER, CompensationKind.EXACT_INVERSE, CALIBRATION, 2
    )
    reading = machine.read(loop.machine, parked.machine)
    wires = Wiring(
        link=link.healthy(1),
        watchdog=fail_safe.of(loop.machine, loop.controller.limits.park_head_mm),
    )
    messages = wiring.start(reading, parked.tick)
    table = np.zeros((8000, len(COLUMNS)))
    state, _ = closed_loop.run(loop, parked, START, table[:7400], wires, messages)
    noisy = ROWS[Fault.ENCODER_NOISY].change_reading(FaultOnset(2.0, 7400, 0.001), reading, 3)
    wires = wires._replace(link=link.with_reading_fault(wires.link, noisy))
    closed_loop.run(loop, state, NO_REQUESTS, table[7400:], wires, messages)
    return [[float(value) for value in row] for row in table[::7]]


@pytest.mark.parametrize(
    ("play", "reached"),
    [
        # Its controller and its machine are compared without the loop in each run of all tests.
        pytest.param(bench, {Phase.SUCTIONING, Phase.PARKED}, marks=pytest.mark.soak),
        pytest.param(linked, {Phase.INSERTING, Phase.ABORTING}, marks=pytest.mark.sweep),
    ],
)
def test_compiled_equals_plain_python(
    play: Callable[[], list[list[float]]], reached: set[Phase]
) -> None:
    rows = play()
    plain = np.array(run_plain("tests.conformance.test_closed_loop", play.__name__))
    column = COLUMNS.index("phase")
    assert reached <= {int(row[column]) for row in rows}
    # Fused multiply-adds differ in the last bit; the loop damps what that does.
    np.testing.assert_allclose(rows, plain, rtol=1e-9, atol=1e-9)
