"""What a console is made of: whose machine, which records, who may ask, where it listens."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from opensuction.accounts.accounts import Accounts
from opensuction.console.live.hub import Hub
from opensuction.records.records import Records
from opensuction.runtime.about import About


class Origin(NamedTuple):
    """Where the console listens."""

    host: str
    port: int
    has_tls: bool = False


class Site(NamedTuple):
    """All that the routes go by."""

    folder: Path
    """The machine's (`runtime.room`)."""
    records: Records
    accounts: Accounts
    hub: Hub
    recordings: Path
    about: Callable[[], About]
    """Whose machine it is, as of now. Raises InputError."""
    origin: Origin


def session_cookie(folder: Path) -> str:
    """Name of the cookie that holds a session. folder: the machine's.

    A browser sends a computer's cookies to each of its ports: machines beside each other, also of
    several users, have their own.
    """
    return f"opensuction_session_{os.geteuid()}_{folder.name}"


def device_cookie(folder: Path) -> str:
    """Name of the cookie by which a browser is known where somebody has signed in before."""
    return f"opensuction_device_{os.geteuid()}_{folder.name}"
