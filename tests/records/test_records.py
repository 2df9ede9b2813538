"""Records come back as they were stored, once each, and are never changed."""

import json
from collections.abc import Callable
from datetime import UTC, datetime, timedelta, timezone
from enum import StrEnum
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import select

from opensuction.kernel.errors import InputError
from opensuction.records.database import schema
from opensuction.records.entry import Action, Alarm, CycleEnd, CycleStart, Outcome
from opensuction.records.records import Records
from tests.records.conftest import on_both
from tests.records.example import (
    CATHETER,
    CLOGGED,
    COMPLETED,
    MACHINE,
    NOON,
    PROTOCOL,
    Clock,
    count_entries,
    start,
)


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def records(url: str, clock: Clock) -> Any:
    with Records.open(url, clock=clock) as opened:
        yield opened


def rows(records: Records, table: Any) -> list[dict[str, Any]]:
    with records.database.reading() as connection:
        return [dict(row) for row in connection.execute(select(table)).mappings()]


@on_both
def test_a_cycle_is_on_record_before_it_ends_and_says_what_happened(records: Records) -> None:
    cycle = records.begin_cycle(start())
    (unfinished,) = records.unfinished_cycles()
    assert unfinished.id == cycle
    assert (unfinished.machine, unfinished.catheter, unfinished.patient) == ("M-1", "C-1", "P-0042")
    assert NOON < unfinished.started_at < NOON + timedelta(seconds=5)
    assert records.find_end(cycle) is None
    end = CycleEnd(Outcome.INTERRUPTED, "the control process died; brought out in recovery", False)
    records.end_cycle(cycle, end)
    assert records.unfinished_cycles() == []
    assert records.find_end(cycle) == end


def test_what_was_said_of_a_cycle_is_on_record(records: Records) -> None:
    cycle = records.begin_cycle(start())
    (row,) = rows(records, schema.cycle)
    assert (row["id"], row["number"]) == (cycle, 1)
    assert row["protocol_sha256"] == PROTOCOL.sha256
    assert row["software"] == "opensuction 0.1.0"
    (protocol,) = rows(records, schema.protocol)
    assert protocol["content"] == PROTOCOL.content
    (machine,) = rows(records, schema.machine)
    assert machine["is_twin"] is True


@on_both
def test_records_are_there_when_opened_again(url: str) -> None:
    with Records.open(url) as first:
        cycle = first.begin_cycle(start())
        head = first.head()
    with Records.open(url) as second:
        assert [one.id for one in second.unfinished_cycles()] == [cycle]
        assert second.head() == head


@on_both
def test_the_same_key_changes_nothing(records: Records) -> None:
    cycle = records.begin_cycle(start(), key="begin")
    alarm = records.add_alarm(MACHINE, CLOGGED, cycle, key="alarm")
    action = records.act(Action("nurse-7", "acknowledge", cycle_id=cycle), key="act")
    records.end_cycle(cycle, COMPLETED, key="end")
    before = records.head()
    later = NOON + timedelta(days=1)
    assert records.begin_cycle(start(), key="begin", at=later) == cycle
    assert records.add_alarm(MACHINE, CLOGGED, cycle, key="alarm") == alarm
    assert records.act(Action("nurse-7", "acknowledge", cycle_id=cycle), key="act") == action
    records.end_cycle(cycle, COMPLETED, key="end")
    assert records.head() == before


def test_a_key_is_of_one_request(records: Records) -> None:
    cycle = records.begin_cycle(start(), key="key")
    before = records.head()
    with pytest.raises(InputError, match="the key 'key' is that of another request"):
        records.begin_cycle(start(catheter="C-2"), key="key")
    with pytest.raises(InputError, match="the key 'key' is that of another request"):
        records.end_cycle(cycle, COMPLETED, key="key")
    assert records.head() == before


@on_both
def test_a_machine_has_one_cycle_at_a_time(records: Records) -> None:
    cycle = records.begin_cycle(start())
    other = records.begin_cycle(start(machine="M-2", catheter="C-2"))
    before = records.head()
    with pytest.raises(InputError, match="the machine has a cycle that has not ended"):
        records.begin_cycle(start())
    assert records.head() == before
    assert {one.id for one in records.unfinished_cycles()} == {cycle, other}
    records.end_cycle(cycle, COMPLETED)
    records.begin_cycle(start())
    assert [row["number"] for row in rows(records, schema.cycle)].count(2) == 1


