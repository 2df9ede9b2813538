"""One request: a transaction that stores all of its rows, each with its entry, or nothing."""

from datetime import datetime
from typing import Any
from uuid import uuid4

from sqlalchemy import Connection, Table, func, select

from opensuction.kernel.errors import InputError
from opensuction.records import entry_check
from opensuction.records.database import schema
from opensuction.records.entry import CycleStart, SettingsFile
from opensuction.records.trail.chain import Row, Trail


class Request:
    """One transaction that stores something; whoever else writes waits until it has ended."""

    def __init__(self, connection: Connection, at: datetime, now: datetime) -> None:
        """at: when what it tells of happened. now: when it is written."""
        self.connection = connection
        self.at = at
        self.trail = Trail(connection, now)

    def find(self, table: Table, key: str, value: str) -> dict[str, Any] | None:
        """A row by its key."""
        query = select(table).where(table.c[key] == value)
        row = self.connection.execute(query).mappings().one_or_none()
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


def find_cycle(request: Request, cycle_id: object) -> dict[str, Any]:
    """The row of a cycle. Raises InputError where there is none."""
    entry_check.check_name("the cycle's id", cycle_id)
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


def begin_cycle(request: Request, start: CycleStart) -> str:
    """Store a cycle and what is new of machine, catheter, patient and files."""
    request.note(schema.machine, "serial", "known_since", start.machine._asdict())
    request.note(schema.catheter, "label", "first_used_at", start.catheter._asdict())
    if start.patient is not None:
        request.note(schema.patient, "pseudonym", "known_since", {"pseudonym": start.patient})
    protocol = _note_file(request, schema.protocol, start.protocol)
    parameters = start.parameter_file
    name = str(uuid4())
    cycle = schema.cycle
    numbers = select(func.coalesce(func.max(cycle.c.number), 0)).where(
        cycle.c.machine_serial == start.machine.serial
    )
    request.trail.store(
        cycle,
        {
            "id": name,
            "machine_serial": start.machine.serial,
            "number": request.connection.execute(numbers).scalar_one() + 1,
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
