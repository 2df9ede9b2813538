"""Presses of one person are carried out in their order; Stop overtakes."""

import logging
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute

from opensuction.console.access import leave_turn, wait_turn
from opensuction.console.app import ROUTERS
from opensuction.console.guard.limits import UNHURRIED, Limits
from opensuction.console.guard.origin import SAFE
from opensuction.console.live.button_press import Asking, ButtonPress
from opensuction.kernel.errors import InputError
from tests.console.listening import listening
from tests.console.pressing import LONG_S, REQUESTS, Pressing, pressing
from tests.runtime.machine_room import wait

pytestmark = pytest.mark.real_time

PATIENT = UNHURRIED._replace(place_s=LONG_S, turn_s=LONG_S)
SHORT_S = 0.2
"""A bound that a test waits for."""
OUT_OF_TURN = {
    ("POST", "/session"),  # somebody else, who waits for nothing of whoever sat here before
    ("POST", "/protocol/plan"),  # arithmetic, while somebody types
    ("POST", "/cycles/{id}/replay"),  # work on recordings
    ("POST", "/audit"),  # reads the records
}
"""Changes nothing that a button acts on, and may take long: no button waits for it."""


@pytest.fixture
def limits() -> Limits:
    return PATIENT


@pytest.fixture
def people(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limits: Limits) -> Iterator[Pressing]:
    with listening(tmp_path, limits) as console, pressing(console, monkeypatch) as made:
        yield made


def verdicts(*answers: Any) -> list[str]:
    return [one.result(LONG_S).json()["verdict"] for one in answers]


def test_the_next_buttons_of_a_person_do_not_overtake_a_slow_first(people: Pressing) -> None:
    """Each by a connection of its own, as two pages of one session have; others do not wait."""
    first = people.hold("clinician", REQUESTS, people.button("acknowledge"))
    second = people.press("clinician", "audio-pause")
    third = people.press("clinician", "assessed")
    people.let_others_be_faster()
    assert people.pressed == []
    people.held.may_go.set()
    assert verdicts(first, second, third) == ["pressed"] * 3
    assert people.pressed == ["acknowledge", "audio_pause", "assessed"]


def test_a_stop_overtakes_and_what_was_pressed_before_it_does_not_follow(people: Pressing) -> None:
    first = people.hold("clinician", REQUESTS, people.button("start"))
    second = people.press("clinician", "audio-pause")
    assert verdicts(people.press("clinician", "abort")) == ["pressed"]
    # What waited is refused at once, though what it waited for still hangs.
    refused = second.result(LONG_S)
    later = people.press("clinician", "assessed")
    people.let_others_be_faster()
    assert people.pressed == ["abort"]
    people.held.may_go.set()
    assert refused.status_code == first.result(LONG_S).status_code == 409
    assert "Stop was pressed" in refused.json()["detail"]
    assert verdicts(later) == ["pressed"]
    assert people.pressed == ["abort", "assessed"]


def test_nor_what_somebody_else_pressed_before_the_stop(people: Pressing) -> None:
    first = people.hold("clinician", REQUESTS, people.button("start"))
    assert verdicts(people.press(None, "abort")) == ["pressed"]
    people.held.may_go.set()
    assert first.result(LONG_S).status_code == 409
    assert people.pressed == ["abort"]


def test_a_stop_whose_body_is_late_does_not_refuse_what_is_pressed_after_it(
    people: Pressing,
) -> None:
    stop = people.button("abort")
    with people.line(None, stop, shown=5) as line:
        people.let_others_be_faster()  # its headers have come
        later = people.hold("clinician", REQUESTS, people.button("assessed"))
        line.sendall(people.bytes_of(stop)[5:])
        assert line.recv(4096).startswith(b"HTTP/1.1 200")
        people.held.may_go.set()
    assert verdicts(later) == ["pressed"]
    assert people.pressed == ["abort", "assessed"]


