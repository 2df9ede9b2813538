"""Cycles in which nothing is broken, and people who press what they like."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from opensuction.control.compensation import CompensationKind
from opensuction.controller import controller
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.interlocks import NEW_CATHETER_S
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.trace import Columns, phase_spans, power_up
from opensuction.twin import preset
from tests.columns_of_rows import ColumnsOfRows
from tests.controller.drive import (
    ABORT,
    IDENTIFY,
    NAN,
    NEVER,
    RESET,
    START,
    at_rest,
    phases,
    rig,
    run,
    simulate,
)
from tests.controller.invariant import assert_held, trips

every_kind = pytest.mark.parametrize("kind", CompensationKind)
EXACT = CompensationKind.EXACT_INVERSE

CYCLE = [
    Phase.CHECKING,
    Phase.PRELOADING,
    Phase.INSERTING,
    Phase.OPENING,
    Phase.SUCTIONING,
    Phase.WITHDRAWING,
    Phase.CLOSING,
    Phase.PARKED,
]


def assert_out(columns: Columns, loop: Loop, last: int = -1) -> None:
    """In the last tick the tip is out, the valve closed, the pump off and the line vented."""
    home_mm = loop.controller.plan.motion.park_head_mm
    assert columns["truth.head_mm"][last] == pytest.approx(home_mm, abs=0.75)
    # Without compensation the parked tip is 3.2 mm from the reference.
    assert columns["truth.tip_mm"][last] < 4.5
    assert columns["truth.valve_open_ratio"][last] == 0.0
    assert columns["commands.pump_on"][last] == 0.0
    assert columns["readings.line_vacuum_mmhg"][last] < 5.0


@every_kind
def test_a_cycle_runs_through_its_phases_and_holds_every_invariant(kind: CompensationKind) -> None:
    loop, _ = at_rest(kind)
    _, columns = simulate(kind, 46.0, {0.0: START})
    assert phases(columns) == CYCLE
    assert trips(columns) == set()
    assert_held(columns, loop)
    assert_out(columns, loop)


def test_a_cycle_keeps_its_plan() -> None:
    loop, _ = at_rest(EXACT)
    _, columns = simulate(EXACT, 46.0, {0.0: START})
    spans = {span.phase: span for span in phase_spans(columns)}
    plan = loop.controller.plan
    dwell = spans[Phase.WITHDRAWING].start_s - spans[Phase.INSERTING].start_s - 10.045
    assert dwell == pytest.approx(plan.dwell_s, abs=2 * DT_S)
    gone = spans[Phase.WITHDRAWING].end_s - spans[Phase.WITHDRAWING].start_s
    assert gone == pytest.approx(10.045, abs=0.3)  # the servo settles
    opened = (columns["truth.valve_open_ratio"] > 0.0) & (columns["phase"] != Phase.CHECKING)
    sucking = np.count_nonzero(opened) * DT_S
    assert sucking <= 9.0 + 10.045 + 2.0  # planner's negative pressure
    tip = columns["truth.tip_mm"][columns["phase"] == Phase.SUCTIONING]
    # A modified Dahl model is .8 mm off this plant; it settles in the dwell.
    assert tip[0] == pytest.approx(90.0, abs=1.0)


@every_kind
def test_a_second_cycle_is_as_good_as_the_first(kind: CompensationKind) -> None:
    _, columns = simulate(kind, 92.0, {0.0: START, 46.0: START})
    assert phases(columns) == [*CYCLE, *CYCLE]
    first, second = columns["truth.tip_mm"][:39000], columns["truth.tip_mm"][46000:85000]
    # Creep of the polymer (0.1 mm) is left over from the first.
    assert first.max() == pytest.approx(second.max(), abs=0.15)


@every_kind
def test_a_start_while_something_goes_on_is_ignored(kind: CompensationKind) -> None:
    often = dict.fromkeys(np.round(np.arange(0.1, 35.6, 0.1), 1), START | IDENTIFY | RESET)
    _, pressed = simulate(kind, 35.6, {0.0: START} | often)
    _, left_alone = simulate(kind, 35.6, {0.0: START})
    for name, values in left_alone.items():
        np.testing.assert_array_equal(pressed[name], values, err_msg=name)


def test_a_flood_of_every_button_does_nothing_but_stop() -> None:
    loop, _ = at_rest(EXACT)
    everything = dict.fromkeys(np.round(np.arange(0.0, 20.0, DT_S), 3), 15)
    _, columns = simulate(EXACT, 20.0, everything)
    assert phases(columns) == [Phase.PARKED]
    _, columns = simulate(EXACT, 46.0, {0.0: START} | {t + 12.0: b for t, b in everything.items()})
    assert phases(columns)[-2:] == [Phase.ABORTING, Phase.HALTED]
    assert_held(columns, loop)


def test_starting_again_and_again_is_one_cycle_after_another() -> None:
    loop, _ = at_rest(EXACT)
    impatient = dict.fromkeys(np.round(np.arange(0.0, 82.0, 2.0 * DT_S), 3), START)
    _, columns = simulate(EXACT, 82.0, impatient)
    assert phases(columns)[: 2 * len(CYCLE)] == [*CYCLE, *CYCLE]
    assert_held(columns, loop)


class Sound(NamedTuple):
    """A cycle that nobody stops, up to `SOUND_TICKS`."""

    states: dict[int, LoopState]
    """Before some ticks."""
    rows: NDArray[np.float64]


SOUND_TICKS = 36_000
FIRST, EVERY = 10, 300
"""Ticks at which the cycle is stopped: the first one, and how far apart they are."""
PARTS = 16
"""So many tests share these instants."""


@lru_cache(maxsize=1)
def sound(kind: CompensationKind) -> Sound:
    loop, state = at_rest(kind)
    table = np.empty((SOUND_TICKS, len(COLUMNS)))
    states, done, ticks = {}, 0, FIRST
    while done < SOUND_TICKS:
        rows = table[done : done + ticks]
        buttons = np.zeros(len(rows), dtype=np.int64)
        buttons[0] = START if done == 0 else 0
        state = run(loop, state, buttons, NEVER, rows)
        done, ticks = done + ticks, EVERY
        states[done] = state
    return Sound(states, table)


def stopped(
    kind: CompensationKind, tick: int, buttons: dict[float, int], seconds: float
) -> Columns:
    """A cycle with buttons pressed some time (s) after a tick, to its end."""
    before, ticks = sound(kind), round(seconds / DT_S)
    table = np.empty((tick + ticks, len(COLUMNS)))
    table[:tick] = before.rows[:tick]
    pressed = np.zeros(ticks, dtype=np.int64)
    for time_s, bits in buttons.items():
        pressed[round(time_s / DT_S)] = bits
    run(at_rest(kind)[0], before.states[tick], pressed, NEVER, table[tick:])
    table[:, COLUMNS.index("time_s")] = np.arange(len(table)) * DT_S
    return ColumnsOfRows(table)


def moments() -> list[Any]:
    """Which sixteenths of the instants for which kind: all for the two that people use most.

    The others have every other one in turn, so that each phase and each instant is stopped in.
    One of each kind is in `make test`, another one for the next kind; the others are long runs.
    """

    def marks(kind: CompensationKind, part: int) -> tuple[pytest.MarkDecorator, ...]:
        return () if part == 2 * kind + kind % 2 else (pytest.mark.soak,)

    often = (EXACT, CompensationKind.PREVIEW)
    return [
        pytest.param(kind, part, marks=marks(kind, part))
        for kind in CompensationKind
        for part in range(PARTS)
        if kind in often or (kind + part) % 2 == 0
    ]


@pytest.mark.requirement("OS-R26")
@pytest.mark.parametrize(("kind", "part"), moments())
def test_a_person_can_stop_it_at_any_time_and_go_on_afterwards(
    kind: CompensationKind, part: int
) -> None:
    loop, _ = at_rest(kind)
    stopped_in = set()
    for tick in range(FIRST + EVERY * part, SOUND_TICKS, PARTS * EVERY):
        columns = stopped(kind, tick, {0.0: ABORT, 20.0: RESET, 21.0: START}, 61.0)
        order = phases(columns)
        assert order[-(len(CYCLE) + 3) :] == [Phase.ABORTING, Phase.HALTED, Phase.PARKED, *CYCLE]
        assert trips(columns) == set()
        assert_held(columns, loop)
        assert_out(columns, loop, tick + 20_000 - 1)
        assert_out(columns, loop)
        stopped_in.add(order[-(len(CYCLE) + 4)])
    assert {Phase.INSERTING, Phase.SUCTIONING, Phase.WITHDRAWING} <= stopped_in


def test_a_stop_while_identifying_comes_out_too() -> None:
    loop, _ = at_rest(CompensationKind.NONE)
    for time_s in (0.5, 5.0, 10.0, 16.0):
        _, columns = simulate(CompensationKind.NONE, 40.0, {0.0: IDENTIFY, time_s: ABORT})
        assert phases(columns) == [Phase.IDENTIFYING, Phase.ABORTING, Phase.HALTED]
        assert_held(columns, loop)
        assert_out(columns, loop)


def test_a_stop_in_the_dwell_keeps_suction_until_the_tip_is_out() -> None:
    _, columns = simulate(EXACT, 46.0, {0.0: START, 21.0: ABORT})
    inside = (columns["time_s"] > 21.0) & (columns["truth.tip_mm"] > 1.0)
    assert columns["truth.valve_open_ratio"][inside].min() > 0.9
    assert columns["truth.tip_vacuum_mmhg"][inside].min() > 60.0
    # 90 mm and the gap at 17 mm/s, and its ramps.
    assert np.count_nonzero(inside) * DT_S < 7.0


@pytest.mark.requirement("OS-R25")
@pytest.mark.parametrize("head_mm", [2.0, 30.0, 90.0])
def test_powered_up_with_the_catheter_in_it_comes_out_unasked_and_waits(head_mm: float) -> None:
    """Start and reset are pressed meanwhile, by somebody who cannot wait."""
    loop, _ = at_rest(EXACT)
    away = preset.park(loop.machine, rig().values, head_mm, seed=1, run=3)
    start = power_up(loop, away, NEW_CATHETER_S)
    pressed = {0.0: START, 0.1: RESET, 20.0: START, 21.0: RESET, 22.0: START}
    _, columns = simulate(EXACT, 67.0, pressed, start=start)
    assert phases(columns) == [Phase.ABORTING, Phase.HALTED, Phase.PARKED, *CYCLE]
    assert trips(columns) == set()
    assert_held(columns, loop)
    out = columns["truth.head_mm"][columns["phase"] == Phase.ABORTING]
    assert np.diff(out).max() < 0.01
    # 90 mm and the gap at 17 mm/s, and its ramps.
    assert out.size * DT_S < 8.0


@pytest.mark.requirement("OS-R25")
@pytest.mark.parametrize("head_mm", [-40.0, -8.0])
def test_powered_up_behind_its_home_it_waits_for_a_reset(head_mm: float) -> None:
    """Nothing goes in unasked."""
    loop, _ = at_rest(EXACT)
    away = preset.park(loop.machine, rig().values, head_mm, seed=1, run=3)
    start = power_up(loop, away, NEW_CATHETER_S)
    _, columns = simulate(
        EXACT, 66.0, {0.0: START, 1.0: RESET, 20.0: RESET, 21.0: START}, start=start
    )
    assert phases(columns) == [
        Phase.HALTED,
        Phase.ABORTING,
        Phase.HALTED,
        Phase.PARKED,
        *CYCLE,
    ]
    assert trips(columns) == set()
    assert_held(columns, loop)
    waiting = columns["truth.head_mm"][:1000]
    assert np.ptp(waiting) < 0.1  # backlash of the gear


def test_a_start_that_is_held_asks_once() -> None:
    """An hour's thumb on the button is one cycle; let go and pressed again it is another."""
    held = dict.fromkeys((np.arange(80_000) * DT_S).tolist(), START)
    _, columns = simulate(EXACT, 80.0, held)
    assert phases(columns) == CYCLE
    released = {time_s: bits for time_s, bits in held.items() if round(time_s / DT_S) != 50_000}
    _, columns = simulate(EXACT, 80.0, released)
    assert phases(columns)[: len(CYCLE) + 1] == [*CYCLE, Phase.CHECKING]


