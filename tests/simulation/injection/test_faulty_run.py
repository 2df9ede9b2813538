"""Commands of the controller are kept beside those that the drives obeyed."""

import numpy as np

from opensuction.control.compensation import CompensationKind
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.faulty_run import FaultyRun, RowBuffer
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault import Fault

TICKS = 240
AT = 100
"""Tick in which the fault comes: in the pre-use test, as the head jogs and the pump starts."""


def ran(fault: Fault, strength: float, after_s: float) -> tuple[Columns, Columns]:
    """Columns as obeyed and as sent."""
    rig = rigs.rig("bench", 1)
    loop, parked = rigs.assemble(
        rig, PAPER, CompensationKind.EXACT_INVERSE, rigs.uncalibrated(rig.profile), 2
    )
    going = FaultyRun(
        loop, parked, [Injection(fault, FaultInstant(None, after_s), strength)], RowBuffer(1.0), 0
    )
    while going.done < TICKS:
        going.advance(TICKS - going.done)
    obeyed = going.columns
    return obeyed, going.sent(obeyed)


def commands(columns: Columns, ticks: slice) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.array([columns[name][ticks] for name in columns if name.startswith("commands.")])


def test_a_sound_link_makes_no_difference() -> None:
    for fault, strength in ((Fault.TICK_LATE, 1.0), (Fault.PUMP_LOST, 0.0)):
        obeyed, sent = ran(fault, strength, 0.9)
        assert np.array_equal(commands(obeyed, slice(None)), commands(sent, slice(None)))


def test_a_late_command_was_sent_in_time() -> None:
    obeyed, sent = ran(Fault.MESSAGE_LATE, 0.02, AT * 0.001)
    late = commands(obeyed, slice(AT + 20, TICKS))
    assert np.array_equal(late, commands(sent, slice(AT, TICKS - 20)))
    assert np.array_equal(commands(obeyed, slice(0, AT)), commands(sent, slice(0, AT)))


def test_a_controller_that_has_stopped_sends_nothing() -> None:
    _, sent = ran(Fault.CONTROLLER_STOPPED, 10.0, AT * 0.001)
    assert commands(sent, slice(0, AT)).any()
    assert not commands(sent, slice(AT, TICKS)).any()
