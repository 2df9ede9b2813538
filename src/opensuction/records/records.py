"""Records of cycles, alarms and people: what the runtime stores, and its queries.

Each request is one transaction: all of its rows and their entries in the trail, or nothing. A
request that carries a key can be sent again after a failure or a crash: what was stored under the
key stays, and its result is returned again.
"""

from collections.abc import Callable
from datetime import datetime
from types import TracebackType
from typing import Any, Self
from uuid import uuid4

from sqlalchemy import func, select

from opensuction.kernel.errors import InputError
from opensuction.records import audit, entry
from opensuction.records.database import schema, utc_time
from opensuction.records.database.database import Database, connect, create_file, parse
from opensuction.records.database.utc_time import to_utc
from opensuction.records.entry import (
    Action,
    Alarm,
    BoundFile,
    CycleEnd,
    CycleStart,
    Machine,
    Outcome,
    Unfinished,
    to_hash,
)
from opensuction.records.history import History
from opensuction.records.migration import upgrade
from opensuction.records.request import (
    Request,
    act,
    add_alarm,
    begin_cycle,
    bind_recording,
    end_cycle,
    note_machine,
    store_one_each,
)
from opensuction.records.trail.chain import AuditReport, Head, read_head, to_canonical

WAIT_S = 5.0
"""Longest wait for another program that writes, unless another is given."""

Clock = Callable[[], datetime]
Work = Callable[[Request], str]


