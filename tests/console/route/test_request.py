"""Buttons: who may press which, what is answered, and what the machine has heard."""

import json
import re
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import pytest

from opensuction.accounts.rule.right import RIGHTS, Role
from opensuction.console.guard.limits import UNHURRIED, USUAL
from opensuction.console.route.request import Ask
from opensuction.console.setup import teach
from opensuction.kernel.interface import STOP, Requests
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.runtime.machine_button import (
    BUTTONS,
    PRESSABLE,
    BedsideWords,
    MachineButton,
    PagePart,
)
from tests.accounts.example import ROLES
from tests.console.served import Served, served
from tests.console.written_machine import WrittenMachine

REQUESTS = "/api/v1/requests"
KEY = "0123456789abcdef"
THREADS = 40
"""In which an application of this kind answers what is not asynchronous: the default of AnyIO."""
CHANGED = "changed"
WHO = {role: name for name, role in ROLES.items()}


def test_every_button_of_the_controller_is_there_but_that_of_a_new_catheter() -> None:
    """Which takes the catheter's label, and is ``PUT /catheter``."""
    buttons = {one.replace("-", "_") for one in get_args(Ask)}
    assert buttons | {CHANGED} == set(Requests._fields)


@pytest.mark.parametrize("button", BUTTONS, ids=lambda button: button.name)
def test_every_button_is_pressed_by_the_interface(everybody: Served, button: MachineButton) -> None:
    described = everybody.client().get("/api/v1/openapi.json").json()
    asks = described["components"]["schemas"]["Pressed"]["properties"]["ask"]["enum"]
    assert (button.name in asks) == bool(button.label)
    assert f"/api/v1{button.path}" in described["paths"]
    assert button.label or button.path != "/requests"


@pytest.mark.parametrize("button", BUTTONS, ids=lambda button: button.name)
def test_every_button_of_the_page_is_in_its_part(everybody: Served, button: MachineButton) -> None:
    """Those of the bedside view are drawn by the table, each where it is shown and with words."""
    assert (button.part == PagePart.BEDSIDE) == (button.words is not None)
    if button.part is None:
        return
    script = everybody.client().get(f"/js/{button.part}").text
    asked = f'"{button.name}"' if button.path == "/requests" else f'"{button.path}"'
    assert asked in script
    if button.path == "/teaching":
        assert button.field in teach.BUTTONS.values()


def test_the_bedside_view_shows_what_the_table_has_for_it(everybody: Served) -> None:
    script = everybody.client().get(f"/js/{PagePart.BEDSIDE}").text
    shown = set(re.findall(r'^  "([a-z-]+)": \(state\) =>', script, re.MULTILINE))
    assert shown == {button.name for button in BUTTONS if button.part == PagePart.BEDSIDE}


def test_the_page_takes_rights_and_words_from_the_table(everybody: Served) -> None:
    answer = everybody.client().get("/js/machine_button.js")
    assert answer.headers["content-type"].startswith("text/javascript")
    told = json.loads(answer.text.removeprefix("export const BUTTONS = ").rstrip(";\n"))
    assert list(told) == [button.name for button in BUTTONS]
    for button in BUTTONS:
        assert told[button.name]["right"] == button.right
        words = told[button.name]["words"]
        assert (None if words is None else BedsideWords(**words)) == button.words


def test_a_new_catheter_takes_a_label(console: Served) -> None:
    with console.client("clinician") as client:
        answer = client.post(REQUESTS, json={"ask": CHANGED, "key": KEY})
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["field"] == "ask"
    assert console.machine.pressed == []


def test_anybody_stops_and_the_address_is_on_record(console: Served) -> None:
    with console.client() as client:
        answer = client.post(REQUESTS, json={"ask": "abort", "key": KEY})
    assert answer.status_code == 200
    assert answer.json()["verdict"] == "pressed"
    assert answer.json()["phase"] == "parked"
    assert console.machine.pressed == [("abort", "anybody (127.0.0.1)")]


