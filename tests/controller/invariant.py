"""What must hold in every tick of every run, whatever is broken and whoever presses what."""

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.phase import Phase
from opensuction.safety import trip
from opensuction.safety.trip import Trip
from opensuction.simulation.closed_loop import DT_S, Loop
from opensuction.simulation.trace import Columns
from tests.controller.drive import Fault

SUCTION_PHASES = (Phase.OPENING, Phase.SUCTIONING, Phase.WITHDRAWING, Phase.ABORTING)

UNSEEN = {Fault.HEAD_FLAGGED, Fault.HEAD_NAN, Fault.HEAD_FROZEN}
"""The head moves where nobody sees it: its bound cannot hold."""
UNSTEERED = {Fault.DRIVE_INWARDS}
"""The head moves against its command: it advances until that is noticed, valve open or not."""


def trips(columns: Columns) -> set[Trip]:
    """Every trip of a run."""
    masks = columns["verdict.trips"].astype(np.int64)
    return set(trip.names(int(np.bitwise_or.reduce(masks))))


def trip_s(columns: Columns, code: Trip) -> float:
    """When a trip appeared."""
    masks = columns["verdict.trips"].astype(np.int64)
    happened = masks >> int(code) & 1
    assert happened.any(), f"{code.name} did not trip"
    return float(columns["time_s"][np.argmax(happened)])


def advance_mm(position_mm: NDArray[np.float64], counts: NDArray[np.bool_]) -> float:
    """Largest net advance within any unbroken stretch in which ``counts`` holds."""
    worst = 0.0
    edges = np.flatnonzero(np.diff(np.concatenate(([0], counts.astype(int), [0]))))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        part = position_mm[start:end]
        worst = max(worst, float(np.max(part - np.minimum.accumulate(part))))
    return worst


def assert_commands(columns: Columns, loop: Loop) -> None:
    """What leaves the controller is finite, within the supply, and never in too fast."""
    for name, values in columns.items():
        if name.startswith("commands."):
            assert np.isfinite(values).all(), name
    driven = columns["commands.insertion_on"] > 0.0
    volts = columns["commands.insertion_v"]
    assert np.abs(volts).max() <= 24.0
    assert not volts[~driven].any()
    assert not columns["commands.valve_v"][columns["commands.valve_on"] == 0.0].any()
    step = np.diff(columns["commands.head_mm"])[driven[1:] & driven[:-1]]
    if step.size:
        assert step.max() <= loop.controller.limits.head_speed_mm_per_s * DT_S + 1e-9
    assert columns["commands.vacuum_mmhg"].max() <= loop.controller.limits.vacuum_mmhg


def assert_valve(columns: Columns) -> None:
    """The valve is told to open only where suction belongs, and never with vacuum to be cut.

    The pre-use test strokes it with the line vented and the tip parked.
    """
    opening = np.diff(columns["commands.cam_rad"]) > 0.0
    vented = (columns["truth.tip_vacuum_mmhg"] < 1.0) & (columns["commands.pump_on"] == 0.0)
    testing = (columns["phase"] == Phase.CHECKING) & vented
    allowed = np.isin(columns["phase"], SUCTION_PHASES) | testing
    assert not (opening & ~allowed[1:]).any()
    for mask in np.unique(columns["verdict.trips"]):
        if trip.cuts_vacuum(int(mask)):
            cut = columns["verdict.trips"] == mask
            assert not (opening & cut[1:]).any()
            assert not columns["commands.pump_on"][cut].any()


def assert_held(columns: Columns, loop: Loop, fault: Fault = Fault.NONE) -> None:
    """Every invariant that can be held under this fault."""
    assert_commands(columns, loop)
    assert_valve(columns)
    tip, limits = columns["truth.tip_mm"], loop.controller.limits
    assert tip.max() <= limits.cap_mm
    if fault in UNSTEERED:
        return
    is_open = columns["truth.valve_open_ratio"] > 0.0
    if fault != Fault.CAM_FROZEN:  # the valve is open where nobody sees it
        assert advance_mm(columns["truth.head_mm"], is_open) <= 0.5
        assert advance_mm(tip, is_open) <= 0.5
    if fault not in UNSEEN:
        assert (tip <= columns["verdict.deepest_mm"]).all()
