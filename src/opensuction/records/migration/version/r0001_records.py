"""The first version: all tables, the trail, and what guards them.

Written out, so that it stays what it was whatever the program becomes.
"""

from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None

FILE_TABLE = """
CREATE TABLE {name} (
    sha256 TEXT NOT NULL CONSTRAINT ck_{name}_sha256 CHECK (length(sha256) BETWEEN 64 AND 64),
    name TEXT NOT NULL CONSTRAINT ck_{name}_name CHECK (length(name) BETWEEN 1 AND 64),
    content TEXT NOT NULL
        CONSTRAINT ck_{name}_content CHECK (length(content) BETWEEN 0 AND 1000000),
    known_since {instant} NOT NULL,
    CONSTRAINT pk_{name} PRIMARY KEY (sha256)
)"""
TABLES = (
    """
CREATE TABLE machine (
    serial TEXT NOT NULL CONSTRAINT ck_machine_serial CHECK (length(serial) BETWEEN 1 AND 64),
    kind TEXT NOT NULL CONSTRAINT ck_machine_kind CHECK (length(kind) BETWEEN 1 AND 64),
    is_twin BOOLEAN NOT NULL CONSTRAINT ck_machine_is_twin CHECK (is_twin IN (TRUE, FALSE)),
    known_since {instant} NOT NULL,
    CONSTRAINT pk_machine PRIMARY KEY (serial)
)""",
    """
CREATE TABLE catheter (
    label TEXT NOT NULL CONSTRAINT ck_catheter_label CHECK (length(label) BETWEEN 1 AND 64),
    size_fr INTEGER NOT NULL CONSTRAINT ck_catheter_size_fr CHECK (size_fr BETWEEN 1 AND 30),
    life_s INTEGER NOT NULL CONSTRAINT ck_catheter_life_s CHECK (life_s BETWEEN 1 AND 86400),
    first_used_at {instant} NOT NULL,
    CONSTRAINT pk_catheter PRIMARY KEY (label)
)""",
    """
CREATE TABLE patient (
    pseudonym TEXT NOT NULL
        CONSTRAINT ck_patient_pseudonym CHECK (length(pseudonym) BETWEEN 1 AND 64),
    known_since {instant} NOT NULL,
    CONSTRAINT pk_patient PRIMARY KEY (pseudonym)
)""",
    FILE_TABLE.replace("{name}", "protocol"),
    FILE_TABLE.replace("{name}", "parameter_file"),
    """
CREATE TABLE cycle (
    id TEXT NOT NULL CONSTRAINT ck_cycle_id CHECK (length(id) BETWEEN 1 AND 64),
    machine_serial TEXT NOT NULL
        CONSTRAINT fk_cycle_machine_serial REFERENCES machine (serial),
    number INTEGER NOT NULL CONSTRAINT ck_cycle_number CHECK (number >= 1),
    catheter_label TEXT NOT NULL
        CONSTRAINT fk_cycle_catheter_label REFERENCES catheter (label),
    patient_pseudonym TEXT CONSTRAINT fk_cycle_patient_pseudonym REFERENCES patient (pseudonym),
    protocol_sha256 TEXT NOT NULL
        CONSTRAINT fk_cycle_protocol_sha256 REFERENCES protocol (sha256),
    parameter_file_sha256 TEXT
        CONSTRAINT fk_cycle_parameter_file_sha256 REFERENCES parameter_file (sha256),
    approach TEXT NOT NULL CONSTRAINT ck_cycle_approach CHECK (approach IN ('travel', 'contact')),
    requested_by TEXT NOT NULL
        CONSTRAINT ck_cycle_requested_by CHECK (length(requested_by) BETWEEN 1 AND 64),
    software TEXT NOT NULL CONSTRAINT ck_cycle_software CHECK (length(software) BETWEEN 1 AND 64),
    settings_sha256 TEXT
        CONSTRAINT ck_cycle_settings_sha256 CHECK (length(settings_sha256) BETWEEN 64 AND 64),
    recording TEXT CONSTRAINT ck_cycle_recording CHECK (length(recording) BETWEEN 1 AND 4000),
    started_at {instant} NOT NULL,
    CONSTRAINT pk_cycle PRIMARY KEY (id),
    CONSTRAINT uq_cycle_machine_serial UNIQUE (machine_serial, number)
)""",
    """
CREATE TABLE cycle_end (
    cycle_id TEXT NOT NULL CONSTRAINT fk_cycle_end_cycle_id REFERENCES cycle (id),
    outcome TEXT NOT NULL CONSTRAINT ck_cycle_end_outcome
        CHECK (outcome IN ('completed', 'aborted', 'interrupted')),
    detail TEXT NOT NULL CONSTRAINT ck_cycle_end_detail CHECK (length(detail) BETWEEN 0 AND 4000),
    inside_at_end BOOLEAN
        CONSTRAINT ck_cycle_end_inside_at_end CHECK (inside_at_end IN (TRUE, FALSE)),
    ended_at {instant} NOT NULL,
    CONSTRAINT pk_cycle_end PRIMARY KEY (cycle_id)
)""",
    """
CREATE TABLE alarm (
    id TEXT NOT NULL CONSTRAINT ck_alarm_id CHECK (length(id) BETWEEN 1 AND 64),
    machine_serial TEXT NOT NULL
        CONSTRAINT fk_alarm_machine_serial REFERENCES machine (serial),
    number INTEGER NOT NULL CONSTRAINT ck_alarm_number CHECK (number >= 1),
    cycle_id TEXT CONSTRAINT fk_alarm_cycle_id REFERENCES cycle (id),
    condition TEXT NOT NULL
        CONSTRAINT ck_alarm_condition CHECK (length(condition) BETWEEN 1 AND 64),
    priority TEXT NOT NULL
        CONSTRAINT ck_alarm_priority CHECK (priority IN ('low', 'medium', 'high')),
    detail TEXT NOT NULL CONSTRAINT ck_alarm_detail CHECK (length(detail) BETWEEN 0 AND 4000),
    raised_at {instant} NOT NULL,
    CONSTRAINT pk_alarm PRIMARY KEY (id),
    CONSTRAINT uq_alarm_machine_serial UNIQUE (machine_serial, number)
)""",
    """
CREATE TABLE action (
    id TEXT NOT NULL CONSTRAINT ck_action_id CHECK (length(id) BETWEEN 1 AND 64),
    number INTEGER NOT NULL CONSTRAINT ck_action_number CHECK (number >= 1),
    done_by TEXT NOT NULL CONSTRAINT ck_action_done_by CHECK (length(done_by) BETWEEN 1 AND 64),
    what TEXT NOT NULL CONSTRAINT ck_action_what CHECK (length(what) BETWEEN 1 AND 64),
    detail TEXT NOT NULL CONSTRAINT ck_action_detail CHECK (length(detail) BETWEEN 0 AND 4000),
    machine_serial TEXT CONSTRAINT fk_action_machine_serial REFERENCES machine (serial),
    cycle_id TEXT CONSTRAINT fk_action_cycle_id REFERENCES cycle (id),
    done_at {instant} NOT NULL,
    CONSTRAINT pk_action PRIMARY KEY (id),
    CONSTRAINT uq_action_number UNIQUE (number)
)""",
    """
CREATE TABLE request (
    key TEXT NOT NULL CONSTRAINT ck_request_key CHECK (length(key) BETWEEN 1 AND 64),
    digest TEXT NOT NULL CONSTRAINT ck_request_digest CHECK (length(digest) BETWEEN 64 AND 64),
    result TEXT NOT NULL CONSTRAINT ck_request_result CHECK (length(result) BETWEEN 0 AND 64),
    taken_at {instant} NOT NULL,
    CONSTRAINT pk_request PRIMARY KEY (key)
)""",
    """
CREATE TABLE audit (
    sequence {sequence} NOT NULL CONSTRAINT ck_audit_sequence CHECK (sequence >= 1),
    previous TEXT NOT NULL
        CONSTRAINT ck_audit_previous CHECK (length(previous) BETWEEN 64 AND 64),
    hash TEXT NOT NULL CONSTRAINT ck_audit_hash CHECK (length(hash) BETWEEN 64 AND 64),
    entry TEXT NOT NULL,
    CONSTRAINT pk_audit PRIMARY KEY (sequence),
    CONSTRAINT uq_audit_previous UNIQUE (previous),
    CONSTRAINT uq_audit_hash UNIQUE (hash)
)""",
    """
CREATE TABLE audit_head (
    id INTEGER NOT NULL CONSTRAINT ck_audit_head_id CHECK (id = 1),
    sequence {sequence} NOT NULL,
    hash TEXT NOT NULL CONSTRAINT ck_audit_head_hash CHECK (length(hash) BETWEEN 64 AND 64),
    CONSTRAINT pk_audit_head PRIMARY KEY (id)
)""",
    "CREATE INDEX ix_cycle_catheter_label ON cycle (catheter_label)",
    "CREATE INDEX ix_alarm_cycle_id ON alarm (cycle_id)",
    "CREATE INDEX ix_action_machine_serial ON action (machine_serial)",
    f"INSERT INTO audit_head (id, sequence, hash) VALUES (1, 0, '{'0' * 64}')",
)
KEYS = {
    "machine": "serial",
    "catheter": "label",
    "patient": "pseudonym",
    "protocol": "sha256",
    "parameter_file": "sha256",
    "cycle": "id",
    "cycle_end": "cycle_id",
    "alarm": "id",
    "action": "id",
    "request": "key",
    "audit": "sequence",
}
"""Of every table whose rows are never changed or removed."""

