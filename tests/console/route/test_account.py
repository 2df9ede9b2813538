"""Accounts and tokens at the page: by administrators only, each with its answer."""

import pytest

from opensuction.accounts.rule import right
from tests.console.served import PEOPLE, Served

ACCOUNTS, TOKENS = "/api/v1/accounts", "/api/v1/tokens"
DORA = {"name": "dora", "role": "clinician"}
BOARD = {"label": "ward board", "scope": ["see-bedside", "see-history"], "lasts_s": 3600}
CHANGES = [
    ("GET", ACCOUNTS, None),
    ("POST", ACCOUNTS, DORA),
    ("PUT", f"{ACCOUNTS}/anna", {"role": "engineer", "is_administrator": True, "reason": "x"}),
    ("POST", f"{ACCOUNTS}/anna/password", None),
    ("DELETE", f"{ACCOUNTS}/anna", {"reason": "x"}),
    ("GET", TOKENS, None),
    ("POST", TOKENS, BOARD),
    ("DELETE", f"{TOKENS}/x", None),
]


@pytest.mark.parametrize(("method", "path", "body"), CHANGES)
def test_only_an_administrator_manages_accounts_and_tokens(
    console: Served, method: str, path: str, body: dict[str, object] | None
) -> None:
    before = console.site.accounts.list_accounts()
    for role in (None, "observer", "clinician", "engineer"):
        answer = console.client(role).request(method, path, json=body)
        assert answer.status_code == (401 if role is None else 403), role
    assert console.site.accounts.list_accounts() == before


@pytest.mark.parametrize(("method", "path", "body"), [one for one in CHANGES if one[0] != "GET"])
def test_not_even_an_administrator_by_a_page_of_another_origin(
    console: Served, method: str, path: str, body: dict[str, object] | None
) -> None:
    before = console.site.accounts.list_accounts()
    client = console.client("administrator")
    for headers in ({"X-CSRF-Token": "guess"}, {"Origin": "http://evil.example"}):
        assert client.request(method, path, json=body, headers=headers).status_code == 403
    assert console.site.accounts.list_accounts() == before


def test_an_account_from_its_making_to_its_end(console: Served) -> None:
    client = console.client("administrator")
    made = client.post(ACCOUNTS, json=DORA)
    assert made.status_code == 201
    assert made.json()["account"] == "dora"
    assert len(made.json()["one_time_password"]) > 20
    listed = {one["name"]: one for one in client.get(ACCOUNTS).json()}
    assert set(listed) == {*PEOPLE.values(), "dora"}
    assert listed["dora"]["has_one_time_password"] is True
    assert "password_hash" not in listed["dora"]
    changed = {"role": "engineer", "is_administrator": False, "reason": "another ward"}
    assert client.put(f"{ACCOUNTS}/dora", json=changed).json()["role"] == "engineer"
    again = client.post(f"{ACCOUNTS}/dora/password").json()
    assert again["one_time_password"] != made.json()["one_time_password"]
    ended = client.request("DELETE", f"{ACCOUNTS}/dora", json={"reason": "has left"})
    assert ended.status_code == 204
    listed = {one["name"]: one for one in client.get(ACCOUNTS).json()}
    assert listed["dora"]["is_active"] is False


@pytest.mark.parametrize(
    ("body", "field"),
    [
        (DORA | {"name": "Dora the Great"}, "name"),
        (DORA | {"name": "anna"}, "name"),
        (DORA | {"name": "admin' --"}, "name"),
        (DORA | {"role": "chief"}, "role"),
        (DORA | {"more": 1}, "more"),
        ({"role": "observer"}, "name"),
    ],
)
def test_what_cannot_be_is_said_beside_its_field(
    console: Served, body: dict[str, object], field: str
) -> None:
    answer = console.client("administrator").post(ACCOUNTS, json=body)
    assert answer.status_code == 422
    assert [one["field"] for one in answer.json()["errors"]] == [field]


def test_the_last_administrator_stays(console: Served) -> None:
    client = console.client("administrator")
    ended = client.request("DELETE", f"{ACCOUNTS}/admin", json={"reason": "tired"})
    assert ended.status_code == 422
    assert "the last administrator" in ended.json()["detail"]


def test_an_account_that_is_not_there(console: Served) -> None:
    client = console.client("administrator")
    assert client.post(f"{ACCOUNTS}/nobody-here/password").status_code == 404
    body = {"role": "observer", "is_administrator": False, "reason": "x"}
    assert client.put(f"{ACCOUNTS}/nobody-here", json=body).status_code == 404


def test_a_role_that_is_taken_is_felt_with_the_next_request(console: Served) -> None:
    body = {"role": "observer", "is_administrator": False, "reason": "back to school"}
    with console.client("clinician") as nurse:
        start = {"ask": "start", "key": "start-0001"}
        assert nurse.post("/api/v1/requests", json=start).status_code == 200
        assert console.client("administrator").put(f"{ACCOUNTS}/anna", json=body).status_code == 200
        start = {"ask": "start", "key": "start-0002"}
        assert nurse.post("/api/v1/requests", json=start).status_code == 403


def test_a_token_reads_what_it_was_given_for_until_it_is_revoked(console: Served) -> None:
    client = console.client("administrator")
    made = client.post(TOKENS, json=BOARD)
    assert made.status_code == 201
    token = made.json()
    (listed,) = client.get(TOKENS).json()
    assert listed == {key: value for key, value in token.items() if key != "token"}
    board = console.client()
    headers = {"Authorization": f"Bearer {token['token']}"}
    assert board.get("/api/v1/state", headers=headers).status_code == 200
    assert board.get(ACCOUNTS, headers=headers).status_code == 403
    assert board.post(ACCOUNTS, json=DORA, headers=headers).status_code == 403
    assert client.delete(f"{TOKENS}/{token['id']}").status_code == 204
    assert board.get(ACCOUNTS, headers=headers).status_code == 401
    assert client.delete(f"{TOKENS}/{token['id']}").status_code == 404


@pytest.mark.parametrize(
    "wrong", [{"scope": ["start"]}, {"scope": []}, {"lasts_s": 0}, {"lasts_s": 10**9}]
)
def test_a_token_that_cannot_be(console: Served, wrong: dict[str, object]) -> None:
    answer = console.client("administrator").post(TOKENS, json=BOARD | wrong)
    assert answer.status_code == 422
    assert console.site.accounts.list_tokens() == []


def test_the_table_of_rights_is_the_one_that_is_obeyed(console: Served) -> None:
    assert console.client().get("/api/v1/rights").json() == right.list_plain()
