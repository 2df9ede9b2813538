"""Guard before all routes: a request is refused with a problem, and the machine is not affected."""

import asyncio
import logging
from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import WebSocketDenialResponse
from starlette.types import Message, Receive, Scope, Send

from opensuction.console.console_process import MOST, Throttle
from opensuction.console.guard.guard import SECURITY, Guard
from opensuction.console.guard.limits import PRESSES, UNHURRIED, USUAL, Rate, Rates
from opensuction.console.guard.problem import MEDIA_TYPE
from tests.console.play import play
from tests.console.served import Served, served

STOP = {"ask": "abort", "key": "abcd-0001"}
REQUESTS = "/api/v1/requests"


@pytest.mark.parametrize("path", ["/", "/api/v1/state", "/api/v1/nothing", "/nothing.js"])
def test_every_answer_says_what_a_browser_may_do_with_it(console: Served, path: str) -> None:
    answer = console.client().get(path)
    for name, value in SECURITY.items():
        assert answer.headers[name] == value, name
    is_interface = path.startswith("/api/")
    assert answer.headers["cache-control"] == ("no-store" if is_interface else "no-cache")
    assert "unsafe" not in answer.headers["content-security-policy"]


@pytest.mark.parametrize(
    ("changed", "status"),
    [
        ({"Host": "evil.example"}, 421),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Sec-Fetch-Site": "cross-site"}, 403),
    ],
)
def test_nobody_is_asked_from_elsewhere_not_even_to_stop(
    console: Served, changed: dict[str, str], status: int
) -> None:
    with console.client("clinician") as client:
        answer = client.post(REQUESTS, json=STOP, headers=changed)
    assert answer.status_code == status
    assert answer.headers["content-type"] == MEDIA_TYPE
    assert console.machine.pressed == []


def test_a_page_of_another_origin_reads_nothing(console: Served) -> None:
    answer = console.client("clinician").get(
        "/api/v1/session", headers={"Sec-Fetch-Site": "cross-site"}
    )
    assert answer.status_code == 403
    assert "anna" not in answer.text


@pytest.mark.parametrize("origin", ["http://evil.example", "null", ""])
def test_a_socket_from_elsewhere_is_refused(console: Served, origin: str) -> None:
    with console.client("clinician") as client:
        client.headers["Origin"] = origin
        with pytest.raises(WebSocketDenialResponse) as refused, console.listen(client, "/live"):
            pass
    assert refused.value.status_code == 403


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"{" + b" " * 70_000 + b"}", 413),
        (b"not json", 422),
        (b'{"ask": "abort"', 422),
        (b"[" * 30_000, 400),
        (b'{"ask": "reset", "key": "abcd-0001", "more": 1}', 422),
        (b'{"ask": "reset", "key": "\\ud800abcd-0001"}', 422),
        (b'{"ask": "reset", "key": "abcd 0001"}', 422),
        (b'{"ask": "jump", "key": "abcd-0001"}', 422),
        (b'{"ask": ["abort"], "key": 1}', 422),
        (b"\xff\xfe\x00", 400),
        (b"", 422),
    ],
)
def test_what_cannot_be_read_is_refused_and_the_machine_never_notices(
    console: Served, body: bytes, status: int
) -> None:
    with console.client() as client:
        answer = client.post(REQUESTS, content=body, headers={"Content-Type": "application/json"})
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == MEDIA_TYPE
    assert len(answer.content) < 4000
    assert console.machine.pressed == []


