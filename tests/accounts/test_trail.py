"""Every act of accounts is on record, in the trail, and no secret with it."""

from datetime import timedelta

import pytest
from sqlalchemy import select, text

from opensuction.accounts.accounts import Accounts
from opensuction.kernel.errors import InputError
from opensuction.records.database import schema
from opensuction.records.records import Records
from tests.accounts.example import HERE, PASSWORDS, THERE, Clock, begin, employ
from tests.records.example import unguarded

TYPED = "my password typed as a name"


def live(accounts: Accounts, clock: Clock) -> list[str]:
    """A day of a site; what must be nowhere in the database."""
    first = accounts.first_start()
    admin = begin(accounts)
    anna = employ(accounts, admin, "anna")
    bert = accounts.add(admin, "bert", "observer")
    accounts.change_role(admin, "bert", "engineer", True, "knows the machine")
    reset = accounts.reset_password(admin, "bert")
    token = accounts.issue_token(admin, "display", ["see-history"], timedelta(days=9))
    accounts.revoke_token(admin, token.access.id)
    clock.go_on(minutes=3)
    for name, password in (("anna", "a wrong guess at it"), (TYPED, PASSWORDS["anna"])):
        with pytest.raises(InputError):
            accounts.sign_in(name, password, THERE)
    accounts.change_password(anna.session_token, PASSWORDS["anna"], "lamps under seven rivers")
    again = accounts.sign_in("anna", "lamps under seven rivers", HERE, anna.device_token)
    accounts.sign_out(again.session_token)
    accounts.deactivate(admin, "anna", "left the ward")
    assert first is not None
    return [
        first.one_time_password,
        bert.one_time_password,
        reset.one_time_password,
        token.token,
        TYPED,
        "a wrong guess at it",
        "lamps under seven rivers",
        *PASSWORDS.values(),
        *(one for signed_in in (anna, again) for one in signed_in[:3]),
    ]


def test_every_act_is_on_record_with_who_did_it(
    accounts: Accounts, records: Records, clock: Clock
) -> None:
    live(accounts, clock)
    acts = [(one.done_by, one.what, one.detail) for one in records.history.list_actions()][::-1]
    token = acts[12][2]
    assert acts == [
        ("command-line", "add-account", "admin: the first administrator"),
        ("command-line", "reset-password", "admin: never signed in, started again"),
        ("admin", "sign-in", "from 127.0.0.1"),
        ("admin", "change-password", ""),
        ("admin", "add-account", "anna: clinician"),
        ("anna", "sign-in", "from 127.0.0.1"),
        ("anna", "change-password", ""),
        ("admin", "add-account", "bert: observer"),
        (
            "admin",
            "change-role",
            "bert: engineer and administrator, was observer: knows the machine",
        ),
        ("admin", "reset-password", "bert"),
        ("admin", "issue-token", "display: see-history, until 2026-12-02 12:00 UTC"),
        ("admin", "revoke-token", acts[11][2]),
        ("somebody", "sign-in-refused", token),
        ("somebody", "sign-in-refused", "with a name that nobody has, from 203.0.113.9"),
        ("anna", "change-password", ""),
        ("anna", "sign-in", "from 127.0.0.1"),
        ("anna", "sign-out", ""),
        ("admin", "deactivate-account", "anna: left the ward"),
    ]
    assert token == "as anna, from 203.0.113.9"
    assert acts[11][2].startswith("display (")
    assert records.audit().broken is None


def test_no_secret_is_kept_anywhere(accounts: Accounts, records: Records, clock: Clock) -> None:
    secrets = live(accounts, clock)
    with records.database.reading() as connection:
        tables = (*schema.KEPT, schema.credential, schema.bearer)
        for table in (*tables, schema.attempt):
            kept = str(connection.execute(select(table)).all())
            for one in secrets:
                assert one not in kept, table.name
        digests = [
            *connection.execute(select(schema.bearer.c.digest)).scalars(),
            *connection.execute(select(schema.credential.c.password_hash)).scalars(),
        ]
        trail = str(connection.execute(select(schema.audit.c.entry)).all())
    assert len(digests) > 3
    assert not [one for one in digests if one in trail], "nor what a secret is held against"
    assert "argon2" not in trail


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE account_state SET role = 'clinician' WHERE account = 'bert'",
        "UPDATE account_state SET is_active = TRUE WHERE account = 'anna'",
        "DELETE FROM account_state WHERE account = 'anna' AND number = 2",
        "UPDATE access_token SET scope = 'see-audit'",
    ],
)
def test_rights_changed_behind_the_trail_are_found(
    accounts: Accounts, records: Records, clock: Clock, statement: str
) -> None:
    live(accounts, clock)
    with (
        pytest.raises(InputError, match="never changed or removed"),
        records.database.writing() as connection,
    ):
        connection.execute(text(statement))
    with unguarded(records) as connection:
        connection.execute(text(statement))
    assert records.audit().broken is not None