@pytest.mark.parametrize(
    "said",
    [
        {"key": KEY},
        {},
        {"key": None},
        {"key": 5},
        {"key": "x"},
        {"key": KEY, "reason": "r" * 600},
        {"key": KEY, "reason": 5, "more": [1]},
    ],
    ids=["a key", "no key", "null", "a number", "a short key", "a long reason", "more"],
)
def test_whatever_else_it_says_a_stop_is_sent_each_time(
    console: Served, said: dict[str, object]
) -> None:
    """Twice the same words are two stops: the tip may have gone in between them."""
    with console.client() as client:
        for _ in range(2):
            answer = client.post(REQUESTS, json={"ask": "abort", **said})
            assert answer.status_code == 200, answer.text
            assert answer.json()["verdict"] == "pressed"
    assert [ask for ask, _ in console.machine.pressed] == ["abort"] * 2


def test_a_key_of_somebody_elses_button_keeps_nobody_from_stopping(console: Served) -> None:
    with console.client("clinician") as client:
        assert client.post(REQUESTS, json={"ask": "start", "key": KEY}).status_code == 200
    with console.client() as client:
        assert client.post(REQUESTS, json={"ask": "abort", "key": KEY}).status_code == 200
    assert [ask for ask, _ in console.machine.pressed] == ["start", "abort"]


def test_only_a_page_of_another_origin_may_not_stop(console: Served) -> None:
    with console.client("clinician") as client:
        del client.headers["Origin"]
        assert client.post(REQUESTS, json={"ask": "start", "key": KEY}).status_code == 403
        assert client.post(REQUESTS, json={"ask": "abort"}).status_code == 200
        other = {"Origin": "http://evil.example"}
        assert client.post(REQUESTS, json={"ask": "abort"}, headers=other).status_code == 403
    assert [ask for ask, _ in console.machine.pressed] == ["abort"]


def test_who_floods_one_connection_keeps_nobody_else_from_stopping(tmp_path: Path) -> None:
    most = int(USUAL.presses.most)
    never = USUAL.presses._replace(rate_hz=1e-6)  # as fast as the test is
    with served(tmp_path, limits=UNHURRIED._replace(presses=never)) as console:
        with console.client() as client:
            flood = [client.post(REQUESTS, json={"ask": "abort"}) for _ in range(most + 5)]
            assert [one.status_code for one in flood] == [200] * most + [429] * 5
            assert len(console.machine.pressed) == most
            other = console.client(port=50001)
            assert other.post(REQUESTS, json={"ask": "abort"}).status_code == 200
        assert len(console.machine.pressed) == most + 1


