"""``opensuction cache``: where the compiled core is, how much of it, and away with it."""

import json
from pathlib import Path

import pytest

from opensuction.kernel import compiled
from tests.cli.command import opensuction, opensuction_process

OLD = "0123456789abcdef"
"""A folder named as those of an earlier version are."""


def test_the_cache_is_shown_cleared_and_used_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = tmp_path / "kept here"
    (root / OLD / "inner").mkdir(parents=True)
    (root / OLD / "inner" / "loop.nbc").write_bytes(bytes(2_000_000))
    (root / "mine").mkdir()
    (root / "mine" / "notes.txt").write_text("not machine code")
    environment = {"OPENSUCTION_CACHE_DIR": str(root)}

    def ran(*options: str) -> str:
        done = opensuction_process("cache", *options, cwd=tmp_path, environment=environment)
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout

    shown = json.loads(ran("--json"))
    assert (shown["folder"], shown["size_bytes"], shown["cleared"]) == (str(root), 2_000_000, False)
    assert [version["is_current"] for version in shown["versions"]].count(True) == 1
    (version,) = (one["folder"] for one in shown["versions"] if one["is_current"])
    monkeypatch.setattr(compiled, "CACHE_FOLDER", Path(version))  # as in a process of its own
    words = " ".join(opensuction("cache", cwd=tmp_path).stdout.split())
    assert f"Compiled core: {root}" in words
    assert f"{OLD} 2.0 MB" in words
    assert "OPENSUCTION_CACHE_DIR=DIR" in words
    assert "Removed 2.0 MB" in opensuction("cache", "--clear", cwd=tmp_path).stdout
    assert not (root / OLD).exists()
    assert (root / "mine" / "notes.txt").read_text() == "not machine code"
    after = json.loads(ran("--clear", "--json"))
    assert (after["size_bytes"], after["cleared"]) == (0, True)
