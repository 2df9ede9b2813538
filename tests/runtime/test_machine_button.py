"""Table of the machine's buttons: all of them, each with its right, each by the command line."""

from pathlib import Path

import pytest

from opensuction.accounts.rule import right
from opensuction.accounts.rule.right import Right
from opensuction.cli import completion
from opensuction.cli.command.run import ASK_DETAILS as ASK_HELP
from opensuction.ipc.mailbox import Mailbox
from opensuction.kernel.interface import NO_REQUESTS, STOP, Requests
from opensuction.runtime import launch, machine_folder
from opensuction.runtime.machine_button import BUTTONS, BY_NAME, MachineButton
from opensuction.session.running import run

BY_FIELD = {button.field: button for button in BUTTONS}


def test_every_button_of_the_controller_is_in_the_table_once() -> None:
    assert tuple(button.field for button in BUTTONS) == Requests._fields
    assert len(BY_NAME) == len(BUTTONS)


def test_only_the_stop_is_anybodys() -> None:
    assert BY_FIELD[STOP].right == Right.STOP
    assert [one.field for one in BUTTONS if one.right in right.ANYBODY] == [STOP]
    assert BY_FIELD["start"].right == Right.START


def test_what_a_program_may_have_presses_no_button() -> None:
    assert not right.READ_ONLY & {button.right for button in BUTTONS}


@pytest.mark.parametrize("button", BUTTONS, ids=lambda button: button.name)
@pytest.mark.parametrize("is_typed_as_recorded", [False, True])
def test_every_button_is_pressed_by_the_command_line(
    button: MachineButton,
    is_typed_as_recorded: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What is typed goes down at the controller, under the name that is on record."""
    assert button.name in completion.REQUESTS
    assert f" {button.name}" in ASK_HELP
    (tmp_path / machine_folder.EVENTS).touch()
    mailbox = Mailbox(tmp_path / machine_folder.ASK)

    def deliver(folder: Path, what: str, who: str, key: str, _: float) -> str:
        launch.send(folder, what, who, key)
        requests, (answer,) = mailbox.receive()
        assert requests == NO_REQUESTS._replace(**{button.field: True})
        assert answer.ask == button.field
        return answer.verdict

    monkeypatch.setattr(machine_folder, "find", lambda _: tmp_path)
    monkeypatch.setattr(launch, "ask", deliver)
    monkeypatch.setattr(run, "_find_phase", lambda _: "parked")
    try:
        typed = button.field if is_typed_as_recorded else button.name
        answer = run.ask("ward", typed, "Kim")
    finally:
        mailbox.close()
    assert (answer.request, answer.verdict) == (button.name, "pressed")
