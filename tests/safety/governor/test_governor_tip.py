"""Governor and a catheter that is not where its head has it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import Readings, Setpoints
from opensuction.safety import limits as safety_limits
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode_trips
from opensuction.safety.governor import governor
from opensuction.safety.governor.governor import NONE as NOT_FORCED
from opensuction.safety.governor.governor import GovernorState
from opensuction.safety.handling import Reaction
from opensuction.safety.watch import watch
from tests.safety.watchdog import (
    DT_S,
    INF,
    LIMITS,
    PARK_MM,
    Tick,
    at,
    changed,
    first,
    run,
    sound,
    staying,
    tripped,
)

BARRED = LIMITS._replace(mouth_mm=6.0, in_airway_s=INF, negative_pressure_s=INF, withdrawal_s=INF)
"""With a light barrier a little beyond the deepest that a parked tip can be."""
TREMBLE_MMHG = 1e-6
"""A line that holds vacuum never reads the same twice."""


def seeing(clear: bool, head_mm: float, seconds: float) -> list[Tick]:
    """A head that stays, its light barrier clear or not."""

    def report(time_s: float, _head_mm: float) -> Readings:
        vacuum = 10.0 + TREMBLE_MMHG * (round(time_s / DT_S) % 2)
        return sound(head_mm)._replace(mouth_clear=clear, line_vacuum_mmhg=vacuum)

    return run(seconds, lambda _: staying(head_mm), report, at(head_mm), limits=BARRED)


@pytest.mark.requirement("OS-R17")
def test_a_catheter_that_is_not_at_the_mouth_where_it_must_be_may_have_lost_its_tip() -> None:
    ticks = seeing(True, 50.0, 0.2)
    found = first(ticks, Condition.TIP_DETACHED)
    assert found.time_s == pytest.approx(0.05, abs=0.002)
    assert found.verdict.reaction == Reaction.WITHDRAW
    assert found.verdict.insertion_on
    # A vacuum holds what hangs at the tip.
    assert found.allowed.pump_on
    assert tripped(seeing(False, 50.0, 0.2)) == set()


@pytest.mark.requirement("OS-R17")
def test_a_catheter_at_the_mouth_with_its_head_home_is_told_and_nothing_holds_the_head() -> None:
    ticks = seeing(False, PARK_MM, 1.1)
    found = first(ticks, Condition.HEAD_SENSORS_DISAGREE)
    assert found.time_s == pytest.approx(0.2, abs=0.002)
    assert not found.allowed.pump_on
    # It is drawn further back for a second, in which this head does not move.
    assert ticks[400].verdict.insertion_on
    # By a reading that may be adrift it would be driven in again.
    assert not ticks[-1].verdict.insertion_on
    assert tripped(seeing(True, PARK_MM, 0.4)) == set()


@given(head_mm=st.floats(PARK_MM, 60.0), clear=st.booleans())
def test_the_barrier_is_held_against_the_tip_only_where_the_tip_is_known(
    head_mm: float, clear: bool
) -> None:
    tip = safety_limits.assume_anywhere(BARRED.tip, head_mm)
    out = safety_limits.deepest_mm(BARRED.tip, tip) < BARRED.mouth_mm - 1.0
    within = safety_limits.shallowest_mm(BARRED.tip, tip) > BARRED.mouth_mm + 1.0
    seen = seeing(clear, head_mm, 0.002)[-1].state.watch.durations
    assert (seen.absent_s > 0.0) == (clear and within)
    assert (seen.remaining_s > 0.0) == (not clear and out)


@pytest.mark.parametrize("clear", [True, False])
@pytest.mark.parametrize("head_mm", [PARK_MM, 50.0])
def test_a_bench_without_a_mouth_has_nothing_to_compare(head_mm: float, clear: bool) -> None:
    def report(_time_s: float, _head_mm: float) -> Readings:
        return sound(head_mm)._replace(mouth_clear=clear)

    limits = BARRED._replace(mouth_mm=INF)
    ticks = run(0.3, lambda _: staying(head_mm), report, at(head_mm), limits=limits)
    assert tripped(ticks) == set()


# The line of the switch.


@pytest.mark.requirement("OS-R17")
@pytest.mark.parametrize(
    ("head_mm", "bus", "parted"), [(50.0, True, True), (50.0, False, False), (PARK_MM, True, False)]
)
def test_a_line_that_is_cut_inside_while_the_bus_lives_may_be_a_tip_that_parted(
    head_mm: float, bus: bool, parted: bool
) -> None:
    def report(time_s: float, _head_mm: float) -> Readings:
        cut = time_s >= 0.01
        read = sound(head_mm)._replace(contact_valid=not cut)
        return read._replace(cam_valid=bus or not cut, vacuum_valid=bus or not cut)

    limits = LIMITS._replace(in_airway_s=INF, withdrawal_s=INF)
    found = tripped(run(0.05, lambda _: staying(head_mm), report, at(head_mm), limits=limits))
    assert Condition.CONTACT_READING_INVALID in found
    assert (Condition.TIP_DETACHED in found) == parted


# Both sensors away from the motor.


def drifting(mm_per_s: float, seconds: float) -> tuple[float, GovernorState]:
    """A motor at rest and sensors that drift: when that is told (inf: not), and the state."""
    limits = LIMITS._replace(in_airway_s=INF, withdrawal_s=INF)
    state, told_s = at(50.0), INF
    for tick in range(round(seconds / DT_S)):
        head_mm = 50.0 + mm_per_s * tick * DT_S
        read = sound(head_mm)
        state = changed(state, {"last.insertion_on": True, "last.head_mm": head_mm})
        vote = governor.locate(limits, state, read, 0.0, DT_S)
        state, _, verdict = governor.step(limits, state, staying(head_mm), read, vote, False, DT_S)
        trips = decode_trips(verdict.trips)
        if told_s == INF and Condition.HEAD_SENSORS_DISAGREE in trips:
            told_s = tick * DT_S
    return told_s, state


@pytest.mark.requirement("OS-R45")
@pytest.mark.parametrize(
    ("mm_per_s", "least_s", "most_s"),
    [(-2.0, 1.2, 1.4), (2.0, 1.2, 1.4), (-0.8, 1.2, 2.0), (-0.6, INF, INF), (0.6, INF, INF)],
)
def test_sensors_that_drift_together_are_told_by_the_motor(
    mm_per_s: float, least_s: float, most_s: float
) -> None:
    assert least_s <= drifting(mm_per_s, 2.5)[0] <= most_s


# A withdrawal whose readings repeat themselves.


@pytest.mark.requirement("OS-R45")
@pytest.mark.parametrize(("ticks", "told"), [(49, True), (50, False)])
def test_what_a_bus_repeats_is_no_jam(ticks: int, told: bool) -> None:
    seen = watch.start(LIMITS, 50.0, read=True)
    held = changed(seen, {"durations.jammed_s": 0.2, "bus.stale_ticks": ticks})
    after = governor.step_withdrawal(NOT_FORCED, held, True, DT_S)
    assert (after.blocked_s > 0.0) == told
    assert (after.unseen_s > 0.0) == (not told)


def test_only_a_line_with_vacuum_tells_that_all_readings_repeat_themselves() -> None:
    def count(vacuum_mmhg: float) -> int:
        still = lambda _time_s, _head_mm: sound(50.0)._replace(line_vacuum_mmhg=vacuum_mmhg)  # noqa: E731
        ticks = run(0.02, lambda _: staying(50.0), still, at(50.0))
        return ticks[-1].state.watch.bus.stale_ticks

    assert count(0.5) == 0
    assert count(50.0) >= 18


# Under vacuum counts what the head has gone in since.


def beyond(head_mm: float, started_mm: float) -> int:
    """Ticks of running away of a head 0.6 mm beyond its command, the valve just open."""
    proposal = Setpoints(49.4, 0.0, True, True, True, 120.0)
    state = changed(
        at(head_mm),
        {
            "last.valve_open": True,
            "last.head_mm": 49.4,
            "watch.advance.head_mm": 49.4,
            "watch.advance.coast_mm_per_s": 0.0,
            "watch.suction_start_mm": started_mm,
        },
    )
    read = sound(head_mm)._replace(cam_rad=0.2)
    vote = governor.locate(LIMITS, state, read, 0.0, DT_S)
    state, _, _ = governor.step(LIMITS, state, proposal, read, vote, False, DT_S)
    return int(state.watch.runaway_ticks)


@pytest.mark.requirement("OS-R45")
def test_a_head_that_rings_as_the_valve_opens_does_not_run_away() -> None:
    assert beyond(50.0, 50.0) == 0
    assert beyond(50.0, 49.8) == 0
    assert beyond(50.0, 49.6) == 1
