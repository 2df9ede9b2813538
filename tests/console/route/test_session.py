"""Signing in at the page: cookies, what is said to whom, and what ends with it."""

from collections.abc import Callable
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.rule import right
from opensuction.console.access import device_cookie, session_cookie
from opensuction.console.app import create_app
from opensuction.records.database import utc_time
from tests.accounts.example import CHEAP, PASSWORDS, Clock
from tests.console.served import Served

SESSION = "/api/v1/session"
ANNA = {"name": "anna", "password": PASSWORDS["anna"]}


def set_cookies(answer: object) -> dict[str, str]:
    headers = answer.headers.get_list("set-cookie")  # type: ignore[attr-defined]
    return {one.partition("=")[0]: one for one in headers}


def test_nobody_may_look_and_stop(console: Served) -> None:
    told = console.client().get(SESSION).json()
    assert told["name"] is told["csrf"] is None
    assert told["rights"] == sorted(right.ANYBODY)


def test_signing_in_gives_cookies_that_no_script_and_no_other_page_gets(console: Served) -> None:
    client = console.client()
    answer = client.post(SESSION, json=ANNA)
    assert answer.status_code == 200
    told = answer.json()
    assert (told["name"], told["role"], told["must_change_password"]) == (
        "anna",
        "clinician",
        False,
    )
    assert "start" in told["rights"]
    cookies = set_cookies(answer)
    assert set(cookies) == {console.session_cookie, console.device_cookie}
    for one in cookies.values():
        assert "HttpOnly" in one
        assert "SameSite=strict" in one
        assert "Path=/" in one
        assert "Secure" not in one  # no certificate here
    session = cookies[console.session_cookie].split(";")[0].partition("=")[2]
    assert session not in answer.text
    assert client.get(SESSION).json()["name"] == "anna"


@pytest.mark.parametrize("cookie", [session_cookie, device_cookie])
@pytest.mark.parametrize(
    ("one", "other"),
    [
        (("bed-1", "localhost:8700"), ("bed-2", "localhost:8701")),
        (("bed-1", "localhost:8700"), ("bed-1", "localhost:8701")),  # forwarded from two computers
        (("bed-1", "[::1]:8700"), ("bed-1", "[::1]:8701")),
        (("bed-1", "ward.example"), ("bed-1", "ward.example:8443")),  # of 443
        (("bed-1", "ward.example"), ("bed-2", "ward.example")),  # behind one proxy
    ],
)
def test_machines_that_a_browser_reaches_by_one_name_have_cookies_of_their_own(
    cookie: Callable[[Path, str | None], str], one: tuple[str, str], other: tuple[str, str]
) -> None:
    names = [cookie(Path("/dev/shm/opensuction-1000") / name, host) for name, host in (one, other)]
    assert names[0] != names[1]
    assert all(name.replace("-", "").replace("_", "").isalnum() for name in names)


@pytest.mark.parametrize("host", [None, "", "[::1]", "host:", "host:99999999", "host:80; Path=x"])
def test_whatever_a_host_says_its_cookie_has_a_name(host: str | None) -> None:
    name = session_cookie(Path("/dev/shm/opensuction-1000/bed-1"), host)
    assert name.endswith("_bed-1")


def test_one_browser_is_signed_in_at_two_forwarded_machines_of_one_name(console: Served) -> None:
    origin = console.site.origin._replace(host="0.0.0.0", has_tls=True)  # any Host header
    app = create_app(console.site._replace(origin=origin))
    client = TestClient(app, client=("127.0.0.1", 5))
    left, right = "https://localhost:8443", "https://localhost:8444"
    for url, name in ((left, "anna"), (right, "bert")):
        body = {"name": name, "password": PASSWORDS[name]}
        told = client.post(f"{url}{SESSION}", json=body, headers={"Origin": url})
        assert told.json()["name"] == name
    assert client.get(f"{left}{SESSION}").json()["name"] == "anna"
    csrf = client.get(f"{right}{SESSION}").json()["csrf"]
    headers = {"Origin": right, "X-CSRF-Token": csrf}
    assert client.delete(f"{right}{SESSION}", headers=headers).status_code == 204
    assert client.get(f"{right}{SESSION}").json()["name"] is None
    assert client.get(f"{left}{SESSION}").json()["name"] == "anna"


def test_with_a_certificate_cookies_go_nowhere_without_one(console: Served) -> None:
    origin = console.site.origin._replace(has_tls=True)
    app = create_app(console.site._replace(origin=origin))
    url = console.url.replace("http", "https")
    client = TestClient(app, url, headers={"Origin": url}, client=("127.0.0.1", 5))
    answer = client.post(SESSION, json=ANNA)
    assert answer.status_code == 200
    assert all("Secure" in one for one in set_cookies(answer).values())
    assert answer.headers["strict-transport-security"]