@pytest.mark.parametrize(
    ("method", "path", "body", "key"),
    [
        ("POST", REQUESTS, b'{"ask": "reset", "key": "abcd-0001", "ask": "start"}', "ask"),
        ("POST", REQUESTS, b'{"ask": "abort", "ask": "start", "key": "abcd-0001"}', "ask"),
        ("PUT", "/api/v1/accounts/anna", b'{"reason": "a", "reason": "b"}', "reason"),
        ("DELETE", "/api/v1/accounts/anna", b'{"reason": "a", "re\\u0061son": "b"}', "reason"),
        ("POST", "/api/v1/protocol/draft", b'{"protocol": {"x": 1, "x": 2}}', "x"),
        ("POST", "/api/v1/session", b'{"name": "a", "password": "b", "password": "c"}', "password"),
    ],
)
def test_a_key_that_is_said_twice_is_refused(
    console: Served, method: str, path: str, body: bytes, key: str
) -> None:
    """The last one would have counted, and whoever looked at the first would not have known."""
    with console.client("administrator") as client:
        answer = client.request(
            method, path, content=body, headers={"Content-Type": "application/json"}
        )
    assert (answer.status_code, answer.headers["content-type"]) == (400, MEDIA_TYPE)
    assert answer.json()["detail"] == f"the body says '{key}' more than once"
    assert console.machine.pressed == []


@pytest.mark.parametrize(
    "body", [b'{"ask": "abort", "key": 1, "key": 2}', b'{"ask": "start", "ask": "abort"}']
)
def test_a_stop_is_obeyed_whatever_it_says_twice(console: Served, body: bytes) -> None:
    with console.client() as client:
        answer = client.post(REQUESTS, content=body, headers={"Content-Type": "application/json"})
    assert answer.json()["verdict"] == "pressed"
    assert [ask for ask, _ in console.machine.pressed] == ["abort"]


def test_a_method_that_there_is_not_is_a_problem(console: Served) -> None:
    answer = console.client().put("/api/v1/state", json={})
    assert (answer.status_code, answer.headers["content-type"]) == (405, MEDIA_TYPE)
    assert "GET" in answer.headers["allow"]


@pytest.fixture
def hurried(tmp_path: Path) -> Iterator[Served]:
    few = Rate(0.001, 3.0)
    with served(tmp_path, limits=UNHURRIED._replace(reads=few, buttons=few)) as made:
        yield made


def test_who_asks_too_often_is_told_how_long_to_wait_and_may_still_stop(hurried: Served) -> None:
    with hurried.client("clinician") as client:
        answers = [client.get("/api/v1/state") for _ in range(4)]
        assert [one.status_code for one in answers] == [200, 200, 200, 429]
        assert int(answers[-1].headers["retry-after"]) > 0
        asked = [
            client.post(REQUESTS, json={"ask": "start", "key": f"start-{number:04}"})
            for number in range(4)
        ]
        assert [one.status_code for one in asked] == [200, 200, 200, 429]
        stops = [
            client.post(REQUESTS, json={"ask": "abort", "key": f"abort-{number:04}"})
            for number in range(10)
        ]
    assert {one.status_code for one in stops} == {200}


def test_ten_stops_a_second_are_never_too_many(console: Served) -> None:
    assert USUAL.presses.rate_hz >= 10.0
    with console.client() as client:
        stops = [
            client.post(REQUESTS, json={"ask": "abort", "key": f"abort-{number:04}"})
            for number in range(30)
        ]
    assert {one.status_code for one in stops} == {200}


def test_so_many_pages_may_listen_and_no_more(tmp_path: Path) -> None:
    limits = UNHURRIED._replace(sockets_here=2)
    with served(tmp_path, limits=limits) as console, console.client() as client:
        with console.listen(client, "/live"), console.listen(client, "/live") as second:
            with pytest.raises(WebSocketDenialResponse) as refused, console.listen(client, "/live"):
                pass
            assert refused.value.status_code == 429
            assert second.receive_json()["connected"] is True
        # Those have gone: there is room again.
        with console.listen(client, "/live") as again:
            assert again.receive_json()["connected"] is True