KEPT = "records are never changed or removed"
NOT_NEXT = "the trail goes on at its end only"
NOT_LAST = "the head of the trail is its last entry"
NOT_IN_ORDER = "the cycles of a machine are numbered from 1 on"
UNFINISHED = "the machine has a cycle that has not ended"

# INSERT OR REPLACE removes a row without its trigger: hence the first one of each table.
SQLITE_KEEPING = (
    """
CREATE TRIGGER {name}_no_replace BEFORE INSERT ON {name}
WHEN EXISTS (SELECT 1 FROM {name} WHERE {key} = NEW.{key})
BEGIN SELECT RAISE(ABORT, '{kept}'); END""",
    """
CREATE TRIGGER {name}_no_update BEFORE UPDATE ON {name}
BEGIN SELECT RAISE(ABORT, '{kept}'); END""",
    """
CREATE TRIGGER {name}_no_delete BEFORE DELETE ON {name}
BEGIN SELECT RAISE(ABORT, '{kept}'); END""",
)
SQLITE = (
    f"""
CREATE TRIGGER audit_follows BEFORE INSERT ON audit
WHEN NOT EXISTS (
    SELECT 1 FROM audit_head WHERE NEW.sequence = sequence + 1 AND NEW.previous = hash
)
BEGIN SELECT RAISE(ABORT, '{NOT_NEXT}'); END""",
    """
CREATE TRIGGER audit_moves_head AFTER INSERT ON audit
BEGIN UPDATE audit_head SET sequence = NEW.sequence, hash = NEW.hash; END""",
    f"""
CREATE TRIGGER audit_head_follows BEFORE UPDATE ON audit_head
WHEN NEW.id != 1 OR NEW.sequence != OLD.sequence + 1 OR NOT EXISTS (
    SELECT 1 FROM audit WHERE sequence = NEW.sequence AND hash = NEW.hash
)
BEGIN SELECT RAISE(ABORT, '{NOT_LAST}'); END""",
    f"""
CREATE TRIGGER audit_head_no_insert BEFORE INSERT ON audit_head
BEGIN SELECT RAISE(ABORT, '{KEPT}'); END""",
    f"""
CREATE TRIGGER audit_head_no_delete BEFORE DELETE ON audit_head
BEGIN SELECT RAISE(ABORT, '{KEPT}'); END""",
    f"""
CREATE TRIGGER cycle_follows BEFORE INSERT ON cycle
BEGIN
    SELECT RAISE(ABORT, '{NOT_IN_ORDER}') WHERE NEW.number != (
        SELECT coalesce(max(number), 0) + 1 FROM cycle WHERE machine_serial = NEW.machine_serial
    );
    SELECT RAISE(ABORT, '{UNFINISHED}') WHERE EXISTS (
        SELECT 1 FROM cycle
        WHERE machine_serial = NEW.machine_serial AND number = NEW.number - 1
        AND NOT EXISTS (SELECT 1 FROM cycle_end WHERE cycle_id = cycle.id)
    );
END""",
)

