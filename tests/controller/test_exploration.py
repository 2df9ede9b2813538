"""Anything may be pressed, read and set, in any order: no invariant of the controller breaks.

Hypothesis walks at random through machines, approaches and protocols, buttons, sensors that lie or
fall silent, late ticks and restarts, and shrinks what breaks something to the few steps it takes.
The sound machine of the twin stays behind the lying sensors, so that the walk gets somewhere.
"""

import math
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from opensuction.control.compensation import CompensationKind
from opensuction.controller import controller
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import NO_REQUESTS, Requests
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.transition import TRANSITIONS
from opensuction.procedure.planning.protocol import PAPER
from opensuction.safety.handling import Reaction
from opensuction.simulation import closed_loop, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation import wiring as wirings
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.injection import invariant as held
from opensuction.simulation.rig import Identification, Rig
from opensuction.simulation.trace import Columns
from opensuction.simulation.wiring import Wiring
from opensuction.twin.fault import link
from opensuction.twin.fault.link import Link
from opensuction.twin.fault.reading_fault import FOR_GOOD, Channel, Mode, ReadingFault
from opensuction.twin.machine import fail_safe, machine

QUIET = (Phase.PARKED, Phase.HALTED, Phase.OUT_OF_SERVICE)
"""Phases in which nothing is sucked."""
STEPS = {(before, after) for (before, _), after in TRANSITIONS.items()}
"""Where a phase may be followed by another."""

LOOKED_AT = tuple(dict.fromkeys((*held.JUDGED, "phase", "verdict.trips", "verdict.reaction")))
"""Columns."""

numbers = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-100.0, 200.0)
durations = st.integers(1, 1500) | st.integers(1, 12)
"""Ticks: both long enough to get somewhere and short enough to meet a transition."""


@cache
def identified_rigs() -> tuple[tuple[Rig, Identification], ...]:
    """The nominal bench and a drawn one, each identified."""
    found = (rigs.rig("bench", 1, nominal=True), rigs.rig("bench", 7, nominal=False))
    return tuple((rig, rigs.identify(rig)) for rig in found)


def leaves(record: Any) -> Iterator[float]:
    """Every number of a nested record."""
    if isinstance(record, tuple):
        for field in record:
            yield from leaves(field)
    elif isinstance(record, np.ndarray):
        yield from record.ravel().tolist()
    else:
        yield record