@pytest.mark.parametrize(
    "wrong",
    [ANNA | {"password": "wrong wrong wrong"}, ANNA | {"name": "nobody-here"}, ANNA | {"name": ""}],
)
def test_what_was_wrong_is_not_said(console: Served, wrong: dict[str, str]) -> None:
    answer = console.client().post(SESSION, json=wrong)
    assert answer.status_code == 401
    assert answer.json()["detail"] == "name or password is wrong"
    assert set_cookies(answer) == {}


def test_after_several_failures_one_waits_and_may_still_stop(console: Served) -> None:
    with console.client() as client:
        answers = [
            client.post(SESSION, json=ANNA | {"password": f"wrong wrong {number}"})
            for number in range(12)
        ]
        assert answers[-1].status_code == 429
        assert int(answers[-1].headers["retry-after"]) > 0
        stop = client.post("/api/v1/requests", json={"ask": "abort", "key": "abcd-0001"})
        assert stop.json()["verdict"] == "pressed"


def test_signing_out_ends_the_session_everywhere(console: Served) -> None:
    client = console.client("clinician")
    thief = console.client("clinician")
    assert client.delete(SESSION).status_code == 204
    assert thief.get(SESSION).json()["name"] is None
    assert thief.get("/api/v1/accounts").status_code == 401


def test_signing_out_from_elsewhere_is_refused(console: Served) -> None:
    client = console.client("clinician")
    assert client.delete(SESSION, headers={"X-CSRF-Token": "guess"}).status_code == 403
    assert client.get(SESSION).json()["name"] == "anna"


def test_who_signs_in_after_another_leaves_nothing_of_that_session(console: Served) -> None:
    before = console.client("observer")
    client = console.client("observer")
    assert client.post(SESSION, json=ANNA).json()["name"] == "anna"
    assert before.get(SESSION).json()["name"] is None


def test_a_made_up_session_is_nobodys(console: Served) -> None:
    client = console.client()
    client.cookies.set(console.session_cookie, "made-up")
    answer = client.get(SESSION)
    assert answer.json()["name"] is None
    assert set_cookies(answer) == {}  # it may be late, after somebody has signed in
    assert client.get("/api/v1/accounts").status_code == 401


def test_a_page_that_looks_by_itself_keeps_no_session_alive(console: Served) -> None:
    clock = Clock()
    clock.at = utc_time.now()
    accounts = Accounts(console.site.records.database, clock, CHEAP)
    client = TestClient(create_app(console.site._replace(accounts=accounts)), console.url)
    client.headers["Origin"] = console.url
    ends_at = client.post(SESSION, json=ANNA).json()["expires_at"]
    for minutes in (20.0, 9.0):  # by the page alone
        clock.go_on(minutes=minutes)
        told = client.get(SESSION, headers={"X-Unattended": "1"}).json()
        assert (told["name"], told["expires_at"]) == ("anna", ends_at)
    assert client.get("/api/v1/cycles").status_code != 401
    clock.go_on(minutes=29.0)
    assert client.get(SESSION, headers={"X-Unattended": "1"}).json()["name"] == "anna"
    clock.go_on(minutes=2.0)
    assert client.get(SESSION, headers={"X-Unattended": "1"}).json()["name"] is None


def test_a_one_time_password_must_be_changed_first(console: Served) -> None:
    with console.client("administrator") as admin:
        made = admin.post("/api/v1/accounts", json={"name": "dora", "role": "clinician"}).json()
    with console.client() as client:
        body = {"name": "dora", "password": made["one_time_password"]}
        told = client.post(SESSION, json=body).json()
        assert told["must_change_password"] is True
        client.headers["X-CSRF-Token"] = told["csrf"]
        start = client.post("/api/v1/requests", json={"ask": "start", "key": "abcd-0001"})
        assert start.status_code == 403
        passwords = {"present": made["one_time_password"], "wanted": "short"}
        refused = client.put(f"{SESSION}/password", json=passwords)
        assert refused.status_code == 422
        assert refused.json()["errors"][0]["field"] == "wanted"
        wrong = client.put(f"{SESSION}/password", json=passwords | {"present": "not it at all"})
        assert wrong.status_code in (403, 422)
        passwords["wanted"] = "marble otters juggle late"
        assert client.put(f"{SESSION}/password", json=passwords).status_code == 200
        start = client.post("/api/v1/requests", json={"ask": "start", "key": "abcd-0002"})
        assert start.json()["verdict"] == "pressed"


def test_records_that_are_away_are_said_and_nobody_is_let_in(
    console: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    from opensuction.records.database.failure import RecordsError

    def fail(*_: object) -> None:
        raise RecordsError("records.db: the disk is full")

    monkeypatch.setattr(console.site.accounts, "sign_in", fail)
    answer = console.client().post(SESSION, json=ANNA)
    assert answer.status_code == 503
