"""The loop of the page on embedding completes its cycle at the slowest and fastest tick, too."""

from typing import Any

import pytest

from opensuction.runtime.embedded_controller import LONGEST_TICK_S, SHORTEST_TICK_S
from tests.docs.test_examples import ROOT, blocks

PAGE = ROOT / "docs" / "how-to" / "embed.md"
USUAL = "DT_S = 0.001"


@pytest.mark.parametrize("tick_s", [SHORTEST_TICK_S, LONGEST_TICK_S])
def test_the_plant_of_the_page_is_driven_at_every_tick_that_is_allowed(tick_s: float) -> None:
    text, names = PAGE.read_text("utf-8"), dict[str, Any]()
    assert text.count(USUAL) == 1
    for block in blocks(text.replace(USUAL, f"DT_S = {tick_s!r}")):
        if block.language == "python":
            # The page asserts what it says: its phases, no trip, no alarm.
            exec(compile(block.text, f"line {block.line}", "exec"), names)  # noqa: S102 - our page
    assert names["DT_S"] == tick_s
    assert names["phases"][-1] == "parked"
