"""Requests as the runtime makes them, and a hand that changes what must not be changed."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta

from sqlalchemy import Connection, text

from opensuction.records.account_rows import AccessToken, AccountState, store_state, store_token
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
)
from opensuction.records.records import Records
from opensuction.records.request import Request
from opensuction.records.request import act as store_action
from opensuction.records.trail import chain

MACHINE = Machine("M-1", "clinical", True)
CATHETER = Catheter("C-1", 12, 86_400)
PROTOCOL = SettingsFile("adult", "depth_mm = 90\n")
NOON = datetime(2026, 11, 23, 12, 0, 0, 7, tzinfo=UTC)
RECORDING = BoundFile("a.mcap", "a.mcap", 1, "/nowhere", 7, "0f" * 32, True)
COMPLETED = CycleEnd(Outcome.COMPLETED, "", False)
CLOGGED = Alarm("LINE_CLOGGED", "high", "nothing came")


def start(
    machine: str = "M-1", catheter: str = "C-1", patient: str | None = "P-0042"
) -> CycleStart:
    return CycleStart(
        machine=MACHINE._replace(serial=machine),
        catheter=CATHETER._replace(label=catheter),
        protocol=PROTOCOL,
        approach="travel",
        requested_by="nurse-7",
        software="opensuction 0.1.0",
        patient=patient,
        parameter_file=SettingsFile("calibration.toml", "slope = 0.97\n"),
        settings_sha256="0f" * 32,
        recording="2026-11-23/0001.mcap",
    )


class Clock:
    """A clock that goes on by a second a look, and can be set."""

    def __init__(self) -> None:
        self.at = NOON

    def __call__(self) -> datetime:
        self.at += timedelta(seconds=1)
        return self.at


def fill(records: Records, cycles: int = 3) -> None:
    """Some cycles with alarms, and actions."""
    for number in range(cycles):
        cycle = records.begin_cycle(start(catheter=f"C-{number}"), key=f"begin-{number}")
        records.add_alarm(MACHINE, CLOGGED, cycle)
        records.end_cycle(cycle, COMPLETED)
        records.act(Action("nurse-7", "reset", "after a clog", "M-1", cycle))


def fill_accounts(records: Records) -> None:
    """An account and an access token, as the accounts put them on record."""
    with records.database.writing() as connection:
        request = Request(connection, NOON, NOON)
        done = store_action(request, Action("anna", "add-account", "bert"))
        store_state(request, done, AccountState("bert", "clinician", False, True))
        done = store_action(request, Action("anna", "issue-token", "ward display"))
        later = NOON + timedelta(days=30)
        store_token(request, done, AccessToken("t-1", "ward display", "see-history", later))


def count_entries(records: Records) -> int:
    return records.head().sequence


@contextmanager
def unguarded(records: Records) -> Iterator[Connection]:
    """A hand that may do anything: triggers are off in here, and there again afterwards."""
    with records.database.writing() as connection:
        if connection.dialect.name == "postgresql":
            connection.execute(text("SET LOCAL session_replication_role = replica"))
            yield connection
            return
        query = text("SELECT name, sql FROM sqlite_master WHERE type = 'trigger'")
        triggers = connection.execute(query).all()
        for name, _ in triggers:
            connection.exec_driver_sql(f"DROP TRIGGER {name}")
        connection.exec_driver_sql("PRAGMA defer_foreign_keys = ON")
        yield connection
        for _, statement in triggers:
            connection.exec_driver_sql(statement)


class EnoughError(Exception):
    """Rolls a transaction back."""


def check_after(records: Records, change: str | Callable[[Connection], None]) -> str | None:
    """What an audit of the trail says after a change that is not kept."""
    report = None
    with (
        suppress(EnoughError),
        unguarded(records) as connection,
    ):
        if isinstance(change, str):
            connection.exec_driver_sql(change)
        else:
            change(connection)
        report = chain.check(connection, frozenset())
        raise EnoughError
    assert report is not None
    return report.broken
