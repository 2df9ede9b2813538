"""Death of the controller, and faults of nodes, at the edges and in the middle of each phase.

A cycle on a newborn is played once to know its phases, and again; at each instant a copy goes on by
itself. The oracle judges by the twin's truth.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import pytest

from opensuction.kernel.interface import START
from opensuction.kernel.vocabulary import Phase
from opensuction.machine.canopen.device import AxisMode
from opensuction.machine.drives.node_fault import NodeFault, Request
from opensuction.oracle import exposure, harm
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.simulation import outcome
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.machine_side import SHOWN_COLUMNS
from tests.machine.drives.bus_room import EMULATED, BusRoom, branch, by_torque
from tests.machine.drives.test_bus_cycle import prepared

pytestmark = pytest.mark.sweep

NEWBORN = CycleChoice(RigChoice(patient="neonate", seed=3))
RESTS_S = 0.3
MOST_S = 60.0
POSITION = AxisMode.POSITION
OUT_S = 12.0
"""From any instant on the drives bring the catheter out, or the controller does."""
FAULTS = (NodeFault.NODE_LOST, NodeFault.BUS_OFF, NodeFault.EMERGENCY)
INSIDE = (Phase.INSERTING, Phase.SUCTIONING, Phase.WITHDRAWING)
ALONE, VALVE_ON = (SHOWN_COLUMNS.index(name) for name in ("alone", "commands.valve_on"))


class End(NamedTuple):
    """What came of an instant."""

    alone_ms: int
    """Until the drives acted by themselves; -1: never."""
    valve_torque: bool
    """The valve's motor had torque while they did."""
    harmed: tuple[str, ...]
    told: tuple[str, ...]
    """What people are told in the end."""


def judge(room: BusRoom, since: int) -> End:
    """The end of a run. since: tick of the twin from which on the drives may act alone."""
    loop, shown = prepared(NEWBORN).loop, room.shown()
    rows = np.array(room.machine.shown[since:])
    alone = np.flatnonzero(rows[:, ALONE])
    borne = exposure.measure(loop.machine, shown)
    found = harm.find(loop.machine, borne, loop.controller.limits.cap_mm)
    return End(
        int(alone[0]) + 1 if len(alone) else -1,
        bool(rows[alone, VALVE_ON].any()),
        tuple(one.name for one in found),
        tuple(one.name for one in outcome.showing(shown)),
    )


def kill(room: BusRoom) -> End:
    """The controller is no more."""
    since = len(room.machine.shown)
    room.machine.move(round(OUT_S / DT_S))
    return judge(room, since)


def break_down(room: BusRoom, request: Request) -> End:
    """A node has a fault; the controller lives."""
    since = len(room.machine.shown)
    room.machine.drives.break_down(request)
    room.run(OUT_S)
    return judge(room, since)


def play(folder: Path, period: int, mode: AxisMode = POSITION) -> Iterator[tuple[int, BusRoom]]:
    """A cycle, step by step: number of the next one."""
    made = prepared(NEWBORN)
    device = EMULATED if mode == POSITION else by_torque(made.loop)
    room = BusRoom(folder, made.loop, made.start, period, device=device)
    room.run(RESTS_S)
    began = len(room.rows)
    room.step(START)
    while room.phase() != Phase.PARKED or len(room.rows) - began < 10:
        assert len(room.rows) * period * DT_S < MOST_S
        yield len(room.rows), room
        room.step()
    room.close()


@cache
def phases(period: int, mode: AxisMode = POSITION) -> dict[Phase, tuple[int, int]]:
    """First step of each phase, and of the next one."""
    with TemporaryDirectory() as folder:
        found = [(number, room.phase()) for number, room in play(Path(folder), period, mode)]
    return {
        phase: (
            min(n for n, one in found if one == phase),
            max(n for n, one in found if one == phase),
        )
        for phase in dict.fromkeys(one for _, one in found)
    }


class Happening(NamedTuple):
    """A thing that happens at a step of the cycle."""

    step: int
    what: Callable[[BusRoom], End]


def at_each(
    folder: Path, period: int, happenings: Sequence[Happening], mode: AxisMode = POSITION
) -> dict[tuple[int, Phase], list[End]]:
    """Ends of what happens, by step and phase, in the order in which it is given; one cycle."""
    return {
        (number, room.phase()): [
            branch(partial(one.what, room)) for one in happenings if one.step == number
        ]
        for number, room in play(folder, period, mode)
        if any(one.step == number for one in happenings)
    }


@pytest.mark.parametrize(
    ("period", "mode"),
    [
        (4, POSITION),
        pytest.param(2, POSITION, marks=pytest.mark.soak),
        pytest.param(4, AxisMode.TORQUE, marks=pytest.mark.soak),
        pytest.param(2, AxisMode.TORQUE, marks=pytest.mark.soak),
    ],
)
def test_the_drives_act_in_time_whenever_the_controller_dies(
    tmp_path: Path, period: int, mode: AxisMode
) -> None:
    edges = [step for span in phases(period, mode).values() for step in span]
    instants = {edge + off for edge in edges for off in (-1, 0, 1)}
    ends = at_each(tmp_path, period, [Happening(step, kill) for step in sorted(instants)], mode)
    assert len(ends) > 20
    most_ms = EMULATED.heartbeats.lost_host_ms + period
    for at, (end,) in ends.items():
        assert 0 < end.alone_ms <= most_ms, (at, end)
        assert not end.valve_torque, (at, end)
        assert end.harmed == (), (at, end)
        assert end.told, (at, end)


@pytest.mark.parametrize(
    "in_each", [pytest.param(False, id="one phase"), pytest.param(True, marks=pytest.mark.soak)]
)
def test_a_node_that_fails_is_told_and_harms_nobody(tmp_path: Path, in_each: bool) -> None:
    """An insertion drive without torque leaves the catheter to a person, who is told.

    in_each: each node by each fault in each phase, not in one of them.
    """
    spans = phases(4)
    middle = [sum(spans[phase]) // 2 for phase in INSIDE]
    faults = [
        (step, Request(fault, node))
        for i, fault in enumerate(FAULTS)
        for j, node in enumerate(EMULATED.nodes)
        for k, step in enumerate(middle)
        if in_each or (i + j + k) % len(middle) == 0
    ]
    found = at_each(
        tmp_path, 4, [Happening(step, partial(break_down, request=one)) for step, one in faults]
    )
    assert len(found) == len(middle)
    for (step, phase), ends in found.items():
        requests = [one for at, one in faults if at == step]
        for request, end in zip(requests, ends, strict=True):
            stays = request.node == EMULATED.insertion.node and request.fault != NodeFault.BUS_OFF
            assert set(end.harmed) <= ({harm.LEFT_INSIDE} if stays else set()), (phase, request)
            assert end.told, (phase, request, end)