MORE_STEPS = [
    ("PUT", "/patient", {"pseudonym": "A-1", "version": 0}),
    ("POST", "/teaching", {"step": "prepare", "version": 0}),
    ("PUT", "/catheter", {"label": "another"}),
    ("POST", "/identification/none/accept", {"reason": "a new conduit", "version": 0}),
]
STEPS = [
    ("PUT", "/protocol", {"approach": "travel", "protocol": {}, "version": 0}),
    ("PUT", "/session/password", {"present": "not this", "wanted": "neither this one"}),
    ("DELETE", "/session", {}),
]


@pytest.mark.parametrize(
    ("method", "path", "sent"),
    [*STEPS, *(pytest.param(*one, marks=pytest.mark.sweep) for one in MORE_STEPS)],
)
def test_a_button_does_not_overtake_a_step_of_the_set_up(
    people: Pressing, method: str, path: str, sent: dict[str, Any]
) -> None:
    """Whatever becomes of the step, which not each person may take and not now."""
    has_key = not path.startswith("/session")
    step = people.hold("clinician", path, {**sent, "key": "step-0001"} if has_key else sent, method)
    button = people.press("clinician", "audio-pause")
    people.let_others_be_faster()
    assert people.pressed == []
    assert not button.done()
    people.held.may_go.set()
    assert step.result(LONG_S).status_code < 500
    has_ended = method == "DELETE"
    assert button.result(LONG_S).status_code == (401 if has_ended else 200)
    assert people.pressed == ([] if has_ended else ["audio_pause"])


def test_a_step_that_is_carried_out_comes_before_the_button_after_it(people: Pressing) -> None:
    sent = {"step": "prepare", "version": 1, "key": "step-0001"}
    step = people.hold("clinician", "/teaching", sent)
    button = people.press("clinician", "audio-pause")
    people.let_others_be_faster()
    assert people.pressed == []
    people.held.may_go.set()
    assert step.result(LONG_S).status_code == 200, step.result().text
    assert verdicts(button) == ["pressed"]
    told = [one.what for one in people.console.site.records.history.list_actions(None, 10)]
    assert "prepare-teaching" in told


def test_a_first_that_fails_lets_the_next_go_on(people: Pressing) -> None:
    people.held.fails = True
    first = people.hold("clinician", REQUESTS, people.button("acknowledge"))
    second = people.press("clinician", "audio-pause")
    people.let_others_be_faster()
    assert people.pressed == []
    people.held.may_go.set()
    assert first.result(LONG_S).status_code == 500
    assert verdicts(second) == ["pressed"]


def test_a_first_that_hangs_up_in_its_body_lets_the_next_go_on(people: Pressing) -> None:
    """The order is that of the headers: a body that comes late does not lose it."""
    people.held.may_go.set()
    with people.line("clinician", people.button("acknowledge"), shown=5):
        people.let_others_be_faster()  # its headers have come
        second = people.press("clinician", "audio-pause")
        people.let_others_be_faster()
        assert people.pressed == []
    assert verdicts(second) == ["pressed"]
    assert people.pressed == ["audio_pause"]


def test_a_body_that_comes_late_comes_in_its_turn(people: Pressing) -> None:
    people.held.may_go.set()
    first = people.button("acknowledge")
    with people.line("clinician", first, shown=5) as line:
        people.let_others_be_faster()
        second = people.press("clinician", "audio-pause")
        people.let_others_be_faster()
        line.sendall(people.bytes_of(first)[5:])
        assert line.recv(4096).startswith(b"HTTP/1.1 200")
    assert verdicts(second) == ["pressed"]
    assert people.pressed == ["acknowledge", "audio_pause"]


@pytest.mark.parametrize("limits", [PATIENT._replace(place_s=SHORT_S)])
def test_a_body_that_comes_too_late_has_lost_its_turn(people: Pressing) -> None:
    people.held.may_go.set()
    first = people.button("acknowledge")
    with people.line("clinician", first, shown=5) as line:
        people.let_others_be_faster()
        assert verdicts(people.press("clinician", "audio-pause")) == ["pressed"]
        assert wait(lambda: people.pressed == ["audio_pause"], LONG_S)
        line.sendall(people.bytes_of(first)[5:])
        assert line.recv(4096).startswith(b"HTTP/1.1 408")
    assert people.pressed == ["audio_pause"]


