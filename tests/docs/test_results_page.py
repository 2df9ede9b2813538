"""Keys of the objects that commands print are explained in `docs/reference/results.md`."""

import re
from pathlib import Path

import pytest

from tests.cli.result_schema import load

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "results.md"
SECTIONS = dict(re.findall(r"^## (\S+)\n(.*?)(?=^## |\Z)", PAGE.read_text("utf-8"), re.M | re.S))
DESCRIBED = sorted(SECTIONS.keys() & load()["$defs"].keys())
LIKE = {"compare": "identify", "report": "cycle"}
"""Objects with the keys of another, which its section names."""


def test_the_page_names_what_only_the_schema_describes() -> None:
    assert len(DESCRIBED) > 10
    rest = {name for name in load()["$defs"] if name[0].islower()} - SECTIONS.keys()
    assert rest == {
        "run",
        "ask",
        "inject",
        "device",
        "users",
        "cache",
        "replay-several",
        "trial-play",
        "simulate-play",
    }
    assert all(f"`{name}`" in SECTIONS["Schema"] for name in rest)


@pytest.mark.parametrize("command", DESCRIBED)
def test_every_key_is_explained(command: str) -> None:
    text = SECTIONS[command]
    if command in LIKE:
        assert LIKE[command] in text
        text += SECTIONS[LIKE[command]]
    explained = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`]*)`", text))))
    assert load()["$defs"][command]["properties"].keys() <= explained
