"""A database, opened for writing or only for reading; what SQLite and PostgreSQL differ in."""

import math
import sqlite3
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from sqlalchemy import Connection, Engine, create_engine, event, pool, text

from opensuction.kernel import private_file
from opensuction.records.database import file_lock
from opensuction.records.database.address import Address
from opensuction.records.database.failure import NOTHING, explaining, refused

DURABLE = "PRAGMA synchronous = FULL"
"""A commit is on the disk before the request is answered."""
WRITING = "opensuction_writing"
"""Option of a connection whose transaction writes."""
EXTRA = "pip install 'opensuction[postgresql]'"


class Database(NamedTuple):
    """An open database."""

    address: Address
    engine: Engine
    wait_s: float
    """Longest wait for others who write."""

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """A transaction that sees one state of everything. Raises RecordsError."""
        with explaining(self.address.shown), self.engine.connect() as connection:
            if self.address.file is None:
                connection.execution_options(isolation_level="REPEATABLE READ")
            with connection.begin():
                yield connection

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """A transaction that is stored whole or not at all. Raises RecordsError."""
        with (
            explaining(self.address.shown),
            self._turn(),
            self.engine.connect() as connection,
            connection.execution_options(**{WRITING: True}).begin(),
        ):
            yield connection

    @contextmanager
    def trying(self) -> Iterator[Connection]:
        """As `writing`, and taken back at the end: nothing of it is stored. Raises RecordsError."""
        with self.writing() as connection:
            yield connection
            connection.rollback()

    @contextmanager
    def _turn(self) -> Iterator[None]:
        """Of an SQLite file only one program writes; a server sees to it by itself."""
        with ExitStack() as turn:
            if self.address.file is not None:
                self._wait_for_turn(turn, self.address.file)
            yield

    def _wait_for_turn(self, turn: ExitStack, file: Path) -> None:
        try:
            turn.enter_context(file_lock.hold(file, self.wait_s))
        except TimeoutError:
            raise refused(
                self.address.shown,
                f"another program has been writing for {self.wait_s:g} s; {NOTHING}; try again",
            ) from None
        except OSError as error:
            raise refused(
                self.address.shown, f"cannot be written ({error.strerror}); {NOTHING}"
            ) from None

    def prepare(self) -> None:
        """Have an SQLite file keep a log beside it, so that readers wait for nobody."""
        file = self.address.file
        if file is None:
            return
        with explaining(self.address.shown), self._turn():
            connection = open_sqlite(file, "rw", self.wait_s)
            try:
                connection.execute("PRAGMA journal_mode = WAL")
            finally:
                connection.close()

    def close(self) -> None:
        """Let go of it. Whoever is the last writes SQLite's log back: nobody is beside it then."""
        self.engine.dispose()


def connect(address: Address, wait_s: float, read_only: bool = False) -> Database:
    """A database; nothing of it is looked at yet. Raises RecordsError where a driver is missing."""
    if address.file is not None:
        return Database(address, _sqlite(address.file, wait_s, read_only), wait_s)
    return Database(address, _postgresql(address, wait_s, read_only), wait_s)


def create_file(address: Address) -> None:
    """Make an empty file for a new database, for this user only. Raises RecordsError."""
    if address.file is None or address.file.exists():
        return
    try:
        private_file.make_folder(address.file.parent)
        private_file.append(address.file).close()
    except OSError as error:
        raise refused(
            address.shown, f"cannot be made ({(error.strerror or str(error)).lower()})"
        ) from None


def open_sqlite(file: Path, mode: str, wait_s: float) -> sqlite3.Connection:
    """A connection that begins no transaction by itself. mode: ``rw``, ``ro``, or ``immutable``."""
    wanted = "mode=ro&immutable=1" if mode == "immutable" else f"mode={mode}"
    return sqlite3.connect(
        f"{file.absolute().as_uri()}?{wanted}",
        uri=True,
        timeout=wait_s,
        isolation_level=None,
        check_same_thread=False,
    )


def _open_for_reading(file: Path, wait_s: float) -> sqlite3.Connection:
    """A connection that only reads, where nothing beside the file can be written, too."""
    connection = open_sqlite(file, "ro", wait_s)
    try:
        connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
    except sqlite3.OperationalError as error:
        connection.close()
        log = file.with_name(f"{file.name}-wal")
        unwritable = (error.sqlite_errorcode & 0xFF) in (
            sqlite3.SQLITE_READONLY,
            sqlite3.SQLITE_CANTOPEN,
        )
        if not unwritable or (log.exists() and log.stat().st_size):
            raise
        return open_sqlite(file, "immutable", wait_s)
    return connection


def _sqlite(file: Path, wait_s: float, read_only: bool) -> Engine:

    def open_it() -> sqlite3.Connection:
        if read_only:
            return _open_for_reading(file, wait_s)
        return open_sqlite(file, "rw", wait_s)

    engine = create_engine(
        "sqlite+pysqlite://",
        creator=open_it,
        poolclass=pool.QueuePool,
    )

    @event.listens_for(engine, "connect")
    def prepare(connection: Any, _record: Any) -> None:
        connection.execute("PRAGMA foreign_keys = ON")
        connection.execute(DURABLE)

    @event.listens_for(engine, "begin")
    def begin(connection: Connection) -> None:
        writes = connection.get_execution_options().get(WRITING, False)
        connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")

    return engine


def _postgresql(address: Address, wait_s: float, read_only: bool) -> Engine:
    assert address.url is not None
    wait_ms = math.ceil(wait_s * 1000.0)
    options = f"-c lock_timeout={wait_ms} -c timezone=UTC -c client_encoding=UTF8"
    if read_only:
        options += " -c default_transaction_read_only=on"
    try:
        return create_engine(
            address.url,
            isolation_level="READ COMMITTED",  # writers wait for each other, whatever the default
            connect_args={"connect_timeout": max(2, math.ceil(wait_s)), "options": options},
            pool_pre_ping=True,  # a server that was started anew is no failure
        )
    except ImportError:
        raise refused(address.shown, f"PostgreSQL needs its driver: {EXTRA}") from None


def find_tables(connection: Connection) -> set[str]:
    """Names of the tables that there are."""
    if connection.dialect.name == "sqlite":
        query = "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite_%'"
    else:
        query = "SELECT tablename FROM pg_tables WHERE schemaname = current_schema()"
    return set(connection.execute(text(query)).scalars())


def find_triggers(connection: Connection) -> set[str]:
    """Names of the triggers that there are and that are not switched off."""
    if connection.dialect.name == "sqlite":
        query = "SELECT name FROM sqlite_master WHERE type = 'trigger'"
    else:
        query = (
            "SELECT tgname FROM pg_trigger JOIN pg_class ON pg_class.oid = tgrelid "
            "WHERE NOT tgisinternal AND tgenabled IN ('O', 'A') "
            "AND relnamespace = current_schema()::regnamespace"
        )
    return set(connection.execute(text(query)).scalars())
