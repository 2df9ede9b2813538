"""The third version: files of recordings, each with its hash.

Written out, so that it stays what it was whatever the program becomes.
"""

from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

TABLES = (
    """
CREATE TABLE recording (
    name TEXT NOT NULL CONSTRAINT ck_recording_name CHECK (length(name) BETWEEN 1 AND 64),
    machine_serial TEXT NOT NULL
        CONSTRAINT fk_recording_machine_serial REFERENCES machine (serial),
    cycle_recording TEXT NOT NULL
        CONSTRAINT ck_recording_cycle_recording CHECK (length(cycle_recording) BETWEEN 1 AND 64),
    part INTEGER NOT NULL CONSTRAINT ck_recording_part CHECK (part >= 1),
    folder TEXT NOT NULL
        CONSTRAINT ck_recording_folder CHECK (length(folder) BETWEEN 1 AND 4000),
    size_bytes {size} NOT NULL CONSTRAINT ck_recording_size_bytes CHECK (size_bytes >= 0),
    sha256 TEXT NOT NULL
        CONSTRAINT ck_recording_sha256 CHECK (length(sha256) BETWEEN 64 AND 64),
    is_closed BOOLEAN NOT NULL
        CONSTRAINT ck_recording_is_closed CHECK (is_closed IN (TRUE, FALSE)),
    bound_at {instant} NOT NULL,
    CONSTRAINT pk_recording PRIMARY KEY (name)
)""",
    "CREATE INDEX ix_recording_cycle_recording ON recording (cycle_recording)",
)
KEPT = "records are never changed or removed"

# INSERT OR REPLACE removes a row without its trigger: hence the first one.
SQLITE_KEEPING = (
    f"""
CREATE TRIGGER recording_no_replace BEFORE INSERT ON recording
WHEN EXISTS (SELECT 1 FROM recording WHERE name = NEW.name)
BEGIN SELECT RAISE(ABORT, '{KEPT}'); END""",
    f"""
CREATE TRIGGER recording_no_update BEFORE UPDATE ON recording
BEGIN SELECT RAISE(ABORT, '{KEPT}'); END""",
    f"""
CREATE TRIGGER recording_no_delete BEFORE DELETE ON recording
BEGIN SELECT RAISE(ABORT, '{KEPT}'); END""",
)
POSTGRESQL_KEEPING = (
    """
CREATE TRIGGER recording_kept BEFORE UPDATE OR DELETE OR TRUNCATE ON recording
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change()""",
)


def upgrade() -> None:
    """Make the table, and what guards it."""
    connection = op.get_bind()
    sqlite = connection.dialect.name == "sqlite"
    types = {
        "instant": "DATETIME" if sqlite else "TIMESTAMP WITH TIME ZONE",
        "size": "INTEGER" if sqlite else "BIGINT",
    }
    statements = [statement.format(**types) for statement in TABLES]
    for statement in (*statements, *(SQLITE_KEEPING if sqlite else POSTGRESQL_KEEPING)):
        # As it stands: a percent sign or a colon in it is no parameter.
        connection.exec_driver_sql(statement)


def downgrade() -> None:
    """There is no way back: an older program refuses, a copy from before is kept."""
    raise NotImplementedError
