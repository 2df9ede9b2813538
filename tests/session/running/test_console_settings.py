"""Addresses and certificates of a console, and refusals before anything is started."""

import socket
import subprocess
from pathlib import Path

import pytest

from opensuction.kernel.errors import InputError
from opensuction.session.running import console_settings
from opensuction.session.running.console_settings import ConsoleSettings

SETTINGS = ConsoleSettings("127.0.0.1", 8080, None, "/kept")


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A certificate and its key."""
    return make_pair(tmp_path_factory.mktemp("pair"))


def make_pair(folder: Path, *protected: str) -> tuple[Path, Path]:
    certificate, key = folder / "cert.pem", folder / "key.pem"
    subprocess.run(
        (
            *("openssl", "req", "-x509", "-newkey", "rsa:2048", "-days", "2", "-subj", "/CN=ward"),
            *("-keyout", str(key), "-out", str(certificate), *(protected or ("-nodes",))),
        ),
        check=True,
        capture_output=True,
    )
    return certificate, key


def test_what_was_written_is_read(tmp_path: Path) -> None:
    console_settings.write(tmp_path, SETTINGS)
    assert console_settings.read(tmp_path) == SETTINGS


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"host": 1}', '{"host": "x", "more": 1}'])
def test_a_file_that_is_not_whole_is_refused_in_one_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "console.json").write_text(text)
    with pytest.raises(InputError, match="sets up no console"):
        console_settings.read(tmp_path)


@pytest.mark.parametrize("host", ["127.0.0.1", "::1", "localhost", "127.8.0.1"])
def test_this_computer_needs_no_certificate(host: str) -> None:
    console_settings.check(host, 8080, None, None)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "10.0.0.7", "ward-3", "", "127.0.0.1.evil"])
def test_any_other_address_needs_one(host: str, pair: tuple[Path, Path]) -> None:
    with pytest.raises(InputError, match="needs --certificate and --key"):
        console_settings.check(host, 8080, None, None)
    console_settings.check(host, 8080, *pair)


@pytest.mark.parametrize("port", [0, -1, 65_536])
def test_a_port_that_is_none(port: int) -> None:
    with pytest.raises(InputError, match=f"--port {port}: a port is 1 to 65535"):
        console_settings.check("127.0.0.1", port, None, None)


def test_a_certificate_and_its_key_go_together(pair: tuple[Path, Path], tmp_path: Path) -> None:
    certificate, key = pair
    with pytest.raises(InputError, match="go together"):
        console_settings.check("127.0.0.1", 8080, certificate, None)
    with pytest.raises(InputError, match="go together"):
        console_settings.check("127.0.0.1", 8080, None, key)
    other = make_pair(tmp_path)[1]
    for wrong in ((certificate, other), (key, certificate), (certificate, certificate)):
        with pytest.raises(InputError, match="no certificate in PEM with its key"):
            console_settings.check("127.0.0.1", 8080, *wrong)
    with pytest.raises(InputError, match=r"--key .*cannot be read"):
        console_settings.check("127.0.0.1", 8080, certificate, tmp_path / "none.pem")


def test_a_key_with_a_password_is_refused_for_nobody_is_there_to_type_it(tmp_path: Path) -> None:
    pair = make_pair(tmp_path, "-passout", "pass:secret")
    with pytest.raises(InputError, match="without a password"):
        console_settings.check("127.0.0.1", 8080, *pair)


def test_a_port_that_is_taken_is_said_in_one_line(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"nothing can listen at 127.0.0.1, port {port}"):
            console_settings.find_place(tmp_path, "127.0.0.1", port)


def test_what_is_sent_on_a_connection_waits_for_no_acknowledgement() -> None:
    with (
        console_settings.listen("127.0.0.1", 0) as listening,
        socket.create_connection(listening.getsockname()),
        listening.accept()[0] as accepted,
    ):
        assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_an_address_that_this_computer_has_not_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing can listen at 192\.0\.2\.1"):
        console_settings.find_place(tmp_path, "192.0.2.1", 8080)


def test_the_address_as_a_person_types_it() -> None:
    assert SETTINGS.url == "http://127.0.0.1:8080/"
    assert SETTINGS._replace(host="::1", certificate="c").url == "https://[::1]:8080/"
    assert socket.gethostname() in SETTINGS._replace(host="0.0.0.0", certificate="c").url


def test_the_first_start_makes_one_administrator(tmp_path: Path) -> None:
    database = str(tmp_path / "records.db")
    first = console_settings.first_password(database)
    again = console_settings.first_password(database)
    assert first is not None
    assert again is not None
    assert (first.account, again.account) == ("admin", "admin")
    assert first.one_time_password != again.one_time_password
