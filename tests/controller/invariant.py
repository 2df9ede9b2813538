"""Invariants of every tick of every run, whatever is broken and whoever presses what."""

import numpy as np

from opensuction.oracle.exposure import trace_advance_mm
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.simulation.closed_loop import Loop
from opensuction.simulation.injection import invariant
from opensuction.simulation.trace import Columns
from tests.controller.drive import Fault

UNSEEN = {Fault.HEAD_FLAGGED, Fault.HEAD_NAN, Fault.HEAD_FROZEN}
"""The head moves where nobody sees it: its bound cannot hold."""
UNSTEERED = {Fault.DRIVE_INWARDS}
"""The head moves against its command: it advances until that is noticed, valve open or not."""


def trips(columns: Columns) -> set[Condition]:
    """Every trip of a run."""
    masks = columns["verdict.trips"].astype(np.int64)
    return set(condition_mask.decode_trips(int(np.bitwise_or.reduce(masks))))


def trip_s(columns: Columns, code: Condition) -> float:
    """When a trip appeared."""
    masks = columns["verdict.trips"].astype(np.int64)
    happened = masks >> int(code) & 1
    assert happened.any(), f"{code.name} did not trip"
    return float(columns["time_s"][np.argmax(happened)])


def assert_commands_held(columns: Columns, loop: Loop) -> None:
    """Every invariant of what the controller commands."""
    judged = {name: columns[name] for name in invariant.JUDGED}
    assert invariant.command_side(judged, loop.controller) == []


def assert_held(columns: Columns, loop: Loop, fault: Fault = Fault.NONE) -> None:
    """Every invariant that can be held under this fault."""
    assert_commands_held(columns, loop)
    tip, limits = columns["truth.tip_mm"], loop.controller.limits
    assert tip.max() <= limits.cap_mm
    if fault in UNSTEERED:
        return
    is_open = columns["truth.valve_open_ratio"] > 0.0
    if fault != Fault.CAM_FROZEN:  # the valve is open where nobody sees it
        assert trace_advance_mm(columns["truth.head_mm"], is_open).max() <= 0.5
        assert trace_advance_mm(tip, is_open).max() <= 0.5
    if fault not in UNSEEN:
        assert (tip <= columns["verdict.deepest_mm"]).all()
