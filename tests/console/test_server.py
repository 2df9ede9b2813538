"""The console on a real port: who is slow, says nonsense or too much, and who hangs."""

import asyncio
import json
import socket
import ssl
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import cast

import httpx
import pytest
from fastapi import FastAPI
from starlette.types import Receive, Scope, Send
from websockets.client import ClientProtocol
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.frames import Frame
from websockets.protocol import State
from websockets.sync.client import connect
from websockets.uri import parse_uri

from opensuction.console import console_process
from opensuction.console.app import create_app
from opensuction.console.console_process import HEADERS_BYTES, HastyProtocol
from opensuction.console.guard.limits import UNHURRIED
from opensuction.session.running.console_settings import make_context
from tests.console.listening import listening, listening_app
from tests.console.served import HOST, Served, free_port, served
from tests.console.written_machine import WrittenMachine
from tests.runtime.machine_room import wait
from tests.session.running.test_console_settings import make_pair

pytestmark = pytest.mark.real_time

SLOW_S = 0.3
"""In the tests; people have ten seconds."""


@pytest.fixture
def console(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    monkeypatch.setattr(HastyProtocol, "headers_s", SLOW_S)
    with listening(tmp_path, UNHURRIED._replace(body_s=SLOW_S)) as made:
        yield made


@pytest.fixture
def line(console: Served) -> Iterator[socket.socket]:
    """A connection on which a test says what it likes."""
    with socket.create_connection((HOST, console.site.origin.port), timeout=10.0) as made:
        yield made


def hear(line: socket.socket) -> bytes:
    """All that comes until the other end hangs up."""
    heard = b""
    try:
        while piece := line.recv(65536):
            heard += piece
    except ConnectionResetError:
        pass
    return heard


def is_open(port: int) -> bool:
    """Tell whether somebody listens at it."""
    try:
        socket.create_connection((HOST, port), timeout=1.0).close()
    except OSError:
        return False
    return True


def trickle(line: socket.socket) -> None:
    while True:
        line.sendall(b"a")
        time.sleep(SLOW_S / 10.0)


def live_url(console: Served) -> str:
    return f"{console.url}/api/v1/live".replace("http", "ws", 1)


def stops(console: Served) -> None:
    """Whatever goes on, a person can stop the machine."""
    body = {"ask": "abort", "key": f"stop-{time.monotonic_ns()}"}
    headers = {"Origin": console.url}
    answer = httpx.post(f"{console.url}/api/v1/requests", json=body, headers=headers)
    assert answer.json()["verdict"] == "pressed"


SAID = {
    "nothing": "",
    "half a request": "GET /api/v1/state HTTP/1.1\r\n",
    "a whole one": "GET /api/v1/state HTTP/1.1\r\nHost: {host}\r\n\r\n",
    "no body": "POST /api/v1/requests HTTP/1.1\r\nHost: {host}\r\nContent-Length: 99\r\n\r\n",
}


@pytest.mark.parametrize("said", SAID)
def test_however_many_connections_somebody_holds_a_new_one_stops(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: str
) -> None:
    monkeypatch.setattr(console_process, "CONNECTIONS_HERE", 20)
    with listening(tmp_path, UNHURRIED) as console, ExitStack() as stack:
        port = console.site.origin.port
        page = stack.enter_context(httpx.Client(base_url=console.url))
        assert page.get("/api/v1/state").status_code == 200
        held = []
        for _ in range(60):
            made = socket.create_connection((HOST, port), timeout=10.0)
            held.append(stack.enter_context(made))
            made.sendall(SAID[said].format(host=f"{HOST}:{port}").encode())
        stops(console)
        assert page.get("/api/v1/state").status_code == 200


def test_a_new_connection_is_heard_though_all_others_are_being_answered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As in a burst of whole requests on a busy computer.

    A page that was there long before, and has just asked, is not the one that makes room.
    """
    monkeypatch.setattr(console_process, "CONNECTIONS_HERE", 20)
    asked: list[str] = []

    async def app(scope: Scope, _: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return
        asked.append(scope["path"])
        if scope["path"] == "/slow":
            await asyncio.Event().wait()
        if scope["path"] == "/page":
            await asyncio.sleep(SLOW_S)
        await send({"type": "http.response.start", "status": 204, "headers": []})
        await send({"type": "http.response.body", "body": b""})

    port = free_port()
    with listening_app(cast(FastAPI, app), port), ExitStack() as stack:
        page = stack.enter_context(socket.create_connection((HOST, port), timeout=10.0))
        for number in range(1, 41):
            made = stack.enter_context(socket.create_connection((HOST, port), timeout=10.0))
            made.sendall(f"GET /slow HTTP/1.1\r\nHost: {HOST}:{port}\r\n\r\n".encode())
            assert wait(lambda number=number: asked.count("/slow") == number)  # type: ignore[misc]
            if number == 19:  # before there is one too many
                page.sendall(f"GET /first HTTP/1.1\r\nHost: {HOST}:{port}\r\n\r\n".encode())
                assert page.recv(4096).startswith(b"HTTP/1.1 204")
                page.sendall(f"GET /page HTTP/1.1\r\nHost: {HOST}:{port}\r\n\r\n".encode())
                assert wait(lambda: "/page" in asked)
                assert httpx.get(f"http://{HOST}:{port}/stop").status_code == 204
                assert page.recv(4096).startswith(b"HTTP/1.1 204")
        assert httpx.get(f"http://{HOST}:{port}/stop").status_code == 204


@pytest.mark.parametrize("said", [b"", b"GET / HTTP/1.1\r\n", b"GET / HTTP/1.1\r\nHost: x"])
def test_who_does_not_end_a_request_is_sent_away(line: socket.socket, said: bytes) -> None:
    line.sendall(said)
    assert hear(line) == b""


def test_who_sends_a_letter_now_and_then_is_sent_away_all_the_same(line: socket.socket) -> None:
    line.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: ")
    with pytest.raises((ConnectionResetError, BrokenPipeError)):
        trickle(line)


def test_a_body_that_does_not_come_is_not_waited_for(console: Served, line: socket.socket) -> None:
    line.sendall(
        f"POST /api/v1/requests HTTP/1.1\r\nHost: {HOST}:{console.site.origin.port}\r\n"
        f"Origin: {console.url}\r\nContent-Length: 100\r\n\r\n{{".encode()
    )
    heard = hear(line)
    assert heard.startswith(b"HTTP/1.1 408 ")
    assert b"application/problem+json" in heard
    stops(console)


def test_a_body_in_pieces_without_an_end_is_cut_off(console: Served, line: socket.socket) -> None:
    line.sendall(
        f"POST /api/v1/requests HTTP/1.1\r\nHost: {HOST}:{console.site.origin.port}\r\n"
        f"Origin: {console.url}\r\nTransfer-Encoding: chunked\r\n\r\n".encode()
    )
    try:
        for _ in range(200):
            line.sendall(b"1000\r\n" + b" " * 4096 + b"\r\n")
    except OSError:
        pass  # it has hung up
    heard = hear(line)
    assert heard == b"" or heard.startswith(b"HTTP/1.1 413 ")
    stops(console)


@pytest.mark.parametrize(
    "said",
    [
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",  # a browser that believes in TLS
        b"GET /\r\n\r\n\r\n",
        b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: x\r\nX: " + b"a" * 2 * HEADERS_BYTES,
    ],
)
def test_what_is_no_request_is_refused_as_a_problem(
    console: Served, line: socket.socket, said: bytes
) -> None:
    line.sendall(said)
    heard = hear(line)
    assert heard.startswith(b"HTTP/1.1 400 ")
    assert b"application/problem+json" in heard
    stops(console)


def test_all_pages_are_told_the_same_states(console: Served) -> None:
    """Worked out once: not each page's own row, a tick apart."""
    headers = {"Origin": console.url}
    with (
        connect(live_url(console), additional_headers=headers) as first,
        connect(live_url(console), additional_headers=headers) as second,
    ):
        others = {second.recv(timeout=5.0) for _ in range(12)}
        # It has heard some before, while the other one was connecting.
        same = {first.recv(timeout=5.0) for _ in range(24)} & others
    assert len(same) >= 10


@pytest.mark.parametrize("said", ["hello", b"\x00\x01", "x" * 100_000])
def test_a_page_that_says_something_is_sent_away(console: Served, said: str | bytes) -> None:
    with connect(live_url(console), additional_headers={"Origin": console.url}) as page:
        page.recv()
        page.send(said)
        with pytest.raises(ConnectionClosed) as ended:  # noqa: PT012 - what was on its way comes first
            for _ in range(200):
                page.recv(timeout=5.0)
    assert ended.value.rcvd is not None
    assert ended.value.rcvd.code in (1008, 1009)
    stops(console)


def test_a_socket_from_elsewhere_is_refused_with_a_problem(console: Served) -> None:
    with pytest.raises(InvalidStatus) as refused:
        connect(live_url(console), additional_headers={"Origin": "http://evil.example"})
    assert refused.value.response.status_code == 403
    assert refused.value.response.headers["content-type"] == "application/problem+json"


@pytest.mark.sweep
def test_a_page_that_hangs_costs_the_others_nothing(console: Served) -> None:
    """It reads no more: its socket fills, and it alone waits."""
    headers = {"Origin": console.url}
    hangs = connect(
        live_url(console),
        additional_headers=headers,
        max_queue=1,
        close_timeout=0.1,  # nobody waits for its last words
    )
    with hangs as hanging:
        with connect(live_url(console), additional_headers=headers) as page:
            first = page.recv()
            for _ in range(30):
                page.recv(timeout=5.0)
            assert page.recv() != first
        assert hanging.recv()


def test_the_page_hears_of_another_controller_by_the_same_socket(console: Served) -> None:
    with connect(live_url(console), additional_headers={"Origin": console.url}) as page:
        assert json.loads(page.recv())["connected"] is True
        console.machine.stop()
        assert wait(lambda: json.loads(page.recv())["connected"] is False, 10.0)
        with WrittenMachine(console.site.folder, "records.db", "another-run"):
            assert wait(lambda: json.loads(page.recv())["connected"] is True, 10.0)


def test_with_a_certificate_it_speaks_https_and_nothing_else(tmp_path: Path) -> None:
    pair = make_pair(tmp_path)
    context = make_context(*pair)
    with served(tmp_path, free_port()) as console:
        port = console.site.origin.port
        site = console.site._replace(origin=console.site.origin._replace(has_tls=True))
        trusting = ssl.create_default_context(cafile=pair[0])
        trusting.check_hostname = False  # it is made out to a ward, not to this computer
        with listening_app(create_app(site), port, context):
            answer = httpx.get(f"https://{HOST}:{port}/api/v1/session", verify=trusting)
            assert answer.json()["name"] is None
            assert answer.headers["strict-transport-security"]
            with pytest.raises(httpx.TransportError):
                httpx.get(f"http://{HOST}:{port}/api/v1/session")
            with ExitStack() as stack:
                page, protocol = open_page(stack, port, trusting)
                frames = [one for one in protocol.events_received() if isinstance(one, Frame)]
                while not frames:
                    protocol.receive_data(received(page))
                    frames = [one for one in protocol.events_received() if isinstance(one, Frame)]
                assert json.loads(bytes(frames[0].data))["connected"] is True


def received(page: ssl.SSLSocket) -> bytes:
    """What came, once there is something."""
    found = page.recv(65536)
    assert found, "the console hung up"
    return found


def open_page(
    stack: ExitStack, port: int, trusting: ssl.SSLContext
) -> tuple[ssl.SSLSocket, ClientProtocol]:
    """A page that is shown the machine by TLS.

    In one thread: the usual client reads in a thread of its own, and Python 3.11 does not bear that
    one reads and another writes by the same TLS connection ("[SSL] internal error").
    """
    bare = stack.enter_context(socket.create_connection((HOST, port), timeout=10.0))
    page = stack.enter_context(trusting.wrap_socket(bare))
    protocol = ClientProtocol(parse_uri(f"wss://{HOST}:{port}/api/v1/live"))
    request = protocol.connect()
    request.headers["Origin"] = f"https://{HOST}:{port}"
    protocol.send_request(request)
    page.sendall(b"".join(protocol.data_to_send()))
    while protocol.state is not State.OPEN:
        protocol.receive_data(received(page))
    return page, protocol


def test_the_console_ends_in_order_while_a_page_is_hanging_up(tmp_path: Path) -> None:
    pair = make_pair(tmp_path)
    trusting = ssl.create_default_context(cafile=pair[0])
    trusting.check_hostname = False
    with served(tmp_path, free_port()) as console, ExitStack() as stack:
        port = console.site.origin.port
        site = console.site._replace(origin=console.site.origin._replace(has_tls=True))
        with listening_app(create_app(site), port, make_context(*pair)) as server:
            page, protocol = open_page(stack, port, trusting)
            protocol.send_close()
            page.sendall(b"".join(protocol.data_to_send()))
            while protocol.close_rcvd is None:
                protocol.receive_data(page.recv(65536))
            server.should_exit = True
            assert wait(lambda: not is_open(port))
            page.close()