class Records:
    """The records of one database. May be used by several threads, and by several programs."""

    def __init__(self, database: Database, clock: Clock = utc_time.now) -> None:
        """Of a database that `open` has brought up to date."""
        self.database = database
        self.history = History(database)
        self._clock = clock

    @classmethod
    def open(
        cls, url: str | None = None, wait_s: float = WAIT_S, clock: Clock = utc_time.now
    ) -> Self:
        """Open a database, make it where there is none, bring an older one up to date.

        url: a file's path, ``sqlite:///FILE`` or ``postgresql://...``; None: the default one.
        wait_s: longest wait for others who write. Raises RecordsError, one line, nothing changed.
        """
        where = parse(url)
        create_file(where)
        database = connect(where, wait_s)
        try:
            upgrade.bring_up_to_date(database)
        except BaseException:
            database.engine.dispose()
            raise
        return cls(database, clock)

    @classmethod
    def open_for_machine(cls, url: str | None = None) -> Self:
        """As `open`, of records that must take what a machine does: it is tried that they do.

        Raises RecordsError where one of the tables that a recorder writes takes no row.
        """
        records = cls.open(url)
        try:
            now = utc_time.now()
            with records.database.trying() as connection:
                store_one_each(Request(connection, now, now), f"trial-{uuid4()}")
        except BaseException:
            records.close()
            raise
        return records

    def close(self) -> None:
        """Let go of the database."""
        self.database.close()

    def __enter__(self) -> Self:
        """Open already."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Let go of the database."""
        self.close()

    def begin_cycle(
        self, start: CycleStart, key: str | None = None, at: datetime | None = None
    ) -> str:
        """Put a cycle on record before it starts, with whatever of it is new; returns its id.

        key: of this request, to send it again. at: when it starts; None: now.
        Raises InputError where the machine has a cycle that has not ended, or where a machine or a
        catheter of that name is on record as another one.
        """
        entry.check_start(start)

        def work(request: Request) -> str:
            return begin_cycle(request, start)

        return self._store("begin-cycle", start, key, at, work)

    def end_cycle(
        self, cycle_id: str, end: CycleEnd, key: str | None = None, at: datetime | None = None
    ) -> None:
        """Say how a cycle ended. Raises InputError for one that is not there, or has ended."""
        entry.check_name("the cycle's id", cycle_id)
        entry.check_end(end)

        def work(request: Request) -> str:
            return end_cycle(request, cycle_id, end)

        self._store("end-cycle", (cycle_id, end), key, at, work)

    def note_machine(
        self, machine: Machine, key: str | None = None, at: datetime | None = None
    ) -> None:
        """See that a machine is on record, before it has any cycle.

        Raises InputError where one of its serial is on record as another one.
        """
        entry.check_machine(machine)

        def work(request: Request) -> str:
            return note_machine(request, machine)

        self._store("note-machine", machine, key, at, work)

    def add_alarm(
        self,
        machine: Machine,
        alarm: Alarm,
        cycle_id: str | None = None,
        key: str | None = None,
        at: datetime | None = None,
    ) -> str:
        """Put an alarm of a machine on record, and the machine where it is new; returns its id.

        cycle_id: the cycle that it belongs to, which may have ended; None: the machine was at rest.
        Raises InputError for a cycle that is not on record, or is another machine's.
        """
        entry.check_machine(machine)
        entry.check_alarm(alarm)
        if cycle_id is not None:
            entry.check_name("the cycle's id", cycle_id)

        def work(request: Request) -> str:
            return add_alarm(request, machine, alarm, cycle_id)

        return self._store("add-alarm", (machine, alarm, cycle_id), key, at, work)

    def bind_recording(
        self, machine: Machine, file: BoundFile, key: str | None = None, at: datetime | None = None
    ) -> None:
        """Put on record what a file of a recording holds, and the machine where it is new.

        Raises InputError where a file of that name is on record with something else.
        """
        entry.check_machine(machine)
        entry.check_recording(file)

        def work(request: Request) -> str:
            return bind_recording(request, machine, file)

        self._store("bind-recording", (machine, file), key, at, work)

    def act(self, action: Action, key: str | None = None, at: datetime | None = None) -> str:
        """Put on record what a person did; returns its id."""
        entry.check_action(action)

        def work(request: Request) -> str:
            return act(request, action)

        return self._store("act", action, key, at, work)

    def _store(self, kind: str, said: Any, key: str | None, at: datetime | None, work: Work) -> str:
        """Carry a request out once, whole."""
        now = self._clock()
        happened = now if at is None else to_utc(at)
        if key is not None:
            entry.check_name("the key of the request", key)
        digest = to_hash(to_canonical([kind, said]))
        with self.database.writing() as connection:
            request = Request(connection, happened, now)
            if key is None:
                return work(request)
            known = request.find(schema.request, "key", key)
            if known is not None:
                if known["digest"] != digest:
                    raise InputError(f"the key '{key}' is that of another request")
                return str(known["result"])
            result = work(request)
            request.remember(key, digest, result)
            return result

    def unfinished_cycles(self) -> list[Unfinished]:
        """Cycles without an end, at most one a machine: what a crash leaves, or what goes on."""
        cycle, end = schema.cycle, schema.cycle_end
        last = (
            select(cycle.c.machine_serial, func.max(cycle.c.number).label("number"))
            .group_by(cycle.c.machine_serial)
            .subquery()
        )
        query = (
            select(cycle)
            .join(
                last,
                (cycle.c.machine_serial == last.c.machine_serial)
                & (cycle.c.number == last.c.number),
            )
            .outerjoin(end, end.c.cycle_id == cycle.c.id)
            .where(end.c.cycle_id.is_(None))
            .order_by(cycle.c.machine_serial)
        )
        with self.database.reading() as connection:
            return [
                Unfinished(
                    id=row.id,
                    machine=row.machine_serial,
                    catheter=row.catheter_label,
                    patient=row.patient_pseudonym,
                    started_at=row.started_at,
                    recording=row.recording,
                )
                for row in connection.execute(query)
            ]

    def find_end(self, cycle_id: str) -> CycleEnd | None:
        """End of a cycle; None: it has not ended, or is not on record."""
        end = schema.cycle_end
        with self.database.reading() as connection:
            row = connection.execute(select(end).where(end.c.cycle_id == cycle_id)).one_or_none()
        if row is None:
            return None
        return CycleEnd(Outcome(row.outcome), row.detail, row.inside_at_end)

    def catheter_age_s(self, label: str, at: datetime | None = None) -> float | None:
        """Time since a catheter's earliest cycle, in s; None: it is not on record, so never used.

        A computer's clock that was set back makes no catheter younger than its last cycle.
        """
        cycle, end = schema.cycle, schema.cycle_end
        query = (
            select(
                schema.catheter.c.first_used_at,
                func.min(cycle.c.started_at, type_=cycle.c.started_at.type).label("earliest_at"),
                func.max(cycle.c.started_at, type_=cycle.c.started_at.type).label("started_at"),
                func.max(end.c.ended_at, type_=end.c.ended_at.type).label("ended_at"),
            )
            .select_from(schema.catheter)
            .outerjoin(cycle, cycle.c.catheter_label == schema.catheter.c.label)
            .outerjoin(end, end.c.cycle_id == cycle.c.id)
            .where(schema.catheter.c.label == label)
            .group_by(schema.catheter.c.first_used_at)
        )
        with self.database.reading() as connection:
            row = connection.execute(query).one_or_none()
        if row is None:
            return None
        moment = self._clock() if at is None else to_utc(at)
        latest = max(filter(None, (moment, row.first_used_at, row.started_at, row.ended_at)))
        earliest = min(filter(None, (row.first_used_at, row.earliest_at)))
        return float((latest - earliest).total_seconds())

    def head(self) -> Head:
        """Present head of the trail: note it elsewhere, and a trail cut off later is found."""
        with self.database.reading() as connection:
            return read_head(connection)

    def audit(self, expected: str | None = None) -> AuditReport:
        """Read the whole trail and the recordings that it binds, where each was written.

        expected: the hash of a head noted before.
        """
        return audit.audit(self.database, audit.AuditScope(expected))
