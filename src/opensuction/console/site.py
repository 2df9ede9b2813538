"""Parts of a console that its routes use: machine folder, records, accounts, hub, address."""

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from opensuction.accounts.accounts import Accounts
from opensuction.console.live.hub import Hub
from opensuction.records.records import Records
from opensuction.runtime.machine_identity import About

PORT = re.compile(r":(\d{1,5})$", re.ASCII)
"""At the end of a Host header; none where it is the usual one."""


class ListeningAddress(NamedTuple):
    """Address on which the console listens."""

    host: str
    port: int
    has_tls: bool = False


class ConsoleContext(NamedTuple):
    """All that the routes go by."""

    folder: Path
    """The machine's (`runtime.paths`)."""
    records: Records
    accounts: Accounts
    hub: Hub
    recordings: Path
    about: Callable[[], About]
    """Whose machine it is, as of now. Raises InputError."""
    origin: ListeningAddress


def session_cookie(folder: Path, host: str | None) -> str:
    """Name of the cookie that holds a session. folder: the machine's. host: as a request says it.

    A browser sends the cookies of a name to each port of it: machines beside each other, also of
    several users, have their own. So have two of the same name on two computers, whose ports are
    forwarded to one: they differ by the port that the browser asks at.
    """
    return f"opensuction_session_{_place(folder, host)}"


def device_cookie(folder: Path, host: str | None) -> str:
    """Name of the cookie by which a browser is known where somebody has signed in before."""
    return f"opensuction_device_{_place(folder, host)}"


def _place(folder: Path, host: str | None) -> str:
    port = PORT.search(host or "")
    own = f"{os.geteuid()}_{folder.name}"
    return own if port is None else f"{own}_{port[1]}"