def test_a_cycle_ends_once(records: Records) -> None:
    cycle = records.begin_cycle(start())
    records.end_cycle(cycle, COMPLETED)
    with pytest.raises(InputError, match="has ended already: completed"):
        records.end_cycle(cycle, CycleEnd(Outcome.ABORTED))
    assert records.find_end(cycle) == COMPLETED


@pytest.mark.parametrize("what", ["end", "alarm", "action"])
def test_what_belongs_to_no_cycle_is_refused(records: Records, what: str) -> None:
    calls: dict[str, Callable[[], object]] = {
        "end": lambda: records.end_cycle("nowhere", COMPLETED),
        "alarm": lambda: records.add_alarm(MACHINE, CLOGGED, "nowhere"),
        "action": lambda: records.act(Action("nurse-7", "reset", cycle_id="nowhere")),
    }
    with pytest.raises(InputError, match="no cycle 'nowhere' is on record"):
        calls[what]()
    assert count_entries(records) == 0


def test_an_action_of_a_machine_that_is_not_on_record_is_refused(records: Records) -> None:
    with pytest.raises(InputError, match="no machine 'M-9' is on record"):
        records.act(Action("nurse-7", "reset", machine="M-9"))
    with pytest.raises(InputError, match="serial is 9, not a text"):
        records.act(Action("nurse-7", "reset", machine=9))  # type: ignore[arg-type]


def test_an_alarm_may_come_after_the_end(records: Records) -> None:
    cycle = records.begin_cycle(start())
    records.end_cycle(cycle, COMPLETED)
    records.add_alarm(MACHINE, CLOGGED, cycle)
    (alarm,) = rows(records, schema.alarm)
    assert (alarm["cycle_id"], alarm["condition"], alarm["priority"]) == (
        cycle,
        "LINE_CLOGGED",
        "high",
    )


def test_a_catheter_is_of_one_size_and_a_machine_of_one_kind(records: Records) -> None:
    records.end_cycle(records.begin_cycle(start()), COMPLETED)
    before = records.head()
    thinner = start()._replace(catheter=CATHETER._replace(size_fr=10))
    with pytest.raises(InputError, match="catheter 'C-1' is on record with size_fr 12, not 10"):
        records.begin_cycle(thinner)
    real = start()._replace(machine=MACHINE._replace(is_twin=False))
    with pytest.raises(InputError, match="machine 'M-1' is on record with is_twin True, not False"):
        records.begin_cycle(real)
    assert records.head() == before


def test_a_catheter_ages_from_its_first_cycle(records: Records, clock: Clock) -> None:
    assert records.catheter_age_s("C-1") is None
    records.end_cycle(records.begin_cycle(start(), at=NOON), COMPLETED, at=NOON)
    assert records.catheter_age_s("C-1", NOON + timedelta(hours=23)) == 23 * 3600.0
    clock.at = NOON + timedelta(hours=25)
    assert records.catheter_age_s("C-1") == 25 * 3600.0 + 1.0


def test_a_clock_that_is_set_back_makes_no_catheter_younger(records: Records) -> None:
    cycle = records.begin_cycle(start(), at=NOON)
    records.end_cycle(cycle, COMPLETED, at=NOON + timedelta(hours=20))
    assert records.catheter_age_s("C-1", NOON + timedelta(hours=1)) == 20 * 3600.0
    assert records.catheter_age_s("C-1", NOON - timedelta(days=1)) == 20 * 3600.0


@on_both
def test_times_are_kept_in_utc(records: Records) -> None:
    zone = timezone(timedelta(hours=9))
    records.begin_cycle(start(), at=datetime(2026, 11, 23, 21, 0, 0, 7, tzinfo=zone))
    (cycle,) = records.unfinished_cycles()
    assert cycle.started_at == NOON
    assert cycle.started_at.tzinfo is UTC


def test_an_entry_says_when_it_was_written(records: Records, clock: Clock) -> None:
    clock.at = NOON + timedelta(days=1)
    records.begin_cycle(start(), at=NOON)
    entries = [json.loads(row["entry"]) for row in rows(records, schema.audit)]
    assert {entry["at"] for entry in entries} == {"2026-11-24T12:00:01.000007Z"}
    (cycle,) = [entry["row"] for entry in entries if entry["table"] == "cycle"]
    assert cycle["started_at"] == "2026-11-23T12:00:00.000007Z"


