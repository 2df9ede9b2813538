"""History over the interface: filters, pages, and access by role."""

from datetime import timedelta
from urllib.parse import quote

import pytest

from opensuction.accounts.rule.right import Right
from tests.console.history.past import ATTACK, NOON, fill, join, remember
from tests.console.served import Served

V1 = "/api/v1"
ROLES = ("observer", "clinician", "engineer", "administrator")
READS = ("/cycles", "/alarms", "/trends")


def stamp(**after: float) -> str:
    return quote((NOON + timedelta(**after)).isoformat())


@pytest.mark.parametrize("path", READS)
def test_whoever_has_signed_in_may_look_back(console: Served, path: str) -> None:
    for role in ROLES:
        assert console.client(role).get(V1 + path).status_code == 200, role
    assert console.client().get(V1 + path).status_code == 401


@pytest.mark.parametrize("path", ["/actions", "/audit"])
def test_who_did_what_is_for_engineers_and_administrators(console: Served, path: str) -> None:
    for role in ("engineer", "administrator"):
        assert console.client(role).get(V1 + path).status_code == 200, role
    for role in ("observer", "clinician"):
        answer = console.client(role).get(V1 + path)
        assert answer.status_code == 403, role
        assert answer.headers["content-type"] == "application/problem+json"


def test_a_cycle_says_how_it_ended_and_whether_its_recording_is_here(console: Served) -> None:
    past = remember(console, None)
    client = console.client("observer")
    running, lost, completed = client.get(f"{V1}/cycles").json()["cycles"]
    assert (running["id"], running["outcome"], running["ended_at"]) == (past.running, None, None)
    assert (lost["outcome"], lost["has_recording"]) == ("aborted", False)
    assert lost["detail"] == f"tripped {ATTACK}", "as it was said: the page shows it as text"
    assert completed["requested_by"] == "anna"
    one = client.get(f"{V1}/cycles/{past.completed}").json()
    assert one == completed
    assert "recording" not in one, "no name of a file is told"


def test_cycles_are_narrowed(console: Served) -> None:
    past = remember(console, None)
    client = console.client("observer")

    def found(query: str) -> list[str]:
        return [one["id"] for one in client.get(f"{V1}/cycles?{query}").json()["cycles"]]

    assert found("outcome=completed") == [past.completed]
    assert found(f"from={stamp(hours=1)}&to={stamp(hours=30)}") == [past.lost]
    assert found("text=TRIPPED") == [past.lost]
    assert found("text=p-2") == [past.lost]
    assert found("text=%25") == []
    assert found("outcome=interrupted") == []


def test_pages_join_to_the_whole_whatever_their_length(console: Served) -> None:
    fill(console, 23)
    client = console.client("observer")
    whole = [one["number"] for one in client.get(f"{V1}/cycles?limit=200").json()["cycles"]]
    assert whole == list(range(23, 0, -1))
    for limit in (1, 7, 23, 24):
        seen: list[int] = []
        before = ""
        while True:
            page = client.get(f"{V1}/cycles?limit={limit}{before}").json()
            assert 0 < len(page["cycles"]) <= limit
            seen += [one["number"] for one in page["cycles"]]
            if page["next"] is None:
                break
            before = f"&before={page['next']}"
        assert seen == whole


@pytest.mark.parametrize(
    "query",
    [
        "outcome=died",
        "from=yesterday",
        "from=2026-11-23T12:00:00",
        "to=0001-01-01T00:00:00%2B14:00",
        "to=9999-12-31T23:59:59-14:00",
        "limit=0",
        "limit=201",
        "limit=many",
        "before=0",
        "before=-1",
        "before=99999999999",
        "text=",
        f"text={'x' * 101}",
        "text=a%00b",
    ],
)
def test_a_malformed_filter_is_refused_as_a_problem(console: Served, query: str) -> None:
    answer = console.client("observer").get(f"{V1}/cycles?{query}")
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["status"] == 422


