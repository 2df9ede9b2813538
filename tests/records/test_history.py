"""History for runtime and console: the newest cycle first, with its end."""

from collections.abc import Iterator
from datetime import datetime, timedelta

import pytest

from opensuction.kernel.errors import InputError
from opensuction.records.entry import Action, CycleEnd, Outcome
from opensuction.records.history import History, Wanted
from opensuction.records.records import Records
from tests.records.conftest import on_both
from tests.records.example import (
    CLOGGED,
    COMPLETED,
    MACHINE,
    NOON,
    PROTOCOL,
    Clock,
    count_entries,
    start,
)

OTHER = MACHINE._replace(serial="M-2")


@pytest.fixture
def records(url: str) -> Iterator[Records]:
    with Records.open(url, clock=Clock()) as opened:
        yield opened


def test_a_cycle_is_listed_with_its_end_or_without(records: Records) -> None:
    first = records.begin_cycle(start(), at=NOON)
    aborted = CycleEnd(Outcome.ABORTED, "by nurse-7", True)
    records.end_cycle(first, aborted, at=NOON + timedelta(seconds=20))
    second = records.begin_cycle(start(catheter="C-2", patient=None))
    records.end_cycle(records.begin_cycle(start(machine="M-2")), COMPLETED)
    running, past = records.history.list_cycles("M-1")
    assert (running.id, running.number, running.catheter) == (second, 2, "C-2")
    assert (running.patient, running.outcome, running.ended_at) == (None, None, None)
    assert (past.id, past.number, past.patient, past.machine) == (first, 1, "P-0042", "M-1")
    assert (past.protocol, past.protocol_sha256) == (PROTOCOL.name, PROTOCOL.sha256)
    assert CycleEnd(past.outcome, past.detail, past.inside_at_end) == aborted  # type: ignore[arg-type]
    assert past.ended_at is not None
    assert (past.started_at, past.ended_at - past.started_at) == (NOON, timedelta(seconds=20))
    assert past.recording == "2026-11-23/0001.mcap"


def test_the_newest_is_the_last_stored_whatever_the_clock_says(records: Records) -> None:
    cycles = []
    for hours in (5, 3, 4):
        cycles.append(records.begin_cycle(start(), at=NOON + timedelta(hours=hours)))
        records.end_cycle(cycles[-1], COMPLETED)
        records.add_alarm(MACHINE, CLOGGED, cycles[-1], at=NOON - timedelta(hours=hours))
        records.act(Action("nurse-7", f"act-{hours}"), at=NOON - timedelta(hours=hours))
    history = records.history
    assert [one.id for one in history.list_cycles("M-1")] == cycles[::-1]
    assert [one.cycle_id for one in history.list_alarms("M-1")] == cycles[::-1]
    assert [one.what for one in history.list_actions()] == ["act-4", "act-3", "act-5"]


@on_both
def test_a_page_goes_on_where_the_last_one_ended(records: Records) -> None:
    for _ in range(5):
        records.add_alarm(MACHINE, CLOGGED)
        records.add_alarm(OTHER, CLOGGED)
    seen: list[int] = []
    before = None
    while page := records.history.list_alarms("M-1", limit=2, before=before):
        seen += [one.number for one in page]
        before = seen[-1]
    assert seen == [5, 4, 3, 2, 1]


def test_an_alarm_at_rest_belongs_to_its_machine_and_to_no_cycle(records: Records) -> None:
    name = records.add_alarm(MACHINE, CLOGGED, at=NOON)
    cycle = records.begin_cycle(start())
    other = records.add_alarm(MACHINE, CLOGGED._replace(priority="low"), cycle)
    assert records.history.list_machines() == [MACHINE], "the alarm put it on record"
    (of_cycle,) = records.history.list_alarms("M-1", cycle_id=cycle)
    assert (of_cycle.id, of_cycle.priority) == (other, "low")
    at_rest = records.history.list_alarms("M-1")[1]
    assert (at_rest.id, at_rest.cycle_id, at_rest.raised_at) == (name, None, NOON)
    assert (at_rest.condition, at_rest.detail) == ("LINE_CLOGGED", "nothing came")
    assert records.history.list_alarms("M-9") == []


