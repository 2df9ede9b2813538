"""From whatever version a database has to the one that this program knows.

The triggers that a database of the newest version must have.
"""

import ast
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection, text

from opensuction.kernel import private_file
from opensuction.records.database import schema
from opensuction.records.database.database import Database, find_tables, open_sqlite
from opensuction.records.database.failure import NOTHING, explaining, refused
from opensuction.records.database.utc_time import now

if TYPE_CHECKING:
    from alembic.config import Config

EVERYWHERE = ("audit_follows", "audit_moves_head", "audit_head_follows", "cycle_follows")
OF_SQLITE = ("audit_head_no_insert", "audit_head_no_delete")
OF_POSTGRESQL = ("audit_head_kept",)
KEEPING = {"sqlite": ("no_replace", "no_update", "no_delete"), "postgresql": ("kept",)}
"""After the name of each table whose rows are never changed or removed."""


def name_triggers(dialect: str) -> frozenset[str]:
    """Their names; dialect: sqlite or postgresql."""
    keeping = {f"{table.name}_{end}" for table in schema.KEPT for end in KEEPING[dialect]}
    own = OF_SQLITE if dialect == "sqlite" else OF_POSTGRESQL
    return frozenset(keeping.union(EVERYWHERE, own))


FOLDER = Path(__file__).parent
STEPS = (FOLDER / "version",)
"""Where the steps from version to version are."""
VERSION_TABLE = "alembic_version"
LOCK = 5_837_104_219
"""Of PostgreSQL, for whoever upgrades: a number of this project's own."""


def _configure(steps: tuple[Path, ...]) -> "Config":
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", _literal(FOLDER))
    config.set_main_option("path_separator", "newline")
    config.set_main_option("version_locations", "\n".join(map(_literal, steps)))
    return config


def _literal(path: Path) -> str:
    """A path in which a configuration file replaces nothing."""
    return str(path).replace("%", "%%")


def list_versions() -> list[str]:
    """All versions that this program knows, the oldest first."""
    return list(_list_versions(STEPS))


@cache
def _list_versions(steps: tuple[Path, ...]) -> tuple[str, ...]:
    """See `list_versions`. steps: as `STEPS`; each is read once, which takes some milliseconds.

    Read and not imported: each process of a machine opens a database, and hardly ever one that has
    to be upgraded; Alembic is a sixth of what a recorder would import.
    """
    after = {}
    for file in (file for folder in steps for file in folder.glob("*.py")):
        told = _read_constants(file.read_text(encoding="utf-8"))
        if "revision" in told:
            after[told["down_revision"]] = told["revision"]
    versions, last = [], None
    while last in after:
        last = after[last]
        versions.append(last)
    return tuple(versions)


def _read_constants(source: str) -> dict[str, Any]:
    """Values of the names that a module gives a constant."""
    return {
        target.id: one.value.value
        for one in ast.parse(source).body
        if isinstance(one, ast.Assign) and isinstance(one.value, ast.Constant)
        for target in one.targets
        if isinstance(target, ast.Name)
    }


def find_version(connection: Connection, shown: str) -> str | None:
    """A database's version; None: it is empty.

    Raises RecordsError for a database of something else, or of a newer program.
    """
    tables = find_tables(connection)
    if not tables:
        return None
    version = None
    if VERSION_TABLE in tables:
        named = connection.execute(text(f"SELECT version_num FROM {VERSION_TABLE}")).scalars().all()
        version = str(named[0]) if len(named) == 1 else None
    if version is None or schema.audit.name not in tables:
        some = ", ".join(sorted(tables)[:3])
        raise refused(
            shown,
            f"holds something else ({some}); give the records one of their own",
        )
    known = list_versions()
    if version not in known:
        raise refused(
            shown,
            f"is of a newer opensuction (version {version} of the database; this one knows "
            f"{known[0]} to {known[-1]}); nothing was changed; use that newer one",
        )
    return version


def bring_up_to_date(database: Database) -> Path | None:
    """Bring a database to the newest version, in one transaction; nothing where it has it already.

    Returns where a copy from before lies; None: nothing was there, or the database is a server's.
    """
    newest = list_versions()[-1]
    shown = database.address.shown
    with database.reading() as connection:
        version = find_version(connection, shown)
    database.prepare()  # not before it is known to be one of records
    if version == newest:
        return None
    with database.writing() as connection:
        if connection.dialect.name == "postgresql":
            connection.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": LOCK})
            _check_encoding(connection, shown)
        version = find_version(connection, shown)  # somebody may have been faster
        if version == newest:
            return None
        copy = None
        if version is not None and database.address.file is not None:
            copy = _copy(database, version)
        _upgrade(connection, newest)
    return copy


def _upgrade(connection: Connection, version: str) -> None:
    """Carry out the steps, within the caller's transaction."""
    from alembic.runtime.environment import EnvironmentContext
    from alembic.script import ScriptDirectory

    config = _configure(STEPS)
    scripts = ScriptDirectory.from_config(config)

    def list_steps(present: Any, _context: Any) -> Any:
        return scripts._upgrade_revs(version, present)

    with EnvironmentContext(config, scripts, fn=list_steps, destination_rev=version) as environment:
        environment.configure(connection=connection)
        environment.run_migrations()


def _check_encoding(connection: Connection, shown: str) -> None:
    encoding = connection.execute(text("SHOW server_encoding")).scalar_one()
    if encoding != "UTF8":
        raise refused(
            shown, f"holds text as {encoding}, not all names can be kept in it; use one in UTF8"
        )


def _copy(database: Database, version: str) -> Path:
    """Copy a file before it is changed; whole or not there. Raises RecordsError."""
    file, shown = database.address.file, database.address.shown
    assert file is not None
    copy = file.with_name(f"{file.name}.{version}-{now():%Y%m%dT%H%M%S%fZ}")
    partly = copy.with_name(f"{copy.name}.part")
    with explaining(f"{shown}: copying it to {copy.name}"):
        try:
            private_file.create(partly).close()
            source = open_sqlite(file, "ro", database.wait_s)
            target = open_sqlite(partly, "rw", database.wait_s)
            try:
                source.backup(target)
            finally:
                target.close()
                source.close()
            partly.replace(copy)
        except OSError as error:
            raise refused(shown, f"cannot be copied ({error.strerror}); {NOTHING}") from None
        finally:
            partly.unlink(missing_ok=True)
    return copy
