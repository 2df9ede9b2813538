"""What is on record, listed for whoever looks back: the newest first, a page at a time."""

from collections.abc import Sequence
from datetime import datetime
from typing import Any, NamedTuple

from sqlalchemy import Select, Table, select

from opensuction.records import entry_check
from opensuction.records.database import schema
from opensuction.records.database.database import Database
from opensuction.records.entry import Machine, Outcome

PAGE = 50
"""Rows that are listed where nobody says how many."""
LONGEST_PAGE = 1000
LARGEST_NUMBER = 2**31 - 1


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
    """What a person did."""

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
    """What is on record in one database; only read, so it waits for nobody."""

    def __init__(self, database: Database) -> None:
        """Of a database that is up to date."""
        self._database = database

    def list_machines(self) -> list[Machine]:
        """All machines, by their serials."""
        table = schema.machine
        query = select(table.c.serial, table.c.kind, table.c.is_twin).order_by(table.c.serial)
        return [Machine(row.serial, row.kind, row.is_twin) for row in self._read(query)]

    def list_cycles(
        self, machine: str, limit: int = PAGE, before: int | None = None
    ) -> list[PastCycle]:
        """The last cycles of a machine, the newest first; of a machine not on record none.

        before: the number of a cycle, to list those before it.
        """
        entry_check.check_name("the machine's serial", machine)
        cycle, end, protocol = schema.cycle, schema.cycle_end, schema.protocol
        query = (
            select(
                *(cycle, end.c.outcome, end.c.detail, end.c.inside_at_end, end.c.ended_at),
                protocol.c.name.label("protocol"),
            )
            .join(protocol, protocol.c.sha256 == cycle.c.protocol_sha256)
            .outerjoin(end, end.c.cycle_id == cycle.c.id)
            .where(cycle.c.machine_serial == machine)
        )
        return [_to_cycle(row) for row in self._read(_page(query, cycle, limit, before))]

    def list_alarms(
        self,
        machine: str,
        limit: int = PAGE,
        before: int | None = None,
        cycle_id: str | None = None,
    ) -> list[PastAlarm]:
        """The last alarms of a machine, the newest first. cycle_id: of this cycle only."""
        entry_check.check_name("the machine's serial", machine)
        alarm = schema.alarm
        query = select(alarm).where(alarm.c.machine_serial == machine)
        if cycle_id is not None:
            entry_check.check_name("the cycle's id", cycle_id)
            query = query.where(alarm.c.cycle_id == cycle_id)
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
        self, machine: str | None = None, limit: int = PAGE, before: int | None = None
    ) -> list[PastAction]:
        """What people did last, the newest first. machine: on this one only; None: anywhere."""
        action = schema.action
        query = select(action)
        if machine is not None:
            entry_check.check_name("the machine's serial", machine)
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


def _page(query: Select[Any], table: Table, limit: int, before: int | None) -> Select[Any]:
    """The newest rows by their numbers: times may step."""
    entry_check.check_whole("the number of rows", limit, LONGEST_PAGE, "rows")
    if before is not None:
        entry_check.check_whole("the number to list before", before, LARGEST_NUMBER, "")
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
