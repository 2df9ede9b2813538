"""Queries of past cycles, alarms and actions: the newest first, a page at a time."""

from collections.abc import Sequence
from datetime import datetime
from typing import Any, NamedTuple

from sqlalchemy import Column, Select, Table, func, or_, select

from opensuction.records import entry
from opensuction.records.database import schema
from opensuction.records.database.database import Database
from opensuction.records.database.utc_time import to_utc
from opensuction.records.entry import BoundFile, Machine, Outcome
from opensuction.records.recording_check import BoundRecording

PAGE = 50
"""Rows that are listed where nobody says how many."""
LONGEST_PAGE = 1000
LARGEST_NUMBER = 2**31 - 1


LONGEST_SEARCH = 100


class Wanted(NamedTuple):
    """Bounds by which a list is narrowed; None: by nothing."""

    since: datetime | None = None
    """From this instant on."""
    until: datetime | None = None
    """Before this instant."""
    text: str | None = None
    """Somewhere in its words, whatever the case of its letters."""


ALL = Wanted()


class PastCycle(NamedTuple):
    """A cycle on record, with its end where it has one."""

    id: str
    number: int
    """From 1 on for each machine."""
    machine: str
    """Serial."""
    catheter: str
    """Label."""
    patient: str | None
    """Pseudonym."""
    protocol: str
    """Name of its protocol."""
    protocol_sha256: str
    approach: str
    requested_by: str
    software: str
    recording: str | None
    started_at: datetime
    outcome: Outcome | None = None
    """None: it has not ended, or nobody has said so."""
    detail: str = ""
    inside_at_end: bool | None = None
    ended_at: datetime | None = None


class PastAlarm(NamedTuple):
    """An alarm on record."""

    id: str
    number: int
    """From 1 on for each machine."""
    machine: str
    """Serial."""
    cycle_id: str | None
    """None: the machine was at rest."""
    condition: str
    priority: str
    detail: str
    raised_at: datetime


class PastAction(NamedTuple):
    """Action of a person on record."""

    id: str
    number: int
    """From 1 on."""
    done_by: str
    what: str
    detail: str
    machine: str | None
    """Serial."""
    cycle_id: str | None
    done_at: datetime


class History:
    """History in one database; only read, so it waits for nobody."""

    def __init__(self, database: Database) -> None:
        """Of a database that is up to date."""
        self._database = database

    def list_machines(self) -> list[Machine]:
        """All machines, by their serials."""
        table = schema.machine
        query = select(table.c.serial, table.c.kind, table.c.is_twin).order_by(table.c.serial)
        return [Machine(row.serial, row.kind, row.is_twin) for row in self._read(query)]

    def list_cycles(
        self,
        machine: str,
        limit: int = PAGE,
        before: int | None = None,
        wanted: Wanted = ALL,
        outcome: Outcome | None = None,
    ) -> list[PastCycle]:
        """The last cycles of a machine, the newest first; of a machine not on record none.

        before: the number of a cycle, to list those before it. outcome: those that ended so.
        """
        entry.check_name("the machine's serial", machine)
        cycle, end = schema.cycle, schema.cycle_end
        query = _narrow(
            _select_cycles().where(cycle.c.machine_serial == machine),
            wanted,
            cycle.c.started_at,
            (
                cycle.c.patient_pseudonym,
                cycle.c.requested_by,
                cycle.c.catheter_label,
                schema.protocol.c.name,
                end.c.detail,
            ),
        )
        if outcome is not None:
            query = query.where(end.c.outcome == str(outcome))
        return [_to_cycle(row) for row in self._read(_page(query, cycle, limit, before))]

    def find_cycle(self, cycle_id: str) -> PastCycle | None:
        """A cycle by its id; None: it is not on record."""
        entry.check_name("the cycle's id", cycle_id)
        found = self._read(_select_cycles().where(schema.cycle.c.id == cycle_id))
        return _to_cycle(found[0]) if found else None

    def list_recordings(self, cycles: Sequence[PastCycle]) -> list[BoundRecording]:
        """The files on record of the recordings of these cycles, part by part."""
        numbers = {(one.machine, one.recording): one.number for one in cycles if one.recording}
        table = schema.recording
        query = (
            select(table)
            .where(table.c.cycle_recording.in_([name for _, name in numbers]))
            .order_by(table.c.cycle_recording, table.c.part)
        )
        return [
            one._replace(cycle=numbers[one.machine, one.file.cycle_recording])
            for one in map(to_recording, self._read(query) if numbers else [])
            if (one.machine, one.file.cycle_recording) in numbers
        ]

    def find_recording(
        self, name: str | None = None, sha256: str | None = None
    ) -> BoundRecording | None:
        """A file on record, by its name or by its hash; None: there is none."""
        table, cycle = schema.recording, schema.cycle
        query = select(table).order_by(table.c.name).limit(1)
        query = query if name is None else query.where(table.c.name == name)
        query = query if sha256 is None else query.where(table.c.sha256 == sha256)
        for one in map(to_recording, self._read(query)):
            number = select(cycle.c.number).where(
                cycle.c.machine_serial == one.machine,
                cycle.c.recording == one.file.cycle_recording,
            )
            found = self._read(number.order_by(cycle.c.number).limit(1))
            return one._replace(cycle=found[0].number if found else None)
        return None

    def list_alarms(
        self,
        machine: str,
        limit: int = PAGE,
        before: int | None = None,
        cycle_id: str | None = None,
        wanted: Wanted = ALL,
        priority: str | None = None,
    ) -> list[PastAlarm]:
        """The last alarms of a machine, the newest first.

        cycle_id: of this cycle only. priority: of this one only.
        """
        entry.check_name("the machine's serial", machine)
        alarm = schema.alarm
        query = select(alarm).where(alarm.c.machine_serial == machine)
        query = _narrow(query, wanted, alarm.c.raised_at, (alarm.c.condition, alarm.c.detail))
        if cycle_id is not None:
            entry.check_name("the cycle's id", cycle_id)
            query = query.where(alarm.c.cycle_id == cycle_id)
        if priority is not None:
            query = query.where(alarm.c.priority == priority)
        return [
            PastAlarm(
                id=row.id,
                number=row.number,
                machine=row.machine_serial,
                cycle_id=row.cycle_id,
                condition=row.condition,
                priority=row.priority,
                detail=row.detail,
                raised_at=row.raised_at,
            )
            for row in self._read(_page(query, alarm, limit, before))
        ]

    def list_actions(
        self,
        machine: str | None = None,
        limit: int = PAGE,
        before: int | None = None,
        cycle_id: str | None = None,
        wanted: Wanted = ALL,
    ) -> list[PastAction]:
        """List the last actions of people, the newest first.

        machine: on this one only; None: anywhere. cycle_id: in this cycle only.
        """
        action = schema.action
        query = _narrow(
            select(action),
            wanted,
            action.c.done_at,
            (action.c.done_by, action.c.what, action.c.detail),
        )
        if cycle_id is not None:
            entry.check_name("the cycle's id", cycle_id)
            query = query.where(action.c.cycle_id == cycle_id)
        if machine is not None:
            entry.check_name("the machine's serial", machine)
            query = query.where(action.c.machine_serial == machine)
        return [
            PastAction(
                id=row.id,
                number=row.number,
                done_by=row.done_by,
                what=row.what,
                detail=row.detail,
                machine=row.machine_serial,
                cycle_id=row.cycle_id,
                done_at=row.done_at,
            )
            for row in self._read(_page(query, action, limit, before))
        ]

    def _read(self, query: Select[Any]) -> Sequence[Any]:
        with self._database.reading() as connection:
            return connection.execute(query).all()


