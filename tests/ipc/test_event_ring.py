"""Whatever is told in words can be heard, with its kind, tick and time."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.ipc.ring import EventReader, EventWriter


@given(words=st.lists(st.text(max_size=2048), min_size=1, max_size=8))
def test_words_of_any_length_are_heard(
    tmp_path_factory: pytest.TempPathFactory, words: list[str]
) -> None:
    path = tmp_path_factory.mktemp("events") / "told"
    fields = {f"word {i}": word for i, word in enumerate(words)}
    with EventWriter(path) as writer:
        writer.write("request", 7, **fields)
        (heard,), missed = EventReader(path).read()
    assert (heard.number, missed) == (1, 0)
    assert (heard.fields["kind"], heard.fields["tick"]) == ("request", 7)
    assert heard.fields["time_ns"] > 0
    for name, word in fields.items():
        assert heard.fields[name] == word or word.startswith(heard.fields[name][:-3])


def test_the_longest_words_a_request_may_have_are_cut_last(tmp_path: Path) -> None:
    """Letters of four bytes, and such as are written as six: key and name are still there."""
    with EventWriter(tmp_path / "told") as writer:
        for letter in ("\N{GRINNING FACE}", "\x00", "\ud800"):
            long = dict.fromkeys(("key", "who", "ask", "at"), 64 * letter)
            writer.write("request", 1, verdict="unknown", **long)
        for heard in EventReader(tmp_path / "told").read()[0]:
            assert heard.fields["verdict"] == "unknown"
            assert set(heard.fields) >= {"key", "who", "ask", "at", "time_ns"}
