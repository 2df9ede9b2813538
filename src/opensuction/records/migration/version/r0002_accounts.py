"""The second version: people's accounts.

Written out, so that it stays what it was whatever the program becomes.
"""

from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None

TABLES = (
    """
CREATE TABLE account_state (
    action_id TEXT NOT NULL CONSTRAINT fk_account_state_action_id REFERENCES action (id),
    account TEXT NOT NULL
        CONSTRAINT ck_account_state_account CHECK (length(account) BETWEEN 1 AND 64),
    number INTEGER NOT NULL CONSTRAINT ck_account_state_number CHECK (number >= 1),
    role TEXT NOT NULL CONSTRAINT ck_account_state_role
        CHECK (role IN ('observer', 'clinician', 'engineer')),
    is_administrator BOOLEAN NOT NULL CONSTRAINT ck_account_state_is_administrator
        CHECK (is_administrator IN (TRUE, FALSE)),
    is_active BOOLEAN NOT NULL
        CONSTRAINT ck_account_state_is_active CHECK (is_active IN (TRUE, FALSE)),
    CONSTRAINT pk_account_state PRIMARY KEY (action_id),
    CONSTRAINT uq_account_state_account UNIQUE (account, number)
)""",
    """
CREATE TABLE access_token (
    id TEXT NOT NULL CONSTRAINT ck_access_token_id CHECK (length(id) BETWEEN 1 AND 64),
    action_id TEXT NOT NULL CONSTRAINT fk_access_token_action_id REFERENCES action (id),
    label TEXT NOT NULL CONSTRAINT ck_access_token_label CHECK (length(label) BETWEEN 1 AND 64),
    scope TEXT NOT NULL CONSTRAINT ck_access_token_scope CHECK (length(scope) BETWEEN 1 AND 4000),
    expires_at {instant} NOT NULL,
    CONSTRAINT pk_access_token PRIMARY KEY (id)
)""",
    """
CREATE TABLE credential (
    account TEXT NOT NULL
        CONSTRAINT ck_credential_account CHECK (length(account) BETWEEN 1 AND 64),
    password_hash TEXT NOT NULL
        CONSTRAINT ck_credential_password_hash CHECK (length(password_hash) BETWEEN 1 AND 512),
    is_one_time BOOLEAN NOT NULL
        CONSTRAINT ck_credential_is_one_time CHECK (is_one_time IN (TRUE, FALSE)),
    set_at {instant} NOT NULL,
    expires_at {instant},
    CONSTRAINT pk_credential PRIMARY KEY (account)
)""",
    """
CREATE TABLE bearer (
    digest TEXT NOT NULL CONSTRAINT ck_bearer_digest CHECK (length(digest) BETWEEN 64 AND 64),
    kind TEXT NOT NULL CONSTRAINT ck_bearer_kind CHECK (kind IN ('session', 'device', 'token')),
    account TEXT CONSTRAINT ck_bearer_account CHECK (length(account) BETWEEN 1 AND 64),
    token_id TEXT CONSTRAINT fk_bearer_token_id REFERENCES access_token (id),
    made_at {instant} NOT NULL,
    seen_at {instant} NOT NULL,
    expires_at {instant} NOT NULL,
    CONSTRAINT pk_bearer PRIMARY KEY (digest)
)""",
    """
CREATE TABLE attempt (
    key TEXT NOT NULL CONSTRAINT ck_attempt_key CHECK (length(key) BETWEEN 64 AND 64),
    failures INTEGER NOT NULL CONSTRAINT ck_attempt_failures CHECK (failures >= 0),
    last_at {instant} NOT NULL,
    CONSTRAINT pk_attempt PRIMARY KEY (key)
)""",
    "CREATE INDEX ix_bearer_account ON bearer (account)",
)
KEYS = {"account_state": "action_id", "access_token": "id"}
"""Of every table whose rows are never changed or removed."""

KEPT = "records are never changed or removed"

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
POSTGRESQL_KEEPING = (
    """
CREATE TRIGGER {name}_kept BEFORE UPDATE OR DELETE OR TRUNCATE ON {name}
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change()""",
)


def upgrade() -> None:
    """Make the tables, and what guards those that are kept."""
    connection = op.get_bind()
    sqlite = connection.dialect.name == "sqlite"
    instant = "DATETIME" if sqlite else "TIMESTAMP WITH TIME ZONE"
    statements = [statement.format(instant=instant) for statement in TABLES]
    for name, key in KEYS.items():
        for statement in SQLITE_KEEPING if sqlite else POSTGRESQL_KEEPING:
            statements.append(statement.format(name=name, key=key, kept=KEPT))
    for statement in statements:
        # As it stands: a percent sign or a colon in it is no parameter.
        connection.exec_driver_sql(statement)


def downgrade() -> None:
    """There is no way back: an older program refuses, a copy from before is kept."""
    raise NotImplementedError
