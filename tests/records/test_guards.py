"""The database itself refuses what must not be, whoever asks, whatever the program does."""

from pathlib import Path

import pytest

from opensuction.kernel.errors import InputError
from opensuction.records import audit
from opensuction.records.database import schema
from opensuction.records.records import Records
from opensuction.records.trail.chain import AuditReport
from tests.records.conftest import on_both
from tests.records.example import MACHINE, RECORDING, fill, fill_accounts

CHANGES = [
    statement
    for table in schema.KEPT
    for column in list(table.columns)[-1:]
    for statement in (
        f"UPDATE {table.name} SET {column.name} = {column.name}",
        f"DELETE FROM {table.name}",
    )
] + [
    "UPDATE audit_head SET sequence = 0",
    f"UPDATE audit_head SET hash = '{'1' * 64}'",
    "DELETE FROM audit_head",
    f"INSERT INTO audit_head (id, sequence, hash) VALUES (2, 0, '{'0' * 64}')",
    f"INSERT INTO audit (sequence, previous, hash, entry) "
    f"VALUES (99, '{'0' * 64}', '{'1' * 64}', '')",
    "UPDATE machine SET kind = 'bench'",
    "INSERT INTO cycle_end (cycle_id, outcome, detail, ended_at) "
    "VALUES ('nowhere', 'completed', '', '2026-11-23 12:00:00')",
]
CONSTRAINTS = [
    "INSERT INTO machine VALUES ('', 'bench', TRUE, '2026-11-23 12:00:00')",
    "INSERT INTO catheter VALUES ('C-9', 99, 86400, '2026-11-23 12:00:00')",
    "INSERT INTO catheter VALUES ('C-9', 12, 86401, '2026-11-23 12:00:00')",
    "INSERT INTO protocol VALUES ('00', 'adult', '', '2026-11-23 12:00:00')",
    "INSERT INTO alarm SELECT 'a', 'M-1', 9, id, 'X', 'urgent', '', started_at FROM cycle",
    "INSERT INTO alarm SELECT 'a', 'M-1', 9, 'nowhere', 'X', 'high', '', started_at FROM cycle",
    "INSERT INTO alarm SELECT 'a', 'nowhere', 9, id, 'X', 'high', '', started_at FROM cycle",
    "INSERT INTO alarm SELECT 'a', 'M-1', 1, id, 'X', 'high', '', started_at FROM cycle",
    "INSERT INTO action SELECT 'a', 9, '', 'reset', '', NULL, NULL, started_at FROM cycle",
    "INSERT INTO action SELECT 'a', 1, 'anna', 'reset', '', NULL, NULL, started_at FROM cycle",
    "INSERT INTO account_state SELECT id, 'bert', 1, 'clinician', FALSE, TRUE FROM action "
    "WHERE number = 1",
    "INSERT INTO account_state SELECT id, 'cora', 1, 'root', FALSE, TRUE FROM action "
    "WHERE number = 1",
    "INSERT INTO account_state VALUES ('nowhere', 'cora', 1, 'observer', FALSE, TRUE)",
    "INSERT INTO bearer VALUES ('00', 'session', 'bert', NULL, '2026-11-23 12:00:00', "
    "'2026-11-23 12:00:00', '2026-11-23 12:00:00')",
    f"INSERT INTO bearer VALUES ('{'0' * 64}', 'token', NULL, 'nowhere', '2026-11-23 12:00:00', "
    "'2026-11-23 12:00:00', '2026-11-23 12:00:00')",
    f"INSERT INTO recording VALUES ('a', 'M-1', 'a', 0, '/', 1, '{'0' * 64}', TRUE, "
    "'2026-11-23 12:00:00')",
    f"INSERT INTO recording VALUES ('a', 'M-1', 'a', 1, '/', -1, '{'0' * 64}', TRUE, "
    "'2026-11-23 12:00:00')",
    "INSERT INTO recording VALUES ('a', 'M-1', 'a', 1, '/', 1, '00', TRUE, '2026-11-23 12:00:00')",
    "INSERT INTO cycle SELECT 'a', machine_serial, 7, catheter_label, patient_pseudonym, "
    "protocol_sha256, parameter_file_sha256, approach, requested_by, software, settings_sha256, "
    "recording, started_at FROM cycle",
    "INSERT INTO cycle SELECT 'a', machine_serial, 2, catheter_label, 'nobody', "
    "protocol_sha256, parameter_file_sha256, approach, requested_by, software, settings_sha256, "
    "recording, started_at FROM cycle",
]


def trail_of(records: Records) -> AuditReport:
    """Without the recording, which nobody has written."""
    return audit.audit(records.database, audit.AuditScope(reads_recordings=False))


def refuse(records: Records, statement: str) -> str:
    """What is said of a statement that the database must not take."""
    with (
        pytest.raises(InputError, match="does not take the entry") as refused,
        records.database.writing() as connection,
    ):
        connection.exec_driver_sql(statement)
    return str(refused.value)


@on_both
def test_nothing_is_changed_or_removed(url: str) -> None:
    with Records.open(url) as records:
        fill(records, 1)
        fill_accounts(records)
        records.bind_recording(MACHINE, RECORDING)
        before = records.head()
        for statement in CHANGES:
            assert len(refuse(records, statement).splitlines()) == 1
        assert records.head() == before
        assert trail_of(records).broken is None


@on_both
def test_what_cannot_be_is_refused(url: str) -> None:
    with Records.open(url) as records:
        fill(records, 1)
        fill_accounts(records)
        records.bind_recording(MACHINE, RECORDING)
        for statement in CONSTRAINTS:
            refuse(records, statement)


def test_the_server_refuses_to_empty_a_table(postgresql_url: str) -> None:
    with Records.open(postgresql_url) as records:
        fill(records, 1)
        fill_accounts(records)
        records.bind_recording(MACHINE, RECORDING)
        for table in (*schema.KEPT, schema.audit_head):
            assert "never changed" in refuse(records, f"TRUNCATE {table.name} CASCADE")
        assert trail_of(records).broken is None


def test_sqlite_replaces_nothing(tmp_path: Path) -> None:
    """INSERT OR REPLACE removes a row without the trigger that guards it."""
    with Records.open(str(tmp_path / "records.db")) as records:
        fill(records, 1)
        fill_accounts(records)
        records.bind_recording(MACHINE, RECORDING)
        for table in (*schema.KEPT, schema.audit_head):
            refuse(records, f"INSERT OR REPLACE INTO {table.name} SELECT * FROM {table.name}")
        assert trail_of(records).broken is None
