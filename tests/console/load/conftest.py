"""A machine with its console, which the short runs share."""

from collections.abc import Iterator

import pytest

from tests.console.load.console_machine import ConsoleMachine, console_machine


@pytest.fixture(scope="package")
def machine() -> Iterator[ConsoleMachine]:
    with console_machine() as made:
        yield made
