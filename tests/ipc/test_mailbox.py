"""Requests of people reach the loop once, in order, fresh and from somebody; to stop, always."""

import json
import socket
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.ipc import mailbox
from opensuction.ipc.mailbox import Mailbox, MailboxAnswer, Sender
from opensuction.ipc.ring import EventWriter
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import ABORT, NO_REQUESTS

AT = "2026-11-23T12:00:00Z"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "requests"


@pytest.fixture
def box(path: Path) -> Iterator[Mailbox]:
    made = Mailbox(path)
    yield made
    made.close()


@pytest.fixture
def nurse(path: Path, box: Mailbox) -> Iterator[Sender]:  # noqa: ARG001 - that listens
    made = Sender(path, "nurse")
    yield made
    made.close()


def verdicts(answers: list[MailboxAnswer]) -> list[str]:
    return [answer.verdict for answer in answers]


def send(path: Path, data: bytes) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.sendto(data, str(path))


def asked(**changes: Any) -> bytes:
    told = {
        "ask": "start",
        "who": "nurse",
        "key": "k",
        "at": AT,
        "number": 1,
        "sent_ns": time.monotonic_ns(),
    }
    return json.dumps(told | changes).encode()


def test_a_request_presses_its_button_for_one_tick(box: Mailbox, nurse: Sender) -> None:
    assert box.receive() == (NO_REQUESTS, [])
    nurse.ask("start", "a", AT)
    requests, answers = box.receive()
    assert requests == NO_REQUESTS._replace(start=True)
    assert answers == [MailboxAnswer("a", "nurse", "start", AT, "pressed")]
    assert box.receive() == (NO_REQUESTS, [])


def test_four_a_tick_are_taken_up_and_the_rest_in_the_next(box: Mailbox, nurse: Sender) -> None:
    for ask in ("start", "confirm", "home", "acknowledge", "assessed"):
        nurse.ask(ask, ask, AT)
    first, second = box.receive()[0], box.receive()[0]
    assert first == NO_REQUESTS._replace(start=True, confirm=True, home=True, acknowledge=True)
    assert second == NO_REQUESTS._replace(assessed=True)


def test_two_that_press_the_same_button_press_it_twice(box: Mailbox, nurse: Sender) -> None:
    """A button that stays down asks once; it must come up between them."""
    nurse.ask("acknowledge", "a", AT)
    nurse.ask("acknowledge", "b", AT)
    pressed = [box.receive()[0].acknowledge for _ in range(5)]
    assert pressed == [True, False, True, False, False]


def test_what_comes_twice_is_obeyed_once(path: Path, box: Mailbox) -> None:
    send(path, asked())
    send(path, asked(number=2))
    requests, answers = box.receive()
    assert requests.start
    assert verdicts(answers) == ["pressed", "twice"]
    assert box.receive() == (NO_REQUESTS, [])


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({"who": ""}, "nobody"),
        ({"who": "  "}, "nobody"),
        ({"ask": "explode"}, "unknown"),
        ({"sent_ns": 1}, "stale"),
        ({"sent_ns": 1 << 62}, "early"),
        ({"number": -1}, "out of order"),
        ({"number": 1.0}, "malformed"),
        ({"number": True}, "malformed"),
        ({"key": ""}, "malformed"),
        ({"key": 5}, "malformed"),
        ({"who": "x" * 65}, "malformed"),
        ({"more": 1}, "malformed"),
    ],
)
def test_what_is_not_as_it_should_be_presses_nothing(
    path: Path, box: Mailbox, changes: dict[str, Any], verdict: str
) -> None:
    send(path, asked(**changes))
    requests, answers = box.receive()
    assert requests == NO_REQUESTS
    assert verdicts(answers) == [verdict]


def test_a_later_request_that_came_first_ends_an_earlier_one(path: Path, box: Mailbox) -> None:
    send(path, asked(key="b", number=5, ask="confirm"))
    send(path, asked(key="a", number=4))
    send(path, asked(key="c", number=1, who="engineer", ask="home"))
    requests, answers = box.receive()
    assert requests == NO_REQUESTS._replace(confirm=True, home=True)
    assert verdicts(answers) == ["pressed", "out of order", "pressed"]


def test_to_stop_is_refused_to_nobody(path: Path, box: Mailbox) -> None:
    """Old, from nobody, out of order: a stop that comes late is still one."""
    send(path, asked(key="later", number=9, ask="confirm"))
    send(path, asked(ask="abort", who="", number=-5, sent_ns=1))
    requests, answers = box.receive()
    assert requests == ABORT._replace(confirm=True)
    assert verdicts(answers) == ["pressed", "pressed"]


