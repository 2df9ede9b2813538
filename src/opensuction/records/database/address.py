"""Address of the database of records: a file's path, or a URL."""

import os
from pathlib import Path
from typing import NamedTuple

import platformdirs
from sqlalchemy import URL, make_url
from sqlalchemy.exc import ArgumentError

from opensuction.records.database.failure import RecordsError, refused

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
