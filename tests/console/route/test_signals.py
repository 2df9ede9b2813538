"""The stream as a browser meets it: who may look, what is refused and how, what comes."""

import json
from collections.abc import Iterator
from contextlib import AbstractContextManager
from typing import Any

import pytest
from starlette.testclient import TestClient, WebSocketDenialResponse, WebSocketTestSession
from starlette.websockets import WebSocketDisconnect

from opensuction.accounts.accounts import Accounts
from opensuction.console.app import create_app
from opensuction.console.route import signals
from opensuction.console.signals.channel import decode
from opensuction.records.database import utc_time
from opensuction.runtime.loop import ROW_COLUMNS
from tests.accounts.example import CHEAP, PASSWORDS, Clock
from tests.console.served import Served

LIST = "/api/v1/signals/channels"
HEAD = "?channels=inputs.readings.head_mm"


@pytest.fixture
def client(console: Served) -> Iterator[TestClient]:
    with console.client("observer") as made:
        yield made


def listen(
    console: Served, client: TestClient, query: str = HEAD
) -> AbstractContextManager[WebSocketTestSession]:
    return console.listen(client, f"/signals{query}")


def refused(console: Served, client: TestClient, query: str = HEAD) -> dict[str, Any]:
    with pytest.raises(WebSocketDenialResponse) as found, listen(console, client, query):
        pass
    assert found.value.headers["content-type"] == "application/problem+json"
    assert found.value.headers["content-security-policy"]
    assert found.value.headers["cache-control"] == "no-store"
    problem: dict[str, Any] = found.value.json()
    assert problem["status"] == found.value.status_code
    return problem


def last_word(socket: WebSocketTestSession) -> WebSocketDisconnect:
    """How it ends, whatever comes before."""
    while True:
        try:
            socket.receive_bytes()
        except WebSocketDisconnect as gone:
            return gone
        except KeyError:
            continue  # words


def words(socket: WebSocketTestSession, kind: str) -> dict[str, Any]:
    """The next message in words of that kind."""
    while True:
        message = socket.receive()
        if "text" in message:
            told: dict[str, Any] = json.loads(message["text"])
            if told["kind"] == kind:
                return told


def test_every_column_is_listed_with_its_unit(client: TestClient) -> None:
    body = client.get(LIST).json()
    named = {one["name"]: one for one in body["channels"]}
    assert set(ROW_COLUMNS) <= set(named)
    assert named["inputs.readings.line_vacuum_mmhg"]["unit"] == "mmHg"
    assert named["inputs.readings.line_vacuum_mmhg"]["origin"] == "measured"
    assert body["frames_per_s"] >= 30
    assert body["most"] == 16


@pytest.mark.parametrize("role", ["observer", "clinician", "engineer"])
def test_staff_look_at_rows_as_they_come(console: Served, role: str) -> None:
    console.machine.set({"inputs.readings.head_mm": 12.5})
    with console.client(role) as client, listen(console, client) as socket:
        assert json.loads(socket.receive_text())["kind"] == "source"
        frame = decode(socket.receive_bytes())
        assert frame.values[0, -1] == 12.5


def test_nobody_who_has_not_signed_in_looks(console: Served) -> None:
    with console.client() as client:
        assert refused(console, client)["status"] == 401
        assert client.get(LIST).status_code == 401


@pytest.mark.parametrize(
    ("query", "field", "says"),
    [
        ("", "channels", "1 to 16"),
        ("?channels=,", "channels", "twice"),
        ("?channels=inputs.readings.heart_mm", "channels", "no channel 'inputs.readings.heart_mm'"),
        ("?channels=loop.late_s,loop.late_s", "channels", "twice"),
        (f"?channels={','.join(ROW_COLUMNS[:17])}", "channels", "16 channels at most"),
        (f"?channels={'x' * 3000}", "channels", "no channel"),
        ("?channels=loop.late_s&past_s=10", "past_s", "0 to 9"),
        ("?channels=loop.late_s&past_s=nan", "past_s", "0 to 9"),
        ("?channels=loop.late_s&past_s=-1", "past_s", "0 to 9"),
        ("?channels=loop.late_s&past_s=two", "past_s", "0 to 9"),
    ],
)
def test_what_cannot_be_asked_is_refused_with_its_reason(
    console: Served, client: TestClient, query: str, field: str, says: str
) -> None:
    problem = refused(console, client, query)
    assert problem["status"] == 422
    assert problem["errors"][0]["field"] == field
    assert says in problem["detail"]
    assert len(problem["detail"]) < 200


def test_sixteen_channels_may_be_asked_for(console: Served, client: TestClient) -> None:
    query = f"?channels={','.join(ROW_COLUMNS[:16])}"
    with listen(console, client, query) as socket:
        socket.receive_text()
        assert decode(socket.receive_bytes()).values.shape[0] == 16


def test_another_origin_is_refused(console: Served) -> None:
    with console.client("observer") as client:
        client.headers["Origin"] = "http://evil.example"
        assert refused(console, client)["status"] == 403


def test_who_says_something_is_sent_away(console: Served, client: TestClient) -> None:
    with listen(console, client) as socket:
        socket.send_text("more")
        assert last_word(socket).code == signals.VIOLATED


def test_the_stream_ends_with_the_session(
    console: Served, client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(signals, "CHECKS_S", 0.05)
    with listen(console, client) as socket:
        socket.receive_text()
        console.site.accounts.sign_out(console.signed_in["observer"].session_token)
        gone = last_word(socket)
        assert gone.code == signals.VIOLATED
        assert "sign in" in gone.reason


def test_a_stream_that_comes_back_by_itself_keeps_no_session_alive(console: Served) -> None:
    clock = Clock()
    clock.at = utc_time.now()
    accounts = Accounts(console.site.records.database, clock, CHEAP)
    app = create_app(console.site._replace(accounts=accounts))
    with TestClient(app, console.url, headers={"Origin": console.url}) as client:
        anna = {"name": "anna", "password": PASSWORDS["anna"]}
        assert client.post("/api/v1/session", json=anna).status_code == 200
        clock.go_on(minutes=20.0)
        with listen(console, client) as socket:  # a person's
            socket.receive_text()
        for minutes in (15.0, 10.0):
            clock.go_on(minutes=minutes)
            with listen(console, client, f"{HEAD}&unattended=1") as socket:
                socket.receive_text()
        clock.go_on(minutes=10.0)
        assert refused(console, client, f"{HEAD}&unattended=1")["status"] == 401


def test_what_happens_comes_beside_the_rows(console: Served, client: TestClient) -> None:
    with listen(console, client) as socket:
        socket.receive_text()
        console.machine.set({"outputs.phase": 3.0})
        told = words(socket, "event")
        assert (told["what"], told["name"]) == ("phase", "inserting")
        assert told["time_s"] > 0.0


def test_nobody_is_named_in_a_stream(console: Served, client: TestClient) -> None:
    with listen(console, client) as socket:
        socket.receive_text()
        answer = console.client("clinician").post(
            "/api/v1/requests", json={"ask": "acknowledge", "key": "a-key-of-its-own"}
        )
        assert answer.status_code == 200
        told = words(socket, "event")
        assert (told["what"], told["name"], told["detail"]) == ("request", "acknowledge", "pressed")
        assert "anna" not in json.dumps(told)