def test_alarms_and_actions_of_a_cycle(console: Served) -> None:
    past = remember(console, None)
    client = console.client("engineer")
    (alarm,) = client.get(f"{V1}/alarms?cycle={past.lost}").json()["alarms"]
    assert (alarm["condition"], alarm["priority"]) == ("LINE_CLOGGED", "high")
    both = client.get(f"{V1}/alarms").json()["alarms"]
    assert [one["priority"] for one in both] == ["low", "high"]
    assert [one["number"] for one in client.get(f"{V1}/alarms?priority=high").json()["alarms"]] == [
        1
    ]
    assert client.get(f"{V1}/alarms?priority=loud").status_code == 422
    (action,) = client.get(f"{V1}/actions?cycle={past.completed}").json()["actions"]
    assert (action["done_by"], action["what"]) == ("anna", "start")


def test_a_cycle_that_is_not_there_or_another_machine_s_is_not_found(console: Served) -> None:
    client = console.client("engineer")
    for name in ("nobody", "00000000-0000-0000-0000-000000000000"):
        for path in ("", "/report", "/recording", "/replay"):
            assert client.get(f"{V1}/cycles/{name}{path}").status_code == 404, path
    for name in ("..%2F..%2Fetc%2Fpasswd", "a%00b", "x" * 65, "a.mcap"):
        assert client.get(f"{V1}/cycles/{name}/recording").status_code in (404, 422)


def test_the_trail_is_read_in_a_thread_and_its_verdict_told(console: Served) -> None:
    remember(console, None)
    client = console.client("engineer")
    before = client.get(f"{V1}/audit").json()
    assert (before["state"], before["verdict"]) == ("none", None)
    assert client.post(f"{V1}/audit", json={"expected": before["head"]}).status_code == 202
    join("_read_trail")
    found = client.get(f"{V1}/audit").json()
    assert found["state"] == "done"
    assert found["verdict"]["is_whole"] is True
    assert found["verdict"]["entries"] == before["entries"]
    assert client.post(f"{V1}/audit", json={"expected": "0f" * 32}).status_code == 202
    join("_read_trail")
    found = client.get(f"{V1}/audit").json()
    assert found["verdict"]["is_whole"] is False
    assert "no entry has the expected hash" in found["verdict"]["broken"]
    assert client.post(f"{V1}/audit", json={"expected": "short"}).status_code == 422
    assert client.post(f"{V1}/audit", json={"other": 1}).status_code == 422
    assert console.client("clinician").post(f"{V1}/audit", json={}).status_code == 403


def test_trends_count_each_day_by_the_clock_of_whoever_asks(console: Served) -> None:
    remember(console, None)
    client = console.client("observer")
    found = client.get(f"{V1}/trends").json()
    assert [day["day"] for day in found["days"]] == ["2026-11-23", "2026-11-24", "2026-11-25"]
    assert found["days"][1]["outcomes"] == {
        "completed": 0,
        "aborted": 1,
        "interrupted": 0,
        "running": 0,
    }
    assert found["days"][0]["quantities"]["removed_ml"] is None, "nothing is invented"
    assert (found["cycles"], found["without_recording"], found["pending"]) == (3, 3, 0)
    ahead = client.get(f"{V1}/trends?ahead_min=840").json()
    assert ahead["days"][0]["day"] == "2026-11-24"
    assert client.get(f"{V1}/trends?ahead_min=841").status_code == 422


def test_another_program_reads_by_its_token_and_changes_nothing(console: Served) -> None:
    past = remember(console, None)
    accounts = console.site.accounts
    admin = accounts.find_session(console.signed_in["administrator"].session_token)
    made = accounts.issue_token(admin, "ward", (Right.SEE_HISTORY,), timedelta(days=1))
    client = console.client()
    client.headers["Authorization"] = f"Bearer {made.token}"
    assert len(client.get(f"{V1}/cycles").json()["cycles"]) == 3
    assert client.get(f"{V1}/actions").status_code == 403
    assert client.post(f"{V1}/cycles/{past.completed}/replay").status_code == 403