def test_what_fails_within_is_a_problem_that_tells_nothing(
    console: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail() -> None:
        raise RuntimeError("the secret of the house")

    monkeypatch.setattr(console.site.hub, "now", fail)
    answer = console.client().get("/api/v1/state")
    assert answer.status_code == 500
    assert answer.headers["content-type"] == MEDIA_TYPE
    assert answer.headers["content-security-policy"]
    assert "secret" not in answer.text


def test_the_log_tells_who_was_refused_and_nothing_that_is_secret(
    console: Served, caplog: pytest.LogCaptureFixture
) -> None:
    client = console.client("clinician")
    token = console.signed_in["clinician"].session_token
    with caplog.at_level(logging.DEBUG, "opensuction.console"):
        client.post("/api/v1/session", json={"name": "anna", "password": "a wrong password"})
        client.get("/api/v1/accounts?token=hidden-in-the-query")
        client.get("/api/v1/a%0D%0Aforged line")
    said = "\n".join(one.getMessage() for one in caplog.records)
    assert "401 POST /api/v1/session from 127.0.0.1" in said
    assert "403 GET /api/v1/accounts" in said
    for secret in (token, "a wrong password", "hidden-in-the-query"):
        assert secret not in said
    assert "\nforged" not in said


def test_a_flood_leaves_few_lines_and_says_how_many_it_left_out() -> None:
    throttle = Throttle()
    lines = [logging.LogRecord("x", 30, "", 0, "refused %s", (one,), None) for one in range(5000)]
    kept = [one for one in lines if throttle.filter(one)]
    assert MOST <= len(kept) < 2 * MOST
    throttle._buckets._kept.clear()
    last = logging.LogRecord("x", 30, "", 0, "refused", (), None)
    assert throttle.filter(last)
    assert f"({5000 - len(kept)} lines before it left out)" in last.getMessage()


OLD_S = USUAL.new_s
"""Age of a connection that a page has kept."""


def press_scope(port: int) -> Scope:
    host = [(b"host", b"127.0.0.1:8080"), (b"content-length", b"2")]
    return {
        "type": "http",
        "method": "POST",
        "scheme": "http",
        "path": PRESSES,
        "headers": host,
        "client": ("127.0.0.1", port),
    }


async def receive() -> Message:
    return {"type": "http.request", "body": b"{}", "more_body": False}


async def send(_message: Message) -> None:
    """Nobody looks."""


def _cookie(_host: str | None) -> str:
    return "session"


def test_a_first_press_waits_for_nobody_who_presses_often() -> None:
    """Four of the flood are answered at a time, the others wait."""
    came: list[int] = []

    async def machine(scope: Scope, _receive: Receive, _send: Send) -> None:
        came.append(scope["client"][1])
        await asyncio.Event().wait()

    async def test() -> None:
        rates = Rates(USUAL)
        guard = Guard(machine, USUAL._replace(more_s=0.0), rates, None, _cookie)
        flooding = range(1, 41)
        for port in list(flooding) * int(USUAL.first_presses.most):
            assert rates.is_a_first_press("127.0.0.1", port, OLD_S)
        others = (50, 51, 52)
        waiting = [
            asyncio.ensure_future(guard(press_scope(port), receive, send))
            for port in (*flooding, *others)
        ]
        for _ in range(10):
            await asyncio.sleep(0.0)
        assert came == [*others, 1, 2, 3, 4]
        for one in waiting:
            one.cancel()

    play(test(), 60.0)


def test_connections_that_one_address_makes_anew_press_often_together() -> None:
    rates = Rates(USUAL)
    most = int(USUAL.new_presses.most)
    presses = [rates.is_a_first_press("192.0.2.1", port, 0.0) for port in range(most + 5)]
    assert presses == [True] * most + [False] * 5
    assert rates.is_a_first_press("192.0.2.1", 999, OLD_S)
    assert rates.is_a_first_press("192.0.2.2", 1, 0.0)


def test_who_asked_too_often_is_told_so_later_and_keeps_nobody_up() -> None:
    """A refusal at once would be followed by the next request at once."""

    async def machine(_scope: Scope, _receive: Receive, _send: Send) -> None:
        """Reads nothing and answers nothing."""

    async def test() -> None:
        few = USUAL._replace(presses=Rate(0.001, 1.0), refused_s=3600.0)
        guard = Guard(machine, few, Rates(few), None, _cookie)
        await guard(press_scope(1), receive, send)
        often = asyncio.ensure_future(guard(press_scope(1), receive, send))
        await guard(press_scope(2), receive, send)
        assert not often.done()
        often.cancel()

    play(test(), 60.0)