def to_recording(row: Any) -> BoundRecording:
    """Of a row of its table; its cycle is left open."""
    file = BoundFile(*(getattr(row, name) for name in BoundFile._fields))
    return BoundRecording(file, row.machine_serial, None)


def _select_cycles() -> Select[Any]:
    """Cycles with their ends and the names of their protocols."""
    cycle, end, protocol = schema.cycle, schema.cycle_end, schema.protocol
    return (
        select(
            *(cycle, end.c.outcome, end.c.detail, end.c.inside_at_end, end.c.ended_at),
            protocol.c.name.label("protocol"),
        )
        .join(protocol, protocol.c.sha256 == cycle.c.protocol_sha256)
        .outerjoin(end, end.c.cycle_id == cycle.c.id)
    )


def _narrow(
    query: Select[Any], wanted: Wanted, time: Column[Any], words: tuple[Column[Any], ...]
) -> Select[Any]:
    """Rows of a time, with a text in one of these columns. Raises InputError for what is none."""
    if wanted.since is not None:
        query = query.where(time >= to_utc(wanted.since))
    if wanted.until is not None:
        query = query.where(time < to_utc(wanted.until))
    if wanted.text is not None:
        entry.check_search(wanted.text, LONGEST_SEARCH)
        low = wanted.text.lower()
        query = query.where(or_(*(func.lower(one).contains(low, autoescape=True) for one in words)))
    return query


def _page(query: Select[Any], table: Table, limit: int, before: int | None) -> Select[Any]:
    """The newest rows by their numbers: times may step."""
    entry.check_whole("the number of rows", limit, LONGEST_PAGE, "rows")
    if before is not None:
        entry.check_whole("the number to list before", before, LARGEST_NUMBER, "")
        query = query.where(table.c.number < before)
    return query.order_by(table.c.number.desc()).limit(limit)


def _to_cycle(row: Any) -> PastCycle:
    return PastCycle(
        id=row.id,
        number=row.number,
        machine=row.machine_serial,
        catheter=row.catheter_label,
        patient=row.patient_pseudonym,
        protocol=row.protocol,
        protocol_sha256=row.protocol_sha256,
        approach=row.approach,
        requested_by=row.requested_by,
        software=row.software,
        recording=row.recording,
        started_at=row.started_at,
        outcome=None if row.outcome is None else Outcome(row.outcome),
        detail=row.detail or "",
        inside_at_end=row.inside_at_end,
        ended_at=row.ended_at,
    )
