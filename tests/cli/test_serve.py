"""Messages of ``serve`` about its console, and their order."""

import threading

import pytest

from opensuction.accounts.directory import NewPassword
from opensuction.cli.command.serve import Greeting
from opensuction.kernel.errors import InputError
from opensuction.records.database import utc_time
from opensuction.session.running import console_settings
from opensuction.session.running.console_settings import ConsoleSettings

SETTINGS = ConsoleSettings("127.0.0.1", 8080, None, "runs")
ADDRESS = "Console: http://127.0.0.1:8080/"
EVERYTHING = ("control", "recorder", "console")
WAITS_S = 30.0


class Served:
    """A greeting, what it has said, and the password that it waits for."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.made: NewPassword | None = NewPassword("admin", "one-two-three", utc_time.now())
        self.failure: Exception | None = None
        self.is_made = threading.Event()
        monkeypatch.setattr(console_settings, "first_password", self._make)
        self.said: list[str] = []
        self.greeting = Greeting(SETTINGS, self.said.append)

    def _make(self, _: str | None) -> NewPassword | None:
        assert self.is_made.wait(WAITS_S)
        if self.failure is not None:
            raise self.failure
        return self.made

    def make_password(self) -> None:
        self.is_made.set()
        assert self.greeting.password.exception(WAITS_S) is self.failure


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch) -> Served:
    return Served(monkeypatch)


def test_the_address_is_said_when_the_console_answers_and_what_starts_after_it(
    served: Served,
) -> None:
    served.make_password()
    served.greeting.look(EVERYTHING)
    assert served.said == []
    served.greeting.look(("control", "recorder"))
    password, address, notice, starting = served.said
    assert "sign in as admin with the one-time password one-two-three, until " in password
    assert address == ADDRESS
    assert "silico" in notice
    assert starting == "Still starting: controller, recorder"
    served.greeting.look(("recorder",))
    assert len(served.said) == 4
    served.greeting.look(())
    served.greeting.look(())
    assert served.said[4:] == ["Everything works now"]


def test_a_console_that_answers_last_is_said_alone(served: Served) -> None:
    served.made = None
    served.make_password()
    served.greeting.look(("console",))
    served.greeting.look(())
    served.greeting.look(())
    assert [line for line in served.said if "silico" not in line] == [ADDRESS]


def test_nobody_waits_for_the_password(served: Served) -> None:
    served.greeting.look(())
    assert served.said == []
    served.make_password()
    served.greeting.look(())
    assert ADDRESS in served.said


def test_a_password_that_cannot_be_made_ends_it_with_its_reason(served: Served) -> None:
    served.failure = InputError("the records cannot be written")
    served.make_password()
    with pytest.raises(InputError, match="the records cannot be written"):
        served.greeting.look(())
