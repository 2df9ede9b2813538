"""A PostgreSQL cluster of its own: in a temporary folder, on a free port, never as root.

``python -m tests.records.postgresql_cluster COMMAND...`` runs a command beside one; tests find it
by the environment variable `VARIABLE`, and start one themselves where that is not set.
"""

import os
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

VARIABLE = "OPENSUCTION_TEST_POSTGRESQL"
"""URL of a server where tests may make databases."""
INSTALLED = Path("/usr/lib/postgresql")
"""Where Debian keeps the programs of each version, out of the search path."""
ACCOUNT = "postgres"
RUNUSER = shutil.which("runuser", path=f"{os.environ.get('PATH', os.defpath)}:/usr/sbin:/sbin")
"""It lies where a search path that is kept short does not lead."""


def find_programs() -> Path | None:
    """The folder of initdb and pg_ctl, of the newest version; None: not installed."""
    versions = [folder for folder in INSTALLED.glob("*/bin") if (folder / "initdb").exists()]
    if versions:
        return max(versions, key=lambda folder: int(folder.parent.name))
    found = shutil.which("initdb")
    return None if found is None else Path(found).resolve().parent


def _run(*command: str | Path) -> None:
    """Run a program, under the account of the server where this is root."""
    words = [str(word) for word in command]
    if os.geteuid() == 0:
        words = [RUNUSER or "runuser", "-u", ACCOUNT, "--", *words]
    done = subprocess.run(words, cwd="/", capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(words)}: {done.stdout}{done.stderr}")


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
    return port


@contextmanager
def running(programs: Path) -> Iterator[str]:
    """A cluster for as long as this lasts; its URL."""
    folder = Path(tempfile.mkdtemp(prefix="opensuction-postgresql-"))
    try:
        password = secrets.token_hex(16)
        (folder / "password").write_text(password, encoding="utf-8")
        if os.geteuid() == 0:
            shutil.chown(folder, ACCOUNT)
            shutil.chown(folder / "password", ACCOUNT)
        data, log, port = folder / "data", folder / "log", _free_port()
        _run(
            programs / "initdb",
            *("-D", data, "-U", "tester", "-A", "scram-sha-256", "-E", "UTF8", "--locale=C"),
            *("-N", f"--pwfile={folder / 'password'}"),
        )
        # Nothing of it must outlive a crash of the computer. A log: else pg_ctl's pipe stays open.
        settings = f"-p {port} -c listen_addresses=127.0.0.1 -c fsync=off"
        settings += f" -c unix_socket_directories={folder}"
        _run(programs / "pg_ctl", "-D", data, "-l", log, "-o", settings, "-w", "start")
        try:
            yield f"postgresql://tester:{password}@127.0.0.1:{port}/postgres"
        finally:
            _run(programs / "pg_ctl", "-D", data, "-m", "immediate", "-w", "stop")
    finally:
        shutil.rmtree(folder)


def _stop(number: int, _frame: object) -> NoReturn:
    sys.exit(128 + number)


def main(command: list[str]) -> int:
    """Run a command beside a cluster; returns its exit status."""
    signal.signal(signal.SIGTERM, _stop)
    programs = find_programs()
    if programs is None:
        sys.stderr.write("PostgreSQL is not installed; for example: apt-get install postgresql\n")
        return 2
    with running(programs) as url:
        return subprocess.run(command, env={**os.environ, VARIABLE: url}, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