def test_an_alarm_or_an_action_of_another_machine_s_cycle_is_refused(records: Records) -> None:
    cycle = records.begin_cycle(start())
    records.note_machine(OTHER)
    before = records.head()
    with pytest.raises(InputError, match="is of machine 'M-1', not 'M-2'"):
        records.add_alarm(OTHER, CLOGGED, cycle)
    with pytest.raises(InputError, match="is of machine 'M-1', not 'M-2'"):
        records.act(Action("nurse-7", "reset", machine="M-2", cycle_id=cycle))
    assert records.head() == before


def test_an_action_in_a_cycle_is_one_on_its_machine(records: Records) -> None:
    cycle = records.begin_cycle(start())
    records.act(Action("nurse-7", "assess", "lungs clear", cycle_id=cycle))
    records.act(Action("nurse-7", "sign-in"))
    (act,) = records.history.list_actions("M-1")
    assert (act.what, act.detail, act.machine, act.cycle_id) == (
        "assess",
        "lungs clear",
        "M-1",
        cycle,
    )
    assert [one.number for one in records.history.list_actions()] == [2, 1]


def test_a_machine_is_put_on_record_once_and_as_one_kind(records: Records) -> None:
    records.note_machine(OTHER, key="k")
    records.note_machine(OTHER, key="k")
    records.note_machine(OTHER)
    records.note_machine(MACHINE)
    assert records.history.list_machines() == [MACHINE, OTHER]
    assert count_entries(records) == 2 + 1, "two machines, one key"
    for call in (
        lambda: records.note_machine(OTHER._replace(kind="bench")),
        lambda: records.add_alarm(OTHER._replace(is_twin=False), CLOGGED),
    ):
        with pytest.raises(InputError, match="machine 'M-2' is on record with"):
            call()
    with pytest.raises(InputError, match="serial has 0 characters"):
        records.note_machine(MACHINE._replace(serial=""))


@pytest.mark.parametrize(
    ("limit", "before", "words"),
    [(0, None, "from 1 to 1000 rows"), (1001, None, "rows"), (5, 0, "to list before is 0")],
)
def test_a_page_that_cannot_be_is_one_line(
    records: Records, limit: int, before: int | None, words: str
) -> None:
    history: History = records.history
    for call in (
        lambda: history.list_cycles("M-1", limit, before),
        lambda: history.list_alarms("M-1", limit, before),
        lambda: history.list_actions("M-1", limit, before),
    ):
        with pytest.raises(InputError, match=words) as refused:
            call()
        assert len(str(refused.value).splitlines()) == 1


def three_cycles(records: Records) -> list[str]:
    """Completed at noon, aborted an hour later, running since two."""
    first = records.begin_cycle(start(), at=NOON)
    records.end_cycle(first, COMPLETED, at=NOON + timedelta(seconds=20))
    later = NOON + timedelta(hours=1)
    second = records.begin_cycle(start(catheter="C-2", patient="P-0100"), at=later)
    aborted = CycleEnd(Outcome.ABORTED, "Tripped, 50 % of_it", True)
    records.end_cycle(second, aborted, at=later + timedelta(seconds=9))
    records.begin_cycle(start(machine="M-2"), at=later)
    return [first, second, records.begin_cycle(start(patient=None), at=NOON + timedelta(hours=2))]