def test_nor_is_it_with_a_key_that_was_there_before(path: Path, box: Mailbox) -> None:
    """Of a start, or of another stop a while ago."""
    send(path, asked(key="k"))
    assert box.receive()[0].start
    for number in (2, 3):
        send(path, asked(key="k", ask="abort", number=number))
        assert box.receive()[0] == ABORT
        box.receive()


def test_no_stop_is_one_too_many(path: Path, box: Mailbox) -> None:
    """As many as can come, tick after tick: each is heard in its tick or in the next but one."""
    heard, pressed = 0, []
    for tick in range(100):
        for one in range(mailbox.MOST):
            send(path, asked(ask="abort", key=f"k{tick}-{one}", number=tick * mailbox.MOST + one))
        requests, answers = box.receive()
        assert set(verdicts(answers)) <= {"pressed"}
        heard += len(answers)
        pressed.append(requests.abort)
    heard += sum(len(box.receive()[1]) for _ in range(2))
    assert heard == 100 * mailbox.MOST
    assert not any(not one and not other for one, other in pairwise(pressed))


def test_stops_are_no_reason_to_obey_a_button_twice(path: Path, box: Mailbox) -> None:
    send(path, asked(key="k"))
    assert box.receive()[0].start
    for number in range(2, mailbox.KEYS_KEPT + 3):
        send(path, asked(ask="abort", key=f"s{number}", number=number))
        box.receive()
    send(path, asked(key="k", number=mailbox.KEYS_KEPT + 9))
    assert verdicts(box.receive()[1]) == ["twice"]


def test_half_a_letter_can_be_answered_among_the_events(path: Path, box: Mailbox) -> None:
    send(path, asked(who="nurse \ud800"))
    requests, (told,) = box.receive()
    assert requests.start
    with EventWriter(path.with_name("events")) as events:
        events.write("request", 1, **told._asdict())


@given(data=st.binary(max_size=300))
def test_no_bytes_disturb_it(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.mktemp("box") / "requests"
    box = Mailbox(path)
    send(path, data)
    assert box.receive() == (NO_REQUESTS, [MailboxAnswer("", "", "", "", "malformed")])
    box.close()


@pytest.mark.parametrize(
    "data", [b"[" * 2000, b"1e999", b"{}", b"x" * 3000, b"null", b'{"ask": 1}']
)
def test_nor_do_these(path: Path, box: Mailbox, data: bytes) -> None:
    send(path, data)
    assert verdicts(box.receive()[1]) == ["malformed"]


def fill(sender: Sender) -> int:
    """Ask until there is no room; how many got in."""
    for sent in range(5000):
        try:
            sender.ask("acknowledge", f"k{sent}", AT)
        except InputError as error:
            assert "timed out" in str(error)
            return sent
    return 0


def test_one_who_asks_without_end_keeps_nobody_from_stopping(box: Mailbox, nurse: Sender) -> None:
    sent = fill(nurse)
    nurse.ask("abort", "stop", AT)
    requests, answers = box.receive()
    assert requests.abort
    answered = len(answers)
    for _ in range(3 * sent):
        answered += len(box.receive()[1])
    assert answered == sent + 1 > 1


def test_memory_of_keys_and_senders_is_bounded(path: Path, box: Mailbox) -> None:
    for number in range(3000):
        send(
            path, asked(key=f"k{number}", who=f"w{number}", ask="home" if number % 2 else "confirm")
        )
        box.receive()
    assert len(box._seen) <= mailbox.KEYS_KEPT
    assert len(box._last) <= mailbox.SENDERS_KEPT


def test_where_nobody_listens_or_can_listen_is_a_line(tmp_path: Path) -> None:
    sender = Sender(tmp_path / "nowhere", "nurse")
    with pytest.raises(InputError, match=r"no controller takes requests at .*nowhere"):
        sender.ask("start", "a", AT)
    sender.close()
    with pytest.raises(InputError, match="no requests can be taken at"):
        Mailbox(tmp_path / "no folder" / "requests")


@pytest.mark.usefixtures("box")
@pytest.mark.parametrize("name", ["requests", "requests.stop"])
def test_only_the_same_user_may_ask(path: Path, name: str) -> None:
    assert path.with_name(name).stat().st_mode & 0o777 == 0o600
