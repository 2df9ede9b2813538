"""Resolution of a choice: a protocol in a file."""

from pathlib import Path

import pytest

from opensuction.procedure.planning.clinical import ADULT
from opensuction.procedure.planning.protocol import PAPER
from opensuction.session.cycle import resolution


def written(folder: Path, **changes: object) -> str:
    """A file with the paper's protocol but for these keys; None leaves one out."""
    given = {**PAPER._asdict(), **changes}
    lines = [
        f"{key} = {str(value).lower() if isinstance(value, bool) else value}"
        for key, value in given.items()
        if value is not None
    ]
    path = folder / "own.toml"
    path.write_text("\n".join(lines))
    return str(path)


@pytest.mark.parametrize(("bench_only", "usual_s"), [(False, ADULT.nothing_comes_s), (True, 0.0)])
def test_a_file_from_before_suction_ended_where_nothing_comes_is_read_as_is_usual_now(
    tmp_path: Path, bench_only: bool, usual_s: float
) -> None:
    path = written(tmp_path, nothing_comes_s=None, bench_only=bench_only)
    found = resolution.find_protocol(path)
    assert found == PAPER._replace(nothing_comes_s=usual_s, bench_only=bench_only)


def test_a_file_that_says_so_is_taken_at_its_word(tmp_path: Path) -> None:
    for said_s in (0.0, 1.5):
        path = written(tmp_path, nothing_comes_s=said_s, bench_only=False)
        assert resolution.find_protocol(path) == PAPER._replace(
            nothing_comes_s=said_s, bench_only=False
        )