class Exploration(RuleBasedStateMachine):
    """A controller in the hands of anybody, with sensors that say anything."""

    @initialize(
        which=st.integers(0, 1),
        kind=st.sampled_from((CompensationKind.EXACT_INVERSE, CompensationKind.PREVIEW)),
        by_contact=st.booleans(),
        travel_mm=numbers | st.floats(5.0, 80.0),
        margin_mm=numbers | st.floats(0.0, 40.0),
        dwell_s=numbers | st.floats(0.0, 12.0),
        speed_mm_per_s=numbers | st.floats(1.0, 20.0),
        vacuum_mmhg=numbers | st.floats(40.0, 160.0),
    )
    def set_up(
        self,
        which: int,
        kind: CompensationKind,
        by_contact: bool,
        travel_mm: float,
        margin_mm: float,
        dwell_s: float,
        speed_mm_per_s: float,
        vacuum_mmhg: float,
    ) -> None:
        """Settings, valid or not: those that cannot be meant are refused, and the paper's taken."""
        rig, identification = identified_rigs()[which]
        if by_contact:
            rig = rigs.with_carina(rig, 65.0)
        asked = PAPER._replace(
            travel_mm=travel_mm,
            cap_mm=travel_mm + margin_mm,
            dwell_s=dwell_s,
            insertion_mm_per_s=speed_mm_per_s,
            vacuum_mmhg=vacuum_mmhg,
        )
        calibration = identification.calibration
        try:
            loop, start = rigs.assemble(rig, asked, kind, calibration, 2, by_contact)
        except InputError:
            loop, start = rigs.assemble(rig, PAPER, kind, calibration, 2, by_contact)
        self.begin(loop, start)

    def begin(self, loop: Loop, start: LoopState) -> None:
        self.loop, self.state = loop, start
        self.link: Link = link.healthy(1)
        home_mm = loop.controller.limits.park_head_mm
        self.watchdog = fail_safe.of(loop.machine, home_mm)
        self.messages = wirings.start(machine.read(loop.machine, start.machine), start.tick)
        self.trace: Columns = {}
        self.phase = int(start.controller.core.procedure.phase)

    def play(self, ticks: int, requests: Requests = NO_REQUESTS) -> None:
        table = trace.rows(ticks * DT_S)
        wiring = Wiring(link=self.link, watchdog=self.watchdog)
        done = 0
        while done < ticks:
            self.state, ran = closed_loop.run(
                self.loop, self.state, requests, table[done:], wiring, self.messages
            )
            requests = NO_REQUESTS
            done += ran
        self.trace = trace.copy_columns(table, LOOKED_AT)

    @rule(ticks=durations)
    def wait(self, ticks: int) -> None:
        self.play(ticks)

    @rule(pressed=st.sets(st.sampled_from(Requests._fields), min_size=1), ticks=durations)
    def press(self, pressed: set[str], ticks: int) -> None:
        self.play(ticks, NO_REQUESTS._replace(**dict.fromkeys(pressed, True)))

    @rule(seconds=st.sampled_from((4.0, 10.0, 20.0)))
    def run_a_cycle(self, seconds: float) -> None:
        """What people do most, so that the walk often stands in the middle of a cycle."""
        self.play(round(seconds / DT_S), NO_REQUESTS._replace(start=True))

    @rule(
        channel=st.sampled_from([channel for channel in Channel if channel != Channel.NONE]),
        mode=st.sampled_from(Mode),
        strength=numbers,
        anchor=numbers,
        second=st.booleans(),
    )
    def falsify(
        self, channel: Channel, mode: Mode, strength: float, anchor: float, second: bool
    ) -> None:
        stream = self.link.stream
        fault = ReadingFault(
            channel=int(channel),
            mode=int(mode),
            strength=strength,
            anchor=anchor,
            begin_tick=self.state.tick,
            there_ticks=FOR_GOOD,
            period_ticks=0,
            stream=stream,
        )
        faulty = self.link._replace(second=fault) if second else self.link._replace(first=fault)
        self.relink(faulty)

    @rule(repeated=st.booleans(), late_ticks=st.integers(0, 2000), lost=st.floats(0.0, 1.0))
    def trouble_the_messages(self, repeated: bool, late_ticks: int, lost: float) -> None:
        self.relink(
            self.link._replace(
                readings_repeated=repeated,
                late_until_tick=self.state.tick + late_ticks,
                reading_lost_share=lost,
            )
        )

    @rule()
    def mend(self) -> None:
        self.relink(link.healthy(1))

    def relink(self, changed: Link) -> None:
        self.link = changed
        self.trace = {}  # nothing new to judge

    @rule(head_mm=numbers, known=st.booleans())
    def restart(self, head_mm: float, known: bool) -> None:
        """A new controller; what its encoder reads may be anything."""
        if known:
            head_mm = machine.read(self.loop.machine, self.state.machine).head_mm
        fresh = controller.start(self.loop.controller, head_mm, 0.0)
        self.state = self.state._replace(controller=fresh)
        self.phase = int(fresh.core.procedure.phase)
        self.trace = {}

    @precondition(lambda self: bool(self.trace))
    @invariant()
    def commands_hold(self) -> None:
        assert held.command_side(self.trace, self.loop.controller) == []

    @precondition(lambda self: bool(self.trace))
    @invariant()
    def phases_follow_the_table(self) -> None:
        phases = [Phase(self.phase), *(Phase(int(code)) for code in self.trace["phase"])]
        changes = {(a, b) for a, b in pairwise(phases) if a != b}
        assert changes <= STEPS
        self.phase = int(phases[-1])

    @precondition(lambda self: bool(self.trace))
    @invariant()
    def trips_are_answered(self) -> None:
        tripped = self.trace["verdict.trips"] != 0.0
        assert (self.trace["verdict.reaction"][tripped] >= Reaction.WITHDRAW).all()
        assert (self.trace["verdict.reaction"][~tripped] < Reaction.WITHDRAW).all()
        # A phase hears of a trip in the tick after.
        lasting = tripped[1:] & tripped[:-1]
        answered = (Phase.ABORTING, Phase.HALTED, Phase.OUT_OF_SERVICE)
        assert np.isin(self.trace["phase"][1:][lasting], answered).all()

    @precondition(lambda self: bool(self.trace))
    @invariant()
    def rest_is_quiet(self) -> None:
        quiet = np.isin(self.trace["phase"], QUIET)
        assert not self.trace["commands.pump_on"][quiet].any()
        assert not self.trace["commands.vacuum_mmhg"][quiet].any()
        out = self.trace["phase"] == Phase.OUT_OF_SERVICE
        assert not self.trace["commands.insertion_on"][out].any()
        assert not self.trace["commands.valve_on"][out].any()

    @precondition(lambda self: bool(self.trace))
    @invariant()
    def what_is_remembered_are_numbers(self) -> None:
        state = self.state.controller
        procedure = state.core.procedure
        assert procedure.limit_s > 0.0  # infinite where a person acts
        bounded = state.core._replace(procedure=procedure._replace(limit_s=0.0))
        assert all(math.isfinite(value) for value in leaves(state._replace(core=bounded)))


Exploration.TestCase.settings = settings(
    deadline=None,
    max_examples=settings().max_examples,
    stateful_step_count=25,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
TestExploration = Exploration.TestCase
