"""What the runtime and a console look back at: the newest first, with how it ended."""

from collections.abc import Iterator
from datetime import timedelta

import pytest

from opensuction.kernel.errors import InputError
from opensuction.records.entry import Action, CycleEnd, Outcome
from opensuction.records.history import History
from opensuction.records.records import Records
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
