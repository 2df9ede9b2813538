"""The pre-use test on its own: what each item waits for, and what its failure says."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import Readings
from opensuction.procedure.cycle import check
from opensuction.procedure.cycle.check import ORDER, CheckItem, CheckSeen, CheckState
from opensuction.procedure.planning.protocol import plan_check
from tests.procedure.cycle.test_progress import AT_HOME
from tests.procedure.planning.test_planner import BENCH
from tests.settled import settled

DT_S = 0.001
NAN = float("nan")
PLAN = plan_check(120.0, BENCH.relief_mmhg, BENCH.jog_mm, BENCH.cam_open_rad / BENCH.cam_rad_per_s)
RESTING = CheckSeen(
    home=True, settled=True, off_park_mm=0.0, settle_mm=0.25, opened=False, closed=True
)
VENTED = AT_HOME._replace(line_vacuum_mmhg=0.0)


def answer(state: CheckState) -> tuple[Readings, CheckSeen]:
    """What a sound machine reports for the item that is being tested."""
    seen = RESTING._replace(
        off_park_mm=PLAN.jog_mm if check.is_jogging(state.item) else 0.0,
        opened=check.is_stroking(state.item),
        closed=not check.is_stroking(state.item),
    )
    wanted = check.set_point_mmhg(PLAN, state.item)
    return AT_HOME._replace(line_vacuum_mmhg=min(wanted, PLAN.relief_mmhg) + 3.0), seen


step = settled(check.step)


def at(item: CheckItem) -> CheckState:
    """Sound until an item begins."""
    state = check.begin()
    while state.item != item:
        state = step(PLAN, state, *answer(state), DT_S)
    return state


def failure(item: CheckItem, seen: dict[str, Any], **readings: Any) -> CheckItem:
    """What fails when an item never sees what it waits for."""
    state = at(item)
    ticks = 0
    while state.item == item and state.failed == 0:
        sound, view = answer(state)
        state = step(PLAN, state, sound._replace(**readings), view._replace(**seen), DT_S)
        ticks += 1
    assert ticks * DT_S <= PLAN.limits_s[item] + 2 * DT_S
    return CheckItem(state.failed)


def test_a_sound_machine_passes_every_item_in_order() -> None:
    order: list[CheckItem] = []
    state, ticks = check.begin(), 0
    while state.item != CheckItem.NONE:
        if not order or order[-1] != state.item:
            order.append(CheckItem(state.item))
        state = step(PLAN, state, *answer(state), DT_S)
        ticks += 1
    assert tuple(order) == ORDER
    assert state.failed == CheckItem.NONE
    assert ticks * DT_S < 2.5  # what waiting alone takes; motion comes on top


@pytest.mark.requirement("OS-R20")
@pytest.mark.parametrize(
    ("item", "seen"),
    [
        (CheckItem.HEAD_HOME, {"home": False}),
        (CheckItem.HEAD_HOME, {"settled": False}),
        (CheckItem.HEAD_ADVANCES, {"off_park_mm": 0.0}),
        (CheckItem.HEAD_RETURNS, {"off_park_mm": 2.0}),
        (CheckItem.VALVE_OPENS, {"opened": False}),
        (CheckItem.VALVE_CLOSES, {"closed": False}),
    ],
)
def test_an_item_fails_when_its_motion_does_not_come(item: CheckItem, seen: dict[str, Any]) -> None:
    assert failure(item, seen) == item


@pytest.mark.parametrize(
    ("item", "vacuum_mmhg"),
    [
        (CheckItem.LINE_VENTED, 20.0),
        (CheckItem.VALVE_OPENS, 20.0),
        (CheckItem.VACUUM_BUILDS, 107.0),
        (CheckItem.RELIEF_OPENS, 178.0),
        (CheckItem.RELIEF_OPENS, 124.0),
        (CheckItem.REGULATOR_HOLDS, 153.0),
        (CheckItem.REGULATOR_HOLDS, 60.0),
    ],
)
def test_an_item_fails_with_the_wrong_vacuum(item: CheckItem, vacuum_mmhg: float) -> None:
    assert failure(item, {}, line_vacuum_mmhg=vacuum_mmhg) == item


@pytest.mark.parametrize(("lost", "passes"), [(0.04, True), (0.06, False)])
def test_a_line_may_lose_five_percent_in_a_second(lost: float, passes: bool) -> None:
    state = at(CheckItem.VACUUM_HOLDS)
    for tick in range(2000):
        fallen = 120.0 * (1.0 - lost * max(tick * DT_S - check.VACUUM_SETTLE_S, 0.0) / check.LEAK_S)
        state = step(PLAN, state, AT_HOME._replace(line_vacuum_mmhg=fallen), RESTING, DT_S)
        if state.item == CheckItem.NONE or state.failed != CheckItem.NONE:
            break
    assert state.failed == (CheckItem.NONE if passes else CheckItem.VACUUM_HOLDS)


@pytest.mark.parametrize("item", ORDER)
@pytest.mark.parametrize(
    "broken",
    [
        {"head_valid": False},
        {"carriage_valid": False},
        {"cam_rad": NAN},
        {"vacuum_valid": False},
        {"contact_valid": False},
    ],
    ids=str,
)
def test_a_sensor_that_fails_later_is_named_whatever_is_being_tested(
    item: CheckItem, broken: dict[str, Any]
) -> None:
    assert failure(item, {}, **broken) == CheckItem.READINGS


@pytest.mark.parametrize("item", ORDER[1:])
def test_a_contact_that_closes_later_is_named_too(item: CheckItem) -> None:
    assert failure(item, {}, contact_closed=True) == CheckItem.CONTACT_OPEN


@given(st.lists(st.booleans(), min_size=1, max_size=300))
def test_a_bouncing_contact_never_passes_in_less_than_its_time(closed: list[bool]) -> None:
    state = at(CheckItem.CONTACT_OPEN)
    unbroken = 0
    for bounced in closed:
        state = step(PLAN, state, VENTED._replace(contact_closed=bounced), RESTING, DT_S)
        unbroken = 0 if bounced else unbroken + 1
        if state.item != CheckItem.CONTACT_OPEN:
            assert unbroken * DT_S >= check.HOLD_S
            return


def test_pump_valve_and_head_are_never_asked_for_together() -> None:
    for item in CheckItem:
        asked = (check.is_pumping(item), check.is_stroking(item), check.is_jogging(item))
        assert sum(asked) <= 1, item
        assert not (check.is_stroking(item) and check.set_point_mmhg(PLAN, item) > 0.0)


def test_every_item_has_its_words() -> None:
    assert set(ORDER) == set(CheckItem) - {CheckItem.NONE}
    assert all(item.title and item.failure for item in CheckItem)
    assert len({item.failure for item in CheckItem}) == len(CheckItem)


def test_a_test_that_is_broken_off_by_a_fault_names_its_item() -> None:
    state = at(CheckItem.VALVE_OPENS)
    assert check.end(state, broken_off=True).failed == CheckItem.VALVE_OPENS
    assert check.end(state, broken_off=False).failed == CheckItem.NONE
