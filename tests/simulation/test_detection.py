"""A part of the twin breaks in a running cycle: which trip names it, and how soon (in silico).

Each fault is a change of the twin's own parameters at an instant of a phase.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from opensuction.kernel.interface import NO_REQUESTS, START
from opensuction.kernel.vocabulary import Phase
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import closed_loop, trace
from opensuction.simulation.closed_loop import DT_S, LoopState
from opensuction.simulation.trace import Columns
from opensuction.twin.machine.machine import Machine
from tests.columns_of_rows import ColumnsOfRows
from tests.quiet_patient import quiet

AFTER_S = 16.1
"""A cycle that goes on has ended by then, or has its valve closed."""
BEGUN_S = 0.3
"""The fault comes so long after its phase began."""
AT_SPEED_S = 0.5
"""How long after its begin it has that: 17 mm/s of the tip are up to 50 of the head, at 200 mm/s2;
a head that still gains speed is told to be held up to .1 s later."""


@cache
def prepared(machine: str, approach: str, paced: bool = True) -> Prepared:
    """A machine of seed 1 with its calibration.

    paced: the dwell ends when nothing comes, and the way out is slow where mucus comes again.
    """
    # When a weak pump shows is decided by what lies at the tip: nobody coughs it up.
    patient = None if machine == "bench" else quiet("adult-icu")
    choice = CycleChoice(RigChoice(machine, patient=patient), approach=approach)
    made = cycle_run.prepare(resolution.resolve(choice))
    if paced:
        return made
    plan = made.loop.controller.plan
    plan = plan._replace(pace=plan.pace._replace(nothing_comes_s=0.0))
    controller = made.loop.controller._replace(plan=plan)
    return made._replace(loop=made.loop._replace(controller=controller))


def line(machine: Machine, **changed: Any) -> Machine:
    return machine._replace(line=machine.line._replace(**changed))


def held(machine: Machine, force_n: float) -> Machine:
    """A catheter that is held by a force both ways."""
    axis = machine.insertion_axis
    friction_v = axis.friction_v + force_n * machine.load_v_per_n
    return machine._replace(insertion_axis=axis._replace(friction_v=friction_v))


class Begun(NamedTuple):
    """A cycle that has just come to a fault."""

    state: LoopState
    rows: NDArray[np.float64]
    """Of all ticks so far."""


@cache
def sound(machine: str, approach: str, paced: bool) -> NDArray[np.float64]:
    """Phases of a sound cycle, one entry a tick."""
    ready = prepared(machine, approach, paced)
    return trace.record(ready.loop, ready.start, START, 70.0, ("phase",))[1]["phase"]


@cache
def begun(machine: str, approach: str, phase: Phase, paced: bool) -> Begun:
    """A sound cycle up to the instant of a fault in a phase."""
    ready, phases = prepared(machine, approach, paced), sound(machine, approach, paced)
    first = int(np.argmax(phases == phase))
    rows = trace.rows((first + 1) * DT_S + (BEGUN_S if paced else AT_SPEED_S))
    state, done = closed_loop.run(ready.loop, ready.start, START, rows)
    assert done == len(rows)
    assert state.controller.core.procedure.phase == phase
    return Begun(state, rows)


def broken(
    machine: str,
    approach: str,
    fault: Callable[[Machine], Machine],
    phase: Phase,
    paced: bool = True,
) -> tuple[dict[Condition, float], Columns]:
    """Trips of a cycle with a fault, s after the fault began; and the trace."""
    state, before = begun(machine, approach, phase, paced)
    loop = prepared(machine, approach, paced).loop
    loop = loop._replace(machine=fault(loop.machine))
    since = len(before)
    table = trace.rows(since * DT_S + AFTER_S)
    table[:since] = before
    # It ends where the machine rests.
    _, ticks = closed_loop.run(loop, state, NO_REQUESTS, table[since:])
    columns = ColumnsOfRows(table[: since + ticks])
    masks = columns["verdict.trips"].astype(np.int64)
    found = {
        code: float(np.argmax(masks >> int(code) & 1) - since) * DT_S
        for code in condition_mask.decode_trips(int(np.bitwise_or.reduce(masks)))
    }
    return found, columns


AT_SPEED = ("jam of 2 N on the way out",)
"""What is asked of a way out at its planned speed."""
FAULTS: dict[str, tuple[Callable[[Machine], Machine], Phase, Condition, float]] = {
    "jam of 2 N on the way in": (
        lambda m: held(m, 2.0), Phase.INSERTING, Condition.CATHETER_JAMMED, 0.25,
    ),
    "jam of 2 N on the way out": (
        lambda m: held(m, 2.0), Phase.WITHDRAWING, Condition.CATHETER_JAMMED, 0.25,
    ),
    # The pump rests on the way in, 8 s long: there it can neither fail nor do harm. Then the vacuum
    # of suction takes .34 s, and a regulator has nothing to hold before it is there.
    "pump lost at rest": (
        lambda m: line(m, pump_free_ml_per_s=0.0), Phase.INSERTING, Condition.VACUUM_LOST, 9.6,
    ),
    "pump lost, valve open": (
        lambda m: line(m, pump_free_ml_per_s=0.0), Phase.SUCTIONING, Condition.VACUUM_LOST, 1.5,
    ),
    "pump at half its flow": (
        lambda m: line(m, pump_free_ml_per_s=150.0), Phase.SUCTIONING, Condition.VACUUM_LOST, 2.0,
    ),
    "regulator shut at rest": (
        lambda m: line(m, regulator_ml_per_s_per_mmhg=0.0),
        Phase.INSERTING, Condition.VACUUM_EXCEEDED, 8.94,
    ),
    # Of 15 mmHg a leak falls no faster than a free catheter's; of the whole vacuum it does.
    "leak": (
        lambda m: line(m, leak_ml_per_s_per_mmhg=10.0),
        Phase.INSERTING, Condition.VALVE_STUCK_OPEN, 0.3,
    ),
    "leak as the pre-use test ends": (
        lambda m: line(m, leak_ml_per_s_per_mmhg=10.0),
        Phase.PRELOADING, Condition.VALVE_STUCK_OPEN, 0.4,
    ),
    "clog": (
        lambda m: line(m, bore_ml_per_s_per_root_mmhg=1.5),
        Phase.SUCTIONING, Condition.LINE_CLOGGED, 6.0,
    ),
    "canister full": (
        lambda m: line(m, mmhg_per_ml=20.0 * m.line.mmhg_per_ml, pump_free_ml_per_s=0.0),
        Phase.SUCTIONING, Condition.CANISTER_FULL, 1.0,
    ),
    "slide stuck open": (
        lambda m: m._replace(valve=m.valve._replace(seal_mm=-1e9)),
        Phase.INSERTING, Condition.VALVE_STUCK_OPEN, 0.8,
    ),
    "cam seized closed": (
        lambda m: m._replace(valve_axis=m.valve_axis._replace(friction_v=1e3)),
        Phase.INSERTING, Condition.VALVE_STUCK_CLOSED, 12.0,
    ),
    "cam seized open": (
        lambda m: m._replace(valve_axis=m.valve_axis._replace(friction_v=1e3)),
        Phase.SUCTIONING, Condition.VALVE_STUCK_OPEN, 14.5,
    ),
    "drive without its current limit": (
        lambda m: held(m, 8.0)._replace(
            insertion_axis=held(m, 8.0).insertion_axis._replace(force_v=99.0)
        ),
        Phase.INSERTING, Condition.DRIVE_OVERFORCE, 0.25,
    ),
}  # fmt: skip
"""What breaks, in which phase, the trip that names it, and the longest time to it in s."""


@pytest.mark.parametrize("name", FAULTS)
def test_what_breaks_is_named_in_time(name: str) -> None:
    fault, phase, code, bound_s = FAULTS[name]
    # A jam is told as fast as the servo comes to pull as hard: here at the planned speed.
    found, columns = broken("clinical", "travel", fault, phase, paced=name not in AT_SPEED)
    assert code in found
    assert 0.0 < found[code] <= bound_s
    assert min(found, key=lambda other: found[other]) == code
    # Nothing is left in the airway that the machine itself could have drawn out.
    if code != Condition.DRIVE_OVERFORCE:
        assert columns["truth.tip_mm"][-1] < prepared("clinical", "travel").rig.site.boundary_mm


def test_a_jam_where_the_way_out_is_slow_is_named_within_half_a_second() -> None:
    found, columns = broken("clinical", "travel", lambda m: held(m, 2.0), Phase.WITHDRAWING)
    assert 0.0 < found[Condition.CATHETER_JAMMED] <= 0.5
    assert columns["truth.tip_mm"][-1] < prepared("clinical", "travel").rig.site.boundary_mm


def test_what_holds_the_catheter_fast_is_not_pulled_for_long() -> None:
    found, columns = broken("clinical", "travel", lambda m: held(m, 8.0), Phase.WITHDRAWING)
    assert found[Condition.CATHETER_JAMMED] < 0.25
    assert Condition.HEAD_NOT_FOLLOWING not in found
    assert found[Condition.WITHDRAWAL_BLOCKED] < found[Condition.CATHETER_JAMMED] + 0.5
    assert columns["commands.insertion_on"][-1] == 0.0


def test_a_carina_that_is_missed_before_the_switch_was_seen_to_work_raises_both() -> None:
    def deeper(machine: Machine) -> Machine:
        airway = machine.airway
        return machine._replace(airway=airway._replace(carina_mm=airway.carina_mm + 40.0))

    ready = prepared("clinical", "contact")
    found, columns = broken("clinical", "contact", deeper, Phase.INSERTING)
    assert set(found) == {Condition.CARINA_MISSED, Condition.CONTACT_STUCK_OPEN}
    assert columns["truth.tip_mm"].max() < ready.protocol.travel_mm
    assert columns["truth.tip_mm"][-1] < ready.rig.site.boundary_mm


@pytest.mark.parametrize("phase", [Phase.INSERTING, Phase.WITHDRAWING])
def test_a_switch_that_closes_where_nothing_is_does_so_for_no_longer_than_a_moment(
    phase: Phase,
) -> None:
    def closed(machine: Machine) -> Machine:
        return machine._replace(switch=machine.switch._replace(close_n=-1.0, open_n=-1.0))

    found, _ = broken("clinical", "contact", closed, phase)
    code = min(found, key=lambda other: found[other])
    assert code in (Condition.CONTACT_STUCK_CLOSED, Condition.CONTACT_TIME)
    assert found[Condition.CONTACT_STUCK_CLOSED] < 2.5
