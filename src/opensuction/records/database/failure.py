"""Failures of a database, each as one plain line."""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy import exc

from opensuction.kernel.errors import InputError
from opensuction.settings.wording import refuse

NOTHING = "nothing of this request was stored"
"""What holds after each of these: a request is one transaction."""

LOCKED = f"another program keeps it locked; {NOTHING}; try again"
FULL = f"the disk is full; {NOTHING}; make room and try again"
UNWRITABLE = f"may not be written; {NOTHING}; look at the rights of file and folder"

SQLITE = {
    sqlite3.SQLITE_BUSY: LOCKED,
    sqlite3.SQLITE_LOCKED: LOCKED,
    sqlite3.SQLITE_FULL: FULL,
    sqlite3.SQLITE_IOERR: f"the disk failed or is full; {NOTHING}; look at it and try again",
    sqlite3.SQLITE_READONLY: UNWRITABLE,
    sqlite3.SQLITE_PERM: UNWRITABLE,
    sqlite3.SQLITE_CANTOPEN: "cannot be opened; look at the rights of file and folder",
    sqlite3.SQLITE_CORRUPT: "is damaged; keep the file, and go on with a copy from before",
    sqlite3.SQLITE_NOTADB: "is damaged, or no database of SQLite; name another file",
}
"""By the primary result code of SQLite."""

POSTGRESQL = {
    "25006": f"may only be read; {NOTHING}; look at the server",
    "28000": "the server does not let this user in; look at the user's name",
    "28P01": "the password is wrong or missing; look at PGPASSWORD or ~/.pgpass",
    "3D000": "the server has no such database; create it with createdb",
    "42501": f"the user lacks the right ({{said}}); {NOTHING}; look at what the database grants",
    "53100": FULL,
    "53300": f"the server takes no more connections; {NOTHING}; try again",
    "55P03": LOCKED,
    "57014": f"the server took too long; {NOTHING}; try again",
}
"""By the SQLSTATE of PostgreSQL; ``{said}``: what the server said."""

REFUSALS = {
    "no password supplied": "28P01",
    "password authentication failed": "28P01",
    "FATAL:  database": "3D000",
    "FATAL:  role": "28000",
    "no pg_hba.conf entry": "28000",
    "too many clients": "53300",
}
"""Words of a server that refuses a connection."""

LOST = "the server is not there or went away; is it running, and is its address right? Try again"


class RecordsError(InputError):
    """The database cannot be used, or does not take a request; the message says what to do.

    A request that raised it left nothing behind, or, where the server went away as it ended, all of
    it: the same request with the same key may be sent again.
    """


def refused(shown: str, problem: str) -> RecordsError:
    """The error, on one line, for a problem that a database has. shown: without its password."""
    return RecordsError(str(refuse(shown, problem)))


def _explain_sqlite(error: sqlite3.Error) -> str:
    code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR) & 0xFF
    if code == sqlite3.SQLITE_CONSTRAINT:
        return f"does not take the entry: {error}"
    return SQLITE.get(code, f"{error}; {NOTHING}")


def _explain_connection(said: str) -> str:
    """Explain what a server says before it gives its errors a number."""
    for words, state in REFUSALS.items():
        if words in said:
            return POSTGRESQL[state]
    return LOST


def _explain_postgresql(error: BaseException) -> str:
    state = getattr(error, "sqlstate", None)
    if state is None and type(error).__name__ == "OperationalError":
        return _explain_connection(str(error))
    if state is None:
        return f"{error}; {NOTHING}"
    said = getattr(getattr(error, "diag", None), "message_primary", None) or str(error)
    if state in POSTGRESQL:
        return POSTGRESQL[state].format(said=said)
    if state.startswith(("08", "57P")):
        return LOST
    if state.startswith(("22", "23")):
        return f"does not take the entry: {said}"
    return f"{said}; {NOTHING}"


@contextmanager
def explaining(shown: str) -> Iterator[None]:
    """Turn errors of a database into a `RecordsError`."""
    try:
        yield
    except sqlite3.Error as error:
        raise refused(shown, _explain_sqlite(error)) from error
    except exc.DBAPIError as error:
        cause = error.orig
        if isinstance(cause, sqlite3.Error):
            raise refused(shown, _explain_sqlite(cause)) from error
        raise refused(shown, _explain_postgresql(cause or error)) from error
    except exc.SQLAlchemyError as error:  # such as a pool that is used up
        raise refused(shown, f"{error}; {NOTHING}") from error
