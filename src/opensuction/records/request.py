"""One request: a transaction that stores all of its rows, each with its entry, or nothing."""

from datetime import datetime
from typing import Any
from uuid import uuid4

from sqlalchemy import ColumnElement, Connection, Table, func, select

from opensuction.kernel.errors import InputError
from opensuction.records import entry
from opensuction.records.database import schema
from opensuction.records.database.statement import select_by
from opensuction.records.entry import (
    Action,
    Alarm,
    BoundFile,
    Catheter,
    CycleEnd,
    CycleStart,
    Machine,
    Outcome,
    SettingsFile,
    to_hash,
)
from opensuction.records.trail.chain import Row, Trail, Value


class Request:
    """One transaction that stores something; whoever else writes waits until it has ended."""

    def __init__(self, connection: Connection, at: datetime, now: datetime) -> None:
        """at: when what it tells of happened. now: when it is written."""
        self.connection = connection
        self.at = at
        self.trail = Trail(connection, now)

    def find(self, table: Table, key: str, value: str) -> dict[str, Any] | None:
        """A row by its key."""
        row = self.connection.execute(select_by(table, key), {key: value}).mappings().one_or_none()
        return None if row is None else dict(row)

    def note(self, table: Table, key: str, since: str, row: Row) -> None:
        """See that a row is there. Raises InputError where one with this key says otherwise."""
        known = self.find(table, key, str(row[key]))
        if known is None:
            self.trail.store(table, {**row, since: self.at})
            return
        for name, value in row.items():
            if known[name] != value:
                raise InputError(
                    f"{table.name} '{row[key]}' is on record with {name} {known[name]}, not {value}"
                )

    def count_up(self, table: Table, *of: ColumnElement[bool]) -> int:
        """The next number of a table's rows, or of some of them; from 1 on."""
        query = select(func.coalesce(func.max(table.c.number), 0)).where(*of)
        return int(self.connection.execute(query).scalar_one()) + 1

    def remember(self, key: str, digest: str, result: str) -> None:
        """Store what the request of a key gave, to give it again."""
        row: dict[str, Value] = {"key": key, "digest": digest, "result": result}
        self.trail.store(schema.request, {**row, "taken_at": self.trail.now})


def find_cycle(request: Request, cycle_id: object) -> dict[str, Any]:
    """The row of a cycle. Raises InputError where there is none."""
    entry.check_name("the cycle's id", cycle_id)
    row = request.find(schema.cycle, "id", str(cycle_id))
    if row is None:
        raise InputError(f"no cycle '{cycle_id}' is on record")
    return row


def _note_file(request: Request, table: Table, file: SettingsFile) -> str:
    """See that a file is on record; the name that it had first stays."""
    if request.find(table, "sha256", file.sha256) is None:
        row = {"sha256": file.sha256, "name": file.name, "content": file.content}
        request.trail.store(table, {**row, "known_since": request.at})
    return file.sha256


def note_machine(request: Request, machine: Machine) -> str:
    """See that a machine is on record. Raises InputError where one of its serial is another."""
    request.note(schema.machine, "serial", "known_since", machine._asdict())
    return machine.serial


def begin_cycle(request: Request, start: CycleStart) -> str:
    """Store a cycle and what is new of machine, catheter, patient and files."""
    note_machine(request, start.machine)
    request.note(schema.catheter, "label", "first_used_at", start.catheter._asdict())
    if start.patient is not None:
        request.note(schema.patient, "pseudonym", "known_since", {"pseudonym": start.patient})
    protocol = _note_file(request, schema.protocol, start.protocol)
    parameters = start.parameter_file
    name = str(uuid4())
    request.trail.store(
        schema.cycle,
        {
            "id": name,
            "machine_serial": start.machine.serial,
            "number": request.count_up(
                schema.cycle, schema.cycle.c.machine_serial == start.machine.serial
            ),
            "catheter_label": start.catheter.label,
            "patient_pseudonym": start.patient,
            "protocol_sha256": protocol,
            "parameter_file_sha256": (
                None
                if parameters is None
                else _note_file(request, schema.parameter_file, parameters)
            ),
            "approach": start.approach,
            "requested_by": start.requested_by,
            "software": start.software,
            "settings_sha256": start.settings_sha256,
            "recording": start.recording,
            "started_at": request.at,
        },
    )
    return name