def test_powered_up_blind_it_halts_and_comes_out_once_it_sees() -> None:
    """The head is taken to be as deep as can be, and is found elsewhere."""
    loop, _ = at_rest(EXACT)
    away = preset.park(loop.machine, rig().values, 60.0, seed=1, run=3)
    seeing = power_up(loop, away, NEW_CATHETER_S)
    blind = seeing._replace(controller=controller.start(loop.controller, NAN, NEW_CATHETER_S))
    assert blind.controller.core.procedure.phase == Phase.HALTED
    infinite = controller.start(loop.controller, -float("inf"), NEW_CATHETER_S)
    assert infinite.core.procedure.phase == Phase.HALTED
    _, columns = simulate(EXACT, 60.0, {}, start=blind)
    assert phases(columns) == [Phase.HALTED]
    assert {code.name for code in trips(columns)} == {"HEAD_NOT_FOLLOWING"}
    assert columns["truth.head_mm"][-1] == pytest.approx(
        loop.controller.limits.park_head_mm, abs=0.2
    )


@pytest.mark.parametrize("seed", [2, 3, 4])
@every_kind
def test_other_machines_hold_the_invariants_too(kind: CompensationKind, seed: int) -> None:
    from opensuction.procedure.planning.protocol import PAPER

    other = rigs.rig("bench", seed)
    # Calibrated on another machine of its kind, as after a change of catheter.
    calibration = rigs.identify(rig()).calibration
    loop, start = rigs.assemble(other, PAPER, kind, calibration, run=2)
    _, columns = simulate(kind, 46.0, {0.0: START}, start=start, loop=loop)
    assert trips(columns) == set()
    assert_held(columns, loop)
