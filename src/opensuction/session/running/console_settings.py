"""Settings of a console: its address, its certificate, the records that it shows.

It can be reached from this computer alone, unless it has a certificate: names, passwords and
treatment data are never sent unencrypted across a network.
"""

import json
import socket
import ssl
from ipaddress import ip_address
from pathlib import Path
from typing import NamedTuple

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.directory import NewPassword
from opensuction.ipc.liveness import end_holder
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.records.records import Records
from opensuction.runtime.machine_folder import CONSOLE, CONSOLE_ENDS_S, CONSOLES

HOST, PORT = "127.0.0.1", 8080
LARGEST_PORT = 65_535
ANY = ("0.0.0.0", "::")


class ConsoleSettings(NamedTuple):
    """As they lie in the machine's folder."""

    host: str
    port: int
    database: str | None
    """See `records.records.Records.open`."""
    recordings: str
    certificate: str | None = None
    key: str | None = None

    @property
    def has_tls(self) -> bool:
        """True if the console uses HTTPS."""
        return self.certificate is not None

    @property
    def url(self) -> str:
        """Address for a browser; if it listens on all of them, the name of this computer."""
        host = socket.gethostname() if self.host in ANY else self.host
        scheme = "https" if self.has_tls else "http"
        return f"{scheme}://{f'[{host}]' if ':' in host else host}:{self.port}/"


def write(folder: Path, settings: ConsoleSettings) -> None:
    """Into the machine's folder, whole or not at all."""
    private_file.write(folder / CONSOLE, json.dumps(settings._asdict()))


def read(folder: Path) -> ConsoleSettings:
    """From the machine's folder. Raises InputError where it is not there or not whole."""
    try:
        return ConsoleSettings(**json.loads((folder / CONSOLE).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise InputError(f"{folder / CONSOLE} sets up no console: {error}") from None


def check(host: str, port: int, certificate: Path | None, key: Path | None) -> None:
    """Refuse what cannot be, before anything is started; raises InputError."""
    if not 1 <= port <= LARGEST_PORT:
        raise InputError(f"--port {port}: a port is 1 to {LARGEST_PORT}")
    if (certificate is None) != (key is None):
        raise InputError("--certificate and --key go together: a certificate needs its key")
    if certificate is None and not _is_loopback(host):
        raise InputError(
            f"--host {host}: to be reached from elsewhere the console needs --certificate and --key"
        )
    if certificate is not None and key is not None:
        make_context(certificate, key)


def find_place(folder: Path, host: str, port: int) -> None:
    """See that the console can listen there; one that an earlier run has left ends.

    Raises InputError where it cannot.
    """
    end_holder(folder / CONSOLES, CONSOLE_ENDS_S, kills=True)
    listen(host, port).close()


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False


def make_context(certificate: Path, key: Path) -> ssl.SSLContext:
    """TLS context for HTTPS. Raises InputError for unusable files, or where they do not match."""
    for option, file in (("--certificate", certificate), ("--key", key)):
        try:
            file.open("rb").close()
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise InputError(f"{option} {file}: cannot be read ({reason})") from None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        # Nobody is there to type a password when the console is started anew.
        context.load_cert_chain(certificate, key, password=lambda: b"")
    except (ssl.SSLError, OSError, ValueError) as error:
        reason = getattr(error, "reason", None) or str(error)
        raise InputError(
            f"--certificate {certificate}, --key {key}: no certificate in PEM with its key "
            f"without a password ({str(reason).lower().replace('_', ' ')})"
        ) from None
    return context


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens there. Raises InputError where it cannot."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        made = socket.create_server((host, port), family=family, backlog=128)
    except (OSError, OverflowError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        raise InputError(f"nothing can listen at {host}, port {port} ({reason})") from None
    # Each connection takes it over. Without it the end of an answer, and each state that is sent
    # on, waits up to 40 ms for the other side to acknowledge what came before; asyncio sets it
    # only for sockets that name their protocol, which these do not.
    made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return made


def first_password(database: str | None) -> NewPassword | None:
    """A one-time password for the administrator of a new site; None: somebody has signed in."""
    with Records.open(database) as records:
        return Accounts(records.database).first_start()