def test_what_nobody_waits_for_any_more_is_not_pressed(
    people: Pressing, caplog: pytest.LogCaptureFixture
) -> None:
    first = people.hold("clinician", REQUESTS, people.button("acknowledge"))
    with caplog.at_level(logging.WARNING, "opensuction.console"):
        with people.line("clinician", people.button("start")):
            people.let_others_be_faster()
        assert wait(lambda: "409 POST /api/v1/requests" in caplog.text, LONG_S)
    people.held.may_go.set()
    assert verdicts(first) == ["pressed"]
    assert people.pressed == ["acknowledge"]


@pytest.mark.parametrize("limits", [PATIENT._replace(turn_s=SHORT_S)])
def test_what_would_be_pressed_much_later_is_refused(people: Pressing) -> None:
    first = people.hold("clinician", REQUESTS, people.button("acknowledge"))
    late = people.press("clinician", "start").result(LONG_S)
    assert (late.status_code, people.pressed) == (503, [])
    people.held.may_go.set()
    assert verdicts(first) == ["pressed"]
    assert people.pressed == ["acknowledge"]


def test_who_waits_for_room_in_the_mailbox_is_not_overtaken(
    people: Pressing, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A thread waits for room; meanwhile there is room again, and the next would find it."""
    people.held.may_go.set()
    put, waits, may_go = Asking._put, threading.Event(), threading.Event()

    def put_slowly(asking: Asking, asked: ButtonPress, patience_s: float) -> None:
        if asked.ask == "acknowledge":
            if patience_s == 0.0:
                raise InputError("no room")
            waits.set()
            assert may_go.wait(LONG_S)
        put(asking, asked, patience_s)

    monkeypatch.setattr(Asking, "_put", put_slowly)
    first = people.press("clinician", "acknowledge")
    assert waits.wait(LONG_S)
    second = people.press("clinician", "audio-pause")
    people.let_others_be_faster()
    assert people.pressed == []
    may_go.set()
    assert verdicts(first, second) == ["pressed"] * 2
    assert people.pressed == ["acknowledge", "audio_pause"]


@pytest.mark.parametrize(
    ("path", "sent"),
    [
        ("/protocol/plan", {"approach": "travel", "protocol": {}}),
        pytest.param("/cycles/none/replay", {}, marks=pytest.mark.sweep),
        pytest.param("/audit", {"expected": None}, marks=pytest.mark.sweep),
    ],
)
def test_no_button_waits_for_what_only_reads(
    people: Pressing, path: str, sent: dict[str, Any]
) -> None:
    reading = people.hold("clinician", path, sent)
    assert verdicts(people.press("clinician", "audio-pause")) == ["pressed"]
    assert not reading.done()


def test_whoever_changes_something_does_so_in_turn() -> None:
    """A route that nobody thought of would let a button overtake, or make it wait."""
    in_turn, out_of_turn = set(), set()
    for route in (one for router in ROUTERS for one in router.routes):
        if not isinstance(route, APIRoute):
            continue
        asked = calls(route.dependant)
        for method in (route.methods or set()) - SAFE:
            place = (method, route.path)
            if wait_turn in asked:
                in_turn.add(place)
            elif leave_turn in asked:
                out_of_turn.add(place)
            else:
                assert place == ("POST", REQUESTS)  # which first looks whether it is to stop
    assert out_of_turn == OUT_OF_TURN
    assert {
        (method, path.replace("none", "{run}")) for method, path, _ in STEPS + MORE_STEPS
    } < in_turn


def calls(dependant: Dependant) -> set[Any]:
    return {dependant.call}.union(*(calls(one) for one in dependant.dependencies))