@on_both
def test_cycles_are_narrowed_by_outcome_time_and_text(records: Records) -> None:
    first, second, third = three_cycles(records)
    list_cycles = records.history.list_cycles

    def found(**by: object) -> list[str]:
        return [one.id for one in list_cycles("M-1", **by)]  # type: ignore[arg-type]

    assert found(outcome=Outcome.COMPLETED) == [first]
    assert found(outcome=Outcome.ABORTED) == [second]
    assert found(outcome=Outcome.INTERRUPTED) == []
    later = NOON + timedelta(hours=1)
    assert found(wanted=Wanted(since=later)) == [third, second]
    assert found(wanted=Wanted(until=later)) == [first]
    assert found(wanted=Wanted(since=later, until=later)) == []
    assert found(wanted=Wanted(text="p-01")) == [second], "a patient, whatever the case"
    assert found(wanted=Wanted(text="C-2")) == [second], "a catheter"
    assert found(wanted=Wanted(text="TRIPPED")) == [second], "a detail"
    assert found(wanted=Wanted(text="nurse-7")) == [third, second, first]
    assert found(wanted=Wanted(text="nurse-7"), before=3, limit=1) == [second]


@on_both
def test_what_a_search_means_elsewhere_is_only_text_here(records: Records) -> None:
    _, second, _ = three_cycles(records)

    def found(text: str) -> list[str]:
        return [one.id for one in records.history.list_cycles("M-1", wanted=Wanted(text=text))]

    assert found("50 % of_it") == [second]
    assert found("%") == [second], "no cycle but the one with the sign in it"
    assert found("_") == [second]
    assert found("ed, 5_ %") == []
    assert found("'; DROP TABLE cycle; --") == []
    assert found("\\") == []


@pytest.mark.parametrize("text", ["", "x" * 101, "a\0b", "\ud800"])
def test_a_search_for_what_no_text_is_is_refused(records: Records, text: str) -> None:
    for call in (
        lambda: records.history.list_cycles("M-1", wanted=Wanted(text=text)),
        lambda: records.history.list_alarms("M-1", wanted=Wanted(text=text)),
        lambda: records.history.list_actions(wanted=Wanted(text=text)),
    ):
        with pytest.raises(InputError, match="the text to look for"):
            call()


def test_a_time_without_a_zone_is_refused(records: Records) -> None:
    naive = datetime(2026, 11, 23)  # noqa: DTZ001 - what a caller may get wrong
    with pytest.raises(InputError, match="zone"):
        records.history.list_cycles("M-1", wanted=Wanted(since=naive))


def test_a_cycle_is_found_by_its_id(records: Records) -> None:
    first, *_ = three_cycles(records)
    found = records.history.find_cycle(first)
    assert found is not None
    assert (found.id, found.outcome, found.protocol) == (first, Outcome.COMPLETED, PROTOCOL.name)
    assert records.history.find_cycle("nobody's") is None


def test_alarms_are_narrowed_by_priority_time_and_text(records: Records) -> None:
    high = records.add_alarm(MACHINE, CLOGGED, at=NOON)
    low = CLOGGED._replace(priority="low", condition="REST_NOT_OVER", detail="")
    other = records.add_alarm(MACHINE, low, at=NOON + timedelta(hours=1))

    def found(**by: object) -> list[str]:
        return [one.id for one in records.history.list_alarms("M-1", **by)]  # type: ignore[arg-type]

    assert found(priority="high") == [high]
    assert found(priority="medium") == []
    assert found(wanted=Wanted(since=NOON + timedelta(minutes=1))) == [other]
    assert found(wanted=Wanted(text="clogged")) == [high]
    assert found(wanted=Wanted(text="nothing CAME")) == [high]


def test_actions_are_narrowed_by_cycle_time_and_text(records: Records) -> None:
    cycle = records.begin_cycle(start(), at=NOON)
    records.act(Action("nurse-7", "start", "pressed", cycle_id=cycle), at=NOON)
    records.act(Action("engineer-1", "reset", "dealt with"), at=NOON + timedelta(hours=1))

    def found(**by: object) -> list[str]:
        return [one.what for one in records.history.list_actions(**by)]  # type: ignore[arg-type]

    assert found(cycle_id=cycle) == ["start"]
    assert found(wanted=Wanted(text="ENGINEER")) == ["reset"]
    assert found(wanted=Wanted(text="dealt", until=NOON)) == []