def test_a_cycle_that_is_told_of_late_makes_its_catheter_older(records: Records) -> None:
    records.end_cycle(records.begin_cycle(start(), at=NOON), COMPLETED, at=NOON)
    records.begin_cycle(start(), at=NOON - timedelta(hours=3))
    assert records.catheter_age_s("C-1", NOON) == 3 * 3600.0


class Approach(StrEnum):
    BY_CONTACT = "contact"


def test_an_enumeration_is_stored_by_its_value(records: Records) -> None:
    records.begin_cycle(start()._replace(approach=Approach.BY_CONTACT))
    (row,) = rows(records, schema.cycle)
    assert row["approach"] == "contact"
    assert records.audit().broken is None


def test_a_time_without_a_zone_is_refused(records: Records) -> None:
    with pytest.raises(InputError, match="has no zone; give it in UTC"):
        records.begin_cycle(start(), at=NOON.replace(tzinfo=None))


BAD_STARTS: list[tuple[CycleStart, str]] = [
    (start()._replace(machine=MACHINE._replace(serial="")), "serial has 0 characters; 1 to 64"),
    (start()._replace(machine=MACHINE._replace(serial="a" * 65)), "has 65 characters; 1 to 64"),
    (start()._replace(machine=MACHINE._replace(is_twin="no")), "true or false"),  # type: ignore[arg-type]
    (start(catheter="C\n1"), "invisible characters"),
    (start()._replace(catheter=CATHETER._replace(size_fr=0)), "whole numbers from 1 to 30 Fr"),
    (start()._replace(catheter=CATHETER._replace(life_s=86_401)), "from 1 to 86400 s"),
    (start()._replace(catheter=CATHETER._replace(life_s=True)), "from 1 to 86400 s"),
    (start()._replace(approach="by-ear"), "none of travel, contact"),
    (start()._replace(protocol=PROTOCOL._replace(content="a\0")), "characters that no text has"),
    (start()._replace(protocol=PROTOCOL._replace(content="\ud800")), "characters that no text has"),
    (start()._replace(settings_sha256="0F" * 32), "no SHA-256 of 64 hexadecimal digits"),
    (start()._replace(recording=""), "the recording has 0 characters"),
    (start()._replace(requested_by=7), "not a text"),  # type: ignore[arg-type]
    (start(patient="Anna Meyer"), "never a name, a date of birth"),
    (start(patient="Müller"), "never a name, a date of birth"),
]


@pytest.mark.parametrize(("bad", "words"), BAD_STARTS, ids=[words for _, words in BAD_STARTS])
def test_a_cycle_that_cannot_be_is_one_line_and_nothing_is_stored(
    records: Records, bad: CycleStart, words: str
) -> None:
    with pytest.raises(InputError, match=words) as refused:
        records.begin_cycle(bad)
    assert len(str(refused.value).splitlines()) == 1
    assert count_entries(records) == 0


def test_an_end_or_an_alarm_that_cannot_be_is_refused(records: Records) -> None:
    cycle = records.begin_cycle(start())
    with pytest.raises(InputError, match="none of completed, aborted, interrupted"):
        records.end_cycle(cycle, CycleEnd("vanished"))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="true, false or not known"):
        records.end_cycle(cycle, CycleEnd(Outcome.ABORTED, "", 1))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="none of low, medium, high"):
        records.add_alarm(MACHINE, Alarm("LINE_CLOGGED", "urgent"), cycle)
    with pytest.raises(InputError, match="has 4001 characters"):
        records.add_alarm(MACHINE, CLOGGED._replace(detail="a" * 4001), cycle)
    assert [one.id for one in records.unfinished_cycles()] == [cycle]


@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(said=st.text(st.characters(codec=None, exclude_categories=[]), max_size=50))
def test_any_words_come_back_as_they_were_or_are_one_line(records: Records, said: str) -> None:
    before = records.head()
    try:
        name = records.act(Action("nurse-7", "note", said))
    except InputError as refused:
        assert len(str(refused).splitlines()) == 1
        assert "\0" in said or any("\ud800" <= letter <= "\udfff" for letter in said)
        assert records.head() == before
    else:
        (row,) = [row for row in rows(records, schema.action) if row["id"] == name]
        assert row["detail"] == said
        assert records.audit().broken is None