POSTGRESQL_KEEPING = """
CREATE TRIGGER {name}_kept BEFORE UPDATE OR DELETE OR TRUNCATE ON {name}
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change()"""
POSTGRESQL = (
    f"""
CREATE FUNCTION refuse_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN RAISE integrity_constraint_violation USING MESSAGE = '{KEPT}'; END $$""",
    f"""
CREATE FUNCTION follow_head() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    IF NOT EXISTS (
        SELECT 1 FROM audit_head WHERE NEW.sequence = sequence + 1 AND NEW.previous = hash
    ) THEN
        RAISE integrity_constraint_violation USING MESSAGE = '{NOT_NEXT}';
    END IF;
    RETURN NEW;
END $$""",
    """
CREATE FUNCTION move_head() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE audit_head SET sequence = NEW.sequence, hash = NEW.hash;
    RETURN NULL;
END $$""",
    f"""
CREATE FUNCTION follow_trail() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    IF NEW.id != 1 OR NEW.sequence != OLD.sequence + 1 OR NOT EXISTS (
        SELECT 1 FROM audit WHERE sequence = NEW.sequence AND hash = NEW.hash
    ) THEN
        RAISE integrity_constraint_violation USING MESSAGE = '{NOT_LAST}';
    END IF;
    RETURN NEW;
END $$""",
    f"""
CREATE FUNCTION follow_cycle() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    IF NEW.number != (
        SELECT coalesce(max(number), 0) + 1 FROM cycle WHERE machine_serial = NEW.machine_serial
    ) THEN
        RAISE integrity_constraint_violation USING MESSAGE = '{NOT_IN_ORDER}';
    END IF;
    IF EXISTS (
        SELECT 1 FROM cycle
        WHERE machine_serial = NEW.machine_serial AND number = NEW.number - 1
        AND NOT EXISTS (SELECT 1 FROM cycle_end WHERE cycle_id = cycle.id)
    ) THEN
        RAISE integrity_constraint_violation USING MESSAGE = '{UNFINISHED}';
    END IF;
    RETURN NEW;
END $$""",
    """
CREATE TRIGGER audit_follows BEFORE INSERT ON audit
FOR EACH ROW EXECUTE FUNCTION follow_head()""",
    """
CREATE TRIGGER audit_moves_head AFTER INSERT ON audit
FOR EACH ROW EXECUTE FUNCTION move_head()""",
    """
CREATE TRIGGER audit_head_follows BEFORE UPDATE ON audit_head
FOR EACH ROW EXECUTE FUNCTION follow_trail()""",
    """
CREATE TRIGGER audit_head_kept BEFORE INSERT OR DELETE OR TRUNCATE ON audit_head
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change()""",
    """
CREATE TRIGGER cycle_follows BEFORE INSERT ON cycle
FOR EACH ROW EXECUTE FUNCTION follow_cycle()""",
)


def upgrade() -> None:
    """Make everything."""
    connection = op.get_bind()
    sqlite = connection.dialect.name == "sqlite"
    types = {
        "instant": "DATETIME" if sqlite else "TIMESTAMP WITH TIME ZONE",
        "sequence": "INTEGER" if sqlite else "BIGINT",
    }
    statements = [statement.format_map(types) for statement in TABLES]
    statements += SQLITE if sqlite else POSTGRESQL
    for name, key in KEYS.items():
        for statement in SQLITE_KEEPING if sqlite else (POSTGRESQL_KEEPING,):
            statements.append(statement.format(name=name, key=key, kept=KEPT))
    for statement in statements:
        # As it stands: a percent sign or a colon in it is no parameter.
        connection.exec_driver_sql(statement)


def downgrade() -> None:
    """There is no way back: an older program refuses, a copy from before is kept."""
    raise NotImplementedError
