"""A misspelt command, option or name is answered by the nearest one, in one line."""

from pathlib import Path

import pytest

from tests.cli.command import opensuction

CASES = [
    ("cylce", "No such command 'cylce'. Did you mean 'cycle'"),
    ("cycle --protcol paper", "No such option: --protcol. Did you mean '--protocol'"),
    ("cycle --protocol papr", "unknown protocol 'papr': did you mean 'paper'?"),
    ("cycle --patient neonat", "unknown patient 'neonat': did you mean 'neonate'?"),
    ("cycle --machine bensh", "unknown machine 'bensh': did you mean 'bench'?"),
    ("cycle --compensation exact", "did you mean 'exact-inverse'?"),
    ("cycle --fault clogged", "unknown fault 'clogged': did you mean 'line-clogged'?"),
    ("calibrate --catheter 12", "unknown catheter '12': did you mean '12fr'?"),
    ("cache --cleer", "No such option: --cleer. Did you mean '--clear'"),
]


@pytest.mark.parametrize(("words", "answer"), CASES, ids=[words for words, _ in CASES])
def test_the_nearest_is_named_in_one_line(words: str, answer: str, tmp_path: Path) -> None:
    ran = opensuction(*words.split(), cwd=tmp_path)
    assert (ran.returncode, ran.stdout) == (2, "")
    (line,) = ran.stderr.splitlines()
    assert line.startswith("opensuction: ")
    assert answer in line
    assert len(line) < 180
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "where"),
    [
        ("cylce", "See 'opensuction --help'"),
        ("identify", "see 'opensuction identify --help'"),
        ("cycle --seed x", "see 'opensuction cycle --help'"),
        ("cycle surplus", "see 'opensuction cycle --help'"),
        ("cycle --fault leek", "all 103 are in 'opensuction cycle --help'"),
    ],
)
def test_the_line_says_where_more_is(words: str, where: str, tmp_path: Path) -> None:
    assert where in opensuction(*words.split(), cwd=tmp_path).stderr
