"""The leaderboard as a script has it."""

from collections.abc import Callable
from pathlib import Path

import pytest

import opensuction as osn
from opensuction.result.plain import Json
from tests.cli.result_schema import find_faults
from tests.evidence.leaderboard.data_set_example import LINE, PERCENT


class Nobody:
    """Can only be fitted."""

    def fit(self, *_: object) -> None:
        """Nothing."""


@pytest.fixture(scope="module")
def found() -> osn.Leaderboard:
    return osn.leaderboard(["straight-line"], data_sets=[LINE])


def test_entries_of_a_data_set(found: osn.Leaderboard) -> None:
    (entry,) = found["line"]
    assert (entry.model, entry.place) == ("straight-line", 1)
    with pytest.raises(KeyError, match="wall"):
        found["wall"]


def test_it_is_shown_and_has_the_object_of_the_command(found: osn.Leaderboard) -> None:
    assert f"line      straight-line  {PERCENT} (" in repr(found)
    assert "<td>straight-line</td>" in found._repr_html_()
    assert found.markdown.startswith("Written by `opensuction leaderboard`")
    summary: Json = found.summary
    assert find_faults("leaderboard", summary) == []


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: osn.leaderboard(["dal"], data_sets=[LINE]), "unknown model 'dal'"),
        (lambda: osn.leaderboard([Nobody()], data_sets=[LINE]), "'Nobody': has no predict"),
        (lambda: osn.leaderboard(data_sets=["wal"]), "unknown data set 'wal'"),
        (lambda: osn.leaderboard(data_sets=["wall"]), "can be used, see data; the first"),
        (lambda: osn.leaderboard(data="none", data_sets=["wall"]), "data none: no such folder"),
    ],
)
def test_bad_input_is_refused_in_the_words_of_python(
    call: Callable[[], osn.Leaderboard], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(osn.InputError) as refused:
        call()
    assert words in str(refused.value)
    assert "--" not in str(refused.value)
