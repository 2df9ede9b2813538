"""Every button acts once, however long it is held; an abort as long as it is."""

import pytest

from opensuction.kernel.interface import NO_REQUESTS, Requests
from opensuction.procedure.cycle import button

BUTTONS = Requests._fields


def down(*names: str) -> Requests:
    return NO_REQUESTS._replace(**dict.fromkeys(names, True))


@pytest.mark.requirement("OS-R44")
@pytest.mark.parametrize("name", BUTTONS)
def test_a_button_that_is_held_is_pressed_once(name: str) -> None:
    held = button.hold(down(name))
    assert held == 1 << BUTTONS.index(name)
    assert button.press_once(down(name), button.NONE) == down(name)
    assert button.press_once(down(name), held) == (down(name) if name == "abort" else NO_REQUESTS)
    # Let go and pressed again it acts again.
    assert button.press_once(down(name), button.hold(NO_REQUESTS)) == down(name)


@pytest.mark.parametrize("name", BUTTONS)
def test_no_button_hides_another(name: str) -> None:
    for other in BUTTONS:
        held = button.hold(down(other))
        if other != name:
            assert button.press_once(down(name), held) == down(name)