def end_cycle(request: Request, cycle_id: str, end: CycleEnd) -> str:
    """Store how a cycle ended. Raises InputError for one that is not there, or has ended."""
    find_cycle(request, cycle_id)
    known = request.find(schema.cycle_end, "cycle_id", cycle_id)
    if known is not None:
        raise InputError(f"the cycle {cycle_id} has ended already: {known['outcome']}")
    row = {**end._asdict(), "outcome": str(end.outcome)}
    request.trail.store(schema.cycle_end, {"cycle_id": cycle_id, **row, "ended_at": request.at})
    return cycle_id


def add_alarm(request: Request, machine: Machine, alarm: Alarm, cycle_id: str | None) -> str:
    """Store an alarm, and the machine where that is new."""
    if cycle_id is not None:
        _check_machine(find_cycle(request, cycle_id), machine.serial)
    name = str(uuid4())
    row: dict[str, Value] = {
        "id": name,
        "machine_serial": note_machine(request, machine),
        "number": request.count_up(schema.alarm, schema.alarm.c.machine_serial == machine.serial),
        "cycle_id": cycle_id,
        "condition": alarm.condition,
        "priority": alarm.priority,
        "detail": alarm.detail,
    }
    request.trail.store(schema.alarm, {**row, "raised_at": request.at})
    return name


def bind_recording(request: Request, machine: Machine, file: BoundFile) -> str:
    """Store what a file of a recording holds; one that is on record as it is stays."""
    serial = note_machine(request, machine)
    row = {"machine_serial": serial, **file._asdict()}
    request.note(schema.recording, "name", "bound_at", row)
    return file.name


def act(request: Request, action: Action) -> str:
    """Store what a person did; in a cycle it was done on that cycle's machine."""
    machine = action.machine
    if machine is not None and not request.find(schema.machine, "serial", machine):
        raise InputError(f"no machine '{machine}' is on record")
    if action.cycle_id is not None:
        cycle = find_cycle(request, action.cycle_id)
        machine = cycle["machine_serial"] if machine is None else machine
        _check_machine(cycle, machine)
    name = str(uuid4())
    row: dict[str, Value] = {
        "id": name,
        "number": request.count_up(schema.action),
        "done_by": action.done_by,
        "what": action.what,
        "detail": action.detail,
        "machine_serial": machine,
        "cycle_id": action.cycle_id,
    }
    request.trail.store(schema.action, {**row, "done_at": request.at})
    return name


def _check_machine(cycle: dict[str, Any], machine: object) -> None:
    if cycle["machine_serial"] != machine:
        raise InputError(
            f"the cycle {cycle['id']} is of machine '{cycle['machine_serial']}', not '{machine}'"
        )


def store_one_each(request: Request, name: str) -> None:
    """Store a row in each table that a recorder writes. name: of all that it tells of."""
    machine, file = Machine(name, "trial", is_twin=True), SettingsFile(name, name)
    start = CycleStart(
        machine=machine,
        catheter=Catheter(name, size_fr=1, life_s=1),
        protocol=file,
        approach=entry.APPROACHES[0],
        requested_by=name,
        software=name,
        patient=name,
        parameter_file=file,
    )
    cycle = begin_cycle(request, start)
    add_alarm(request, machine, Alarm(name, entry.PRIORITIES[0]), cycle)
    act(request, Action(name, "trial", cycle_id=cycle))
    recorded = BoundFile(name, name, 1, name, 1, to_hash(name), is_closed=True)
    bind_recording(request, machine, recorded)
    end_cycle(request, cycle, CycleEnd(Outcome.INTERRUPTED))
    request.remember(name, to_hash(name), cycle)