def test_a_stop_asks_no_database_and_still_names_who_was_seen_before(
    console: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    with console.client("observer") as client:
        assert client.get("/api/v1/session").json()["name"] == "cora"

        def fail(*_: object) -> None:
            raise AssertionError("a stop has asked the database")

        for name in ("find_session", "find_session_for_change", "find_token"):
            monkeypatch.setattr(console.site.accounts, name, fail)
        monkeypatch.setattr(type(console.site.records.database), "reading", fail)
        monkeypatch.setattr(type(console.site.records.database), "writing", fail)
        # Neither the right token nor any: what a page cannot prove does not keep it from stopping.
        answer = client.post(
            REQUESTS, json={"ask": "abort", "key": KEY}, headers={"X-CSRF-Token": "wrong"}
        )
        monkeypatch.undo()
    assert answer.status_code == 200
    assert console.machine.pressed == [("abort", "cora")]


@pytest.mark.parametrize("role", ["observer", "clinician", "engineer", "administrator", None])
@pytest.mark.parametrize("ask", sorted(set(PRESSABLE) - {STOP}))
def test_each_role_presses_what_it_may_and_nothing_else(
    everybody: Served, role: str | None, ask: str
) -> None:
    permission = RIGHTS[PRESSABLE[ask].right]
    own = Role.OBSERVER if role == "administrator" else role
    may = own in permission.roles or (role == "administrator" and permission.by_administrator)
    before = len(everybody.machine.pressed)
    body = {"ask": ask, "key": f"{role}-{ask}-1"}
    if permission.needs_reason:
        body["reason"] = "a new conduit"
    with everybody.client(role) as client:
        answer = client.post(REQUESTS, json=body)
    assert answer.status_code == (200 if may else 401 if role is None else 403), answer.text
    pressed = everybody.machine.pressed[before:]
    assert pressed == ([(PRESSABLE[ask].field, WHO[role or ""])] if may else [])


@pytest.fixture(scope="module")
def everybody(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """One console for all of the table."""
    from opensuction.console.guard.limits import UNHURRIED
    from tests.console.served import served

    folder: Path = tmp_path_factory.mktemp("everybody")
    with served(folder, limits=UNHURRIED) as made:
        yield made


def test_a_start_needs_the_page_that_was_signed_in(console: Served) -> None:
    with console.client("clinician") as client:
        for headers in ({"X-CSRF-Token": "wrong"}, {"X-CSRF-Token": ""}):
            answer = client.post(REQUESTS, json={"ask": "start", "key": KEY}, headers=headers)
            assert answer.status_code == 403
        del client.headers["X-CSRF-Token"]
        assert client.post(REQUESTS, json={"ask": "start", "key": KEY}).status_code == 403
    assert console.machine.pressed == []


def test_a_token_of_another_program_presses_nothing_but_stop(console: Served) -> None:
    with console.client("administrator") as client:
        body = {"label": "ward board", "scope": ["see-bedside"], "lasts_s": 3600}
        token = client.post("/api/v1/tokens", json=body).json()["token"]
    with console.client("clinician") as client:
        headers = {"Authorization": f"Bearer {token}"}
        asked = {"ask": "start", "key": KEY}
        assert client.post(REQUESTS, json=asked, headers=headers).status_code == 403
    assert console.machine.pressed == []


@pytest.mark.real_time(others_s=0.02)  # its row is looked for only so long
def test_what_the_core_refuses_is_said_with_what_to_do(console: Served) -> None:
    console.machine.refusal = Refusal.OXYGEN_UNANSWERED
    with console.client("clinician") as client:
        answer = client.post(REQUESTS, json={"ask": "start", "key": KEY}).json()
    assert answer["verdict"] == "pressed"
    assert answer["refusal"] == {
        "name": "oxygen-unanswered",
        "sentence": "pre-oxygenation has not been answered",
        "remedy": "give it and confirm, or skip it",
    }


def test_the_same_key_is_the_same_question(console: Served) -> None:
    with console.client("clinician") as client:
        first, second = (client.post(REQUESTS, json={"ask": "start", "key": KEY}) for _ in range(2))
        other = client.post(REQUESTS, json={"ask": "reset", "key": KEY})
    assert first.json() == second.json()
    assert other.status_code == 409
    assert console.machine.pressed == [("start", "anna")]


def test_a_key_of_somebody_else_is_refused(console: Served) -> None:
    with console.client("clinician") as client:
        client.post(REQUESTS, json={"ask": "reset", "key": KEY})
        engineer = {"cookies": console.cookies("engineer"), "headers": console.headers("engineer")}
        client.cookies.clear()
        client.cookies.update(engineer["cookies"])
        answer = client.post(
            REQUESTS, json={"ask": "reset", "key": KEY}, headers=engineer["headers"]
        )
    assert answer.status_code == 409
    assert console.machine.pressed == [("reset", "anna")]


def test_to_calibrate_takes_a_reason_which_is_put_on_record(console: Served) -> None:
    with console.client("engineer") as client:
        for reason in (None, "", "   ", "a new\nconduit", "a new \x1b[31mconduit", " a conduit"):
            body = {"ask": "identify", "key": KEY, "reason": reason}
            answer = client.post(REQUESTS, json=body)
            assert answer.status_code == 422
            assert answer.json()["errors"][0]["field"] == "reason"
        assert console.machine.pressed == []
        body = {"ask": "identify", "key": KEY, "reason": "a new conduit"}
        assert client.post(REQUESTS, json=body).status_code == 200
    acts = [
        (one.done_by, one.what, one.detail)
        for one in console.site.records.history.list_actions("twin-1", 20)
    ]
    assert ("bert", "ask-identify", "a new conduit") in acts


def test_a_refusal_by_role_is_put_on_record_but_a_flood_of_them_once(console: Served) -> None:
    with console.client("observer") as client:
        for number in range(20):
            client.post(REQUESTS, json={"ask": "start", "key": f"start-{number:05}"})
    acts = [
        one for one in console.site.records.history.list_actions(None, 100) if one.what == "refused"
    ]
    assert [(one.done_by, one.detail) for one in acts] == [
        ("cora", "start: cora may not: Start a cycle")
    ]


def test_a_loop_that_does_not_answer_is_said_within_a_second_and_loudest_of_a_stop(
    console: Served,
) -> None:
    console.machine.answers = False
    with console.client("clinician") as client:
        start = client.post(REQUESTS, json={"ask": "start", "key": KEY})
        stop = client.post(REQUESTS, json={"ask": "abort", "key": f"{KEY}-2"})
        # It may have been heard all the same: to stop once more is refused to nobody.
        console.machine.answers = True
        again = client.post(REQUESTS, json={"ask": "abort", "key": f"{KEY}-2"})
    assert start.status_code == stop.status_code == 503
    assert "does not answer" in start.json()["detail"]
    assert stop.json()["detail"].startswith("NOBODY HEARS THE STOP")
    assert again.json()["verdict"] == "pressed"


def test_without_a_controller_a_stop_says_what_to_do(console: Served) -> None:
    console.machine.stop()
    with console.client() as client:
        answer = client.post(REQUESTS, json={"ask": "abort", "key": KEY})
    assert answer.status_code == 503
    assert "draw the catheter out by the handle" in answer.json()["detail"]


def test_the_controller_that_took_another_ones_place_is_asked(
    console: Served, tmp_path: Path
) -> None:
    with console.client() as client:
        assert client.post(REQUESTS, json={"ask": "abort", "key": KEY}).status_code == 200
        console.machine.stop()
        room = console.site.folder
        with WrittenMachine(room, str(tmp_path / "records.db"), "another-run") as other:
            answer = client.post(REQUESTS, json={"ask": "abort", "key": f"{KEY}-2"})
            assert answer.json()["verdict"] == "pressed"
            assert [ask for ask, _ in other.pressed] == ["abort"]


def test_a_stop_waits_for_no_other_request(
    console: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All threads wait for a database that hangs; a person can stop the machine all the same."""
    is_back, waiting = threading.Event(), threading.Semaphore(0)

    def hang(*_: object) -> None:
        waiting.release()
        is_back.wait()

    monkeypatch.setattr(console.site.accounts, "find_session", hang)
    with console.client("observer") as client:
        hanging = [
            threading.Thread(target=client.get, args=("/api/v1/session",)) for _ in range(50)
        ]
        for one in hanging:
            one.start()
        body, relief = {"ask": "abort", "key": KEY}, threading.Timer(30.0, is_back.set)
        relief.start()
        try:
            for _ in range(THREADS):
                assert waiting.acquire(timeout=20.0)
            assert client.post(REQUESTS, json=body).json()["verdict"] == "pressed"
            assert not is_back.is_set()
        finally:
            relief.cancel()
            is_back.set()
            for one in hanging:
                one.join()


def test_many_at_once_are_all_answered(console: Served) -> None:
    verdicts: list[str] = []
    with console.client() as client:

        def press(number: int) -> None:
            body = {"ask": "abort", "key": f"{KEY}-{number}"}
            verdicts.append(client.post(REQUESTS, json=body).json()["verdict"])

        threads = [threading.Thread(target=press, args=(number,)) for number in range(10)]
        for one in threads:
            one.start()
        for one in threads:
            one.join()
    assert verdicts == ["pressed"] * 10
