"""Cycles over a bus, in simulated time: what of it they stand, and what they do where not."""

from functools import cache

import pytest

from opensuction.kernel.interface import START
from opensuction.kernel.vocabulary import Phase
from opensuction.oracle import exposure, harm
from opensuction.oracle.exposure import PatientExposure
from opensuction.safety.condition import Condition
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import closed_loop, outcome, trace, wiring
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns
from opensuction.simulation.wiring import Wiring
from opensuction.twin import preset
from opensuction.twin.fault import link
from opensuction.twin.fault.bus import PLAUSIBLE, Bus
from opensuction.twin.machine import fail_safe, machine

NONE = Bus(0.0, 0.0, 0.0)


@cache
def prepared() -> Prepared:
    return cycle_run.prepare(resolution.resolve(CycleChoice(RigChoice(patient="neonate", seed=3))))


def played(carrier: Bus, seed: int) -> tuple[Columns, PatientExposure]:
    made = prepared()
    home_mm = made.loop.controller.limits.park_head_mm
    loop = made.loop._replace(machine=preset.limit_rack(made.loop.machine, home_mm))
    wires = link.on_bus(link.healthy(seed), carrier, DT_S)
    messages = wiring.start(machine.read(loop.machine, made.start.machine), made.start.tick)
    table = trace.rows(30.0)
    _, ticks = closed_loop.run(
        loop,
        made.start,
        START,
        table,
        Wiring(wires, fail_safe.of(loop.machine, home_mm)),
        messages,
    )
    columns = trace.by_name(table[:ticks])
    borne = exposure.measure(loop.machine, columns)
    assert harm.find(loop.machine, borne, loop.controller.limits.cap_mm) == ()
    return columns, borne


@pytest.mark.parametrize(
    "carrier",
    [PLAUSIBLE, Bus(0.002, 0.001, 0.001), Bus(0.0005, 0.0003, 0.05)],
    ids=["plausible", "slow", "lossy"],
)
def test_a_cycle_is_done_over_a_bus_that_keeps_its_time_and_nobody_need_be_told(
    carrier: Bus,
) -> None:
    at_once = played(NONE, 1)[1]
    for seed in (1, 2, 3):
        columns, borne = played(carrier, seed)
        assert Phase.SUCTIONING in columns["phase"]
        assert columns["phase"][-1] == Phase.PARKED
        assert not (columns["phase"] == Phase.ABORTING).any()
        assert outcome.told(columns) == []
        assert borne.deepest_mm == pytest.approx(at_once.deepest_mm, abs=0.1)
        assert borne.in_airway_s == pytest.approx(at_once.in_airway_s, abs=0.05)


def test_a_bus_that_is_too_slow_for_a_servo_breaks_the_cycle_off_and_says_why() -> None:
    for seed in (1, 2, 3):
        columns, borne = played(Bus(0.015, 0.01, 0.001), seed)
        assert columns["phase"][-1] == Phase.HALTED
        assert not borne.inside_at_end
        told = {one.condition for one in outcome.told(columns)}
        assert told >= {Condition.MESSAGE_LATE, Condition.HEAD_READING_INVALID}
