"""The page of readable recordings lists every file beside the project, and what comes of it."""

import re
from pathlib import Path

import pytest

from opensuction.kernel.errors import InputError
from opensuction.recording import table

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT.parent / "shared" / "data"
"""Recordings of others, beside the project where there are any."""
PAGE = (ROOT / "docs" / "reference" / "recordings.md").read_text(encoding="utf-8")
ROWS = [
    [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
    for line in PAGE.splitlines()
    if re.match(r"\| `[a-z]+/", line)
]


@pytest.mark.skipif(not FOLDER.is_dir(), reason="no recordings beside the project")
def test_every_file_beside_the_project_is_listed_once() -> None:
    there = {
        path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*.*") if path.suffix != ".md"
    }
    assert there
    assert sorted(there) == sorted(file.strip("`") for file, *_ in ROWS)


@pytest.mark.skipif(not FOLDER.is_dir(), reason="no recordings beside the project")
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0].strip("`"))
def test_a_listed_file_has_its_samples_or_is_refused_as_it_says(row: list[str]) -> None:
    file, _, choice, samples, outcome = row
    opened = table.open_table(FOLDER / file.strip("`"))
    named = [table.find_name(opened, name) for name in re.findall(r"`([^`]+)`", choice)]
    if choice == "the same":
        named = ["spindle_deg", "jaw_deg"]
    wanted = [name for name in named if name in opened.names]
    assert len(wanted) == 2
    if outcome.startswith("refused:"):
        words = re.findall(r"\*(.+?)\*", outcome)[0]
        with pytest.raises(InputError, match=re.escape(words)):
            table.read_columns(opened, wanted)
        return
    columns, _ = table.read_columns(opened, wanted, "--skip-missing" in choice)
    assert f"{columns[wanted[0]].size:,}" == samples
