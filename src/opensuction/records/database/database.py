"""A database, opened for writing or only for reading; what SQLite and PostgreSQL differ in.

Address of the database of records: a file's path, or a URL.

Writers of an SQLite file take turns, with the checkpoint that may follow their commit.

SQLite up to 3.51.2 may lose a commit where a checkpoint runs beside another writer
(benbjohnson/litestream#1432), and is what many systems have. A lock on a file of its own: one on
the database itself would be lost whenever SQLite closes a file of that name.
"""

import math
import os
import sqlite3
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import platformdirs
from sqlalchemy import URL, Connection, Dialect, Engine, create_engine, event, make_url, pool, text
from sqlalchemy.exc import ArgumentError

from opensuction.kernel import private_file
from opensuction.records.database.failure import NOTHING, RecordsError, explaining, refused

AGAIN_S = 0.005
"""How soon the lock is asked for again."""


def name_of(database: Path) -> Path:
    """The file that is locked."""
    return database.with_name(f"{database.name}-lock")


@contextmanager
def hold(database: Path, wait_s: float) -> Iterator[None]:
    """Nobody else writes in here. Raises TimeoutError where somebody did for longer than wait_s.

    It is given back by the system when its process dies.
    """
    if sys.platform == "win32":  # one program at a time is what can be promised there
        yield
        return
    handle = private_file.opener(str(name_of(database)), os.O_RDWR | os.O_CREAT)
    try:
        _take(handle, wait_s)
        yield
    finally:
        os.close(handle)


def _take(handle: int, wait_s: float) -> None:
    import fcntl

    end_s = time.monotonic() + wait_s
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() >= end_s:
                raise TimeoutError from None
            time.sleep(AGAIN_S)
        else:
            return


VARIABLE = "OPENSUCTION_DATABASE"
"""Environment variable that names a database where no option does."""
FORMS = "write a file's path, sqlite:///FILE or postgresql://USER@HOST/NAME"
LONGEST_SHOWN = 60
"""Characters of a name that cannot be one."""
POSTGRESQL_NAMES = ("postgresql", "postgres", "postgresql+psycopg")


class Address(NamedTuple):
    """Address of the records."""

    shown: str
    """As messages show it: no password, no options."""
    file: Path | None
    """Of SQLite; None: a server's."""
    url: URL | None
    """Of a server's database."""


def default() -> str:
    """Default address of the records: the environment's, or the user's own file."""
    named = os.environ.get(VARIABLE)
    return named or str(Path(platformdirs.user_data_path("opensuction")) / "records.db")


def parse(text: str | None = None) -> Address:
    """The address of a database, or of the default one.

    Raises RecordsError for what is none; its words never repeat a password.
    """
    given = default() if text is None else text
    if "\0" in given or not given.strip():
        raise RecordsError(f"an address of a database is missing; {FORMS}")
    if "://" not in given:
        return _file(Path(given))
    try:
        url = make_url(given)
    except (ArgumentError, ValueError):
        raise RecordsError(f"the address of the database cannot be read; {FORMS}") from None
    if url.drivername in ("sqlite", "sqlite+pysqlite"):
        if not url.database or url.database == ":memory:":
            raise RecordsError(f"records in memory would be lost; {FORMS}")
        if url.query:
            raise refused(url.database, f"a file takes no options ('?...'); {FORMS}")
        return _file(Path(url.database))
    if url.drivername not in POSTGRESQL_NAMES:
        raise refused(url.drivername, f"no kind of database that is known here; {FORMS}")
    return _server(url)


def _file(path: Path) -> Address:
    try:
        is_folder = path.is_dir()
        os.fsencode(path)
    except (OSError, ValueError):  # too long, or with half a character in it
        raise refused(str(path)[:LONGEST_SHOWN], f"is no name of a file; {FORMS}") from None
    if is_folder:
        raise refused(str(path), "is a folder; name a file")
    return Address(str(path), path, None)


def _server(url: URL) -> Address:
    shown = URL.create("postgresql", url.username, None, url.host, url.port, url.database)
    address = Address(shown.render_as_string(), None, url.set(drivername="postgresql+psycopg"))
    if not url.database:
        raise refused(address.shown, f"names no database; {FORMS}")
    return address


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
            turn.enter_context(hold(file, self.wait_s))
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


class _Statements(dict[tuple[Any, ...], Any]):
    """Statements as SQLite takes them, whichever file they go to: each is composed once.

    An engine has a dialect of its own, and a statement's key names it; those of SQLite are alike.
    """

    def get(self, key: tuple[Any, ...], default: Any = None) -> Any:
        """The statement of a key; the default where it is not there yet."""
        return super().get(_without_dialect(key), default)

    def __setitem__(self, key: tuple[Any, ...], composed: Any) -> None:
        super().__setitem__(_without_dialect(key), composed)


def _without_dialect(key: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(part for part in key if not isinstance(part, Dialect))


_STATEMENTS = _Statements()


def _sqlite(file: Path, wait_s: float, read_only: bool) -> Engine:

    def open_it() -> sqlite3.Connection:
        if read_only:
            return _open_for_reading(file, wait_s)
        return open_sqlite(file, "rw", wait_s)

    engine = create_engine(
        "sqlite+pysqlite://",
        creator=open_it,
        poolclass=pool.QueuePool,
        execution_options={"compiled_cache": _STATEMENTS},
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


class Refusals(NamedTuple):
    """Decisions of a simulated disk on the transactions of an SQLite file."""

    begin: Callable[[], int]
    """Code of SQLite with which one is refused as it begins; `OK`: it is not."""
    commit: Callable[[], int]
    """Likewise as one that writes ends."""
    is_stored: Callable[[], bool]
    """True where it is refused as it ends, and was stored all the same."""
    ending: Callable[[Callable[[], object]], None]
    """Called as one that writes ends, with what stores it: whoever commits may die in it."""


OK, BUSY, NO_ROOM, DISK_ERROR = (
    sqlite3.SQLITE_OK,
    sqlite3.SQLITE_BUSY,
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_IOERR,
)


def interpose(database: Database, refusals: Refusals) -> None:
    """Have transactions of an SQLite file refused as SQLite itself refuses them."""

    def refuse(code: int) -> None:
        if code != OK:
            error = sqlite3.OperationalError("refused")
            error.sqlite_errorcode = code
            raise error

    def commit(connection: Connection) -> None:
        if not connection.get_execution_options().get(WRITING, False):
            return
        refusals.ending(connection.connection.commit)
        code = refusals.commit()
        if code != OK:
            if refusals.is_stored():
                connection.connection.commit()
            refuse(code)

    event.listen(database.engine, "begin", lambda _: refuse(refusals.begin()), insert=True)
    event.listen(database.engine, "commit", commit)


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
