"""Answer of a machine to a button pressed from elsewhere, in words and as JSON."""

import pytest

from opensuction.result.plain import to_json
from opensuction.session.running.run import Answer, say

PRESSED = Answer("m", "oxygen-skipped", "Kim", "k1", "pressed", "parked")


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (PRESSED, "oxygen-skipped: the button went down; the machine is parked"),
        (PRESSED._replace(request="abort"), "abort: the button went down; the machine is parked"),
        (
            PRESSED._replace(verdict="nobody"),
            "oxygen-skipped: refused: say who asks; the machine is parked",
        ),
    ],
)
def test_an_answer_says_what_became_of_the_button(answer: Answer, words: str) -> None:
    assert say(answer) == words


def test_its_json_names_machine_button_person_and_verdict() -> None:
    assert to_json(PRESSED) == {
        "machine": "m",
        "request": "oxygen-skipped",
        "who": "Kim",
        "key": "k1",
        "verdict": "pressed",
        "phase": "parked",
    }
