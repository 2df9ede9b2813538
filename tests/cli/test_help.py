"""Help: whole sentences, examples, no line that a terminal of 80 columns would break."""

from pathlib import Path

import pytest

from opensuction.cli.app import COMMANDS
from opensuction.identification.workbench import METHODS, MODELS
from opensuction.twin.fault.fault import BY_NAME
from tests.cli.command import opensuction

NAMES = [command.name for command in COMMANDS]


def helped(folder: Path, *arguments: str) -> str:
    ran = opensuction(*arguments, "--help", cwd=folder)
    assert (ran.returncode, ran.stderr) == (0, "")
    return ran.stdout


@pytest.mark.parametrize("columns", ["60", "80", "100", "200"])
def test_every_command_s_sentence_is_whole(
    columns: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    words = " ".join(helped(tmp_path).split())
    for command in COMMANDS:
        assert f"{command.name} {command.sentence}" in words
    assert "..." not in words.split("Commands:")[1]


def test_without_a_command_there_is_the_same_help(tmp_path: Path) -> None:
    ran = opensuction(cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert ran.stdout.strip() == helped(tmp_path).strip()


def test_help_of_all_names_exit_status_and_environment(tmp_path: Path) -> None:
    words = helped(tmp_path)
    for status in ("0  done", "1  failed", "2  bad", "74  ", "130  ", "141  ", "143  "):
        assert f" {status}" in words
    assert "OPENSUCTION_CACHE_DIR" in words


@pytest.mark.parametrize("name", ["", *NAMES])
def test_help_teaches_with_examples_and_fits_80_columns(name: str, tmp_path: Path) -> None:
    arguments = [name] if name else []
    words = helped(tmp_path, *arguments)
    assert f"opensuction {name}".strip() in words.split("Examples:")[1]
    assert "Exit status" in words
    assert max(len(line) for line in words.splitlines()) < 80
    short = opensuction(*arguments, "-h", cwd=tmp_path)
    assert short.stdout == words


def test_cycle_s_help_has_every_fault(tmp_path: Path) -> None:
    words = helped(tmp_path, "cycle")
    for name in BY_NAME:
        assert name in words
    for said in ("NAME[@S][=STRENGTH]", "valve-jammed@suctioning+2", "reference/faults.md"):
        assert said in words


def test_identify_s_help_names_every_model_and_method(tmp_path: Path) -> None:
    words = "".join(helped(tmp_path, "identify").split())  # a line may end at a hyphen
    for name in (*MODELS, *METHODS):
        assert name in words
