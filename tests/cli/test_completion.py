"""Shell completion: every name a person may type, and quickly."""

from pathlib import Path

import pytest

from opensuction.accounts.rule.right import Role
from opensuction.cli import completion
from opensuction.cli.command.users import ACTS
from opensuction.control.compensation import KIND_OF_NAME
from opensuction.evidence.leaderboard.contender import BUILT_IN
from opensuction.evidence.leaderboard.data_set_table import DATA_SETS
from opensuction.evidence.lives.life_fault import Kind
from opensuction.evidence.trial.draw import COHORTS, FAULT_COUNTS
from opensuction.identification.judgement.recommendation import PURPOSES
from opensuction.identification.workbench import METHODS, MODELS
from opensuction.kernel.interface import Requests
from opensuction.procedure.planning.clinical import TEMPLATES
from opensuction.procedure.planning.protocol import PROTOCOLS
from opensuction.session.cycle.resolution import ANSWERS, APPROACHES
from opensuction.settings import conduit_file
from opensuction.twin import preset
from opensuction.twin.machine.catheter import CATHETERS, ROUTES
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES
from tests.cli.command import opensuction, opensuction_process


def completed(
    words: str, folder: Path, monkeypatch: pytest.MonkeyPatch, shell: str = "bash"
) -> list[str]:
    """What the shell is offered for the last word."""
    monkeypatch.setenv("_OPENSUCTION_COMPLETE", f"complete_{shell}")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(len(words.split(" ")) - 1))
    monkeypatch.setenv("_TYPER_COMPLETE_ARGS", words)
    monkeypatch.setenv("_TYPER_COMPLETE_FISH_ACTION", "get-args")
    ran = opensuction(cwd=folder)
    assert (ran.returncode, ran.stderr) == (0, "")
    return ran.stdout.split()


@pytest.mark.parametrize(
    ("names", "known"),
    [
        (completion.MACHINES, [*preset.MACHINE_TABLES, *conduit_file.MACHINES]),
        (completion.PROTOCOLS, {**TEMPLATES, **PROTOCOLS}),
        (completion.PATIENTS, PATIENT_TABLES),
        (completion.REQUESTS, [name.replace("_", "-") for name in Requests._fields]),
        (completion.CATHETERS, CATHETERS),
        (completion.CONDUITS, ROUTES),
        (completion.APPROACHES, APPROACHES),
        (completion.ACTS_ON_USERS, ACTS),
        (completion.ROLES, list(Role)),
        (completion.COMPENSATIONS, KIND_OF_NAME),
        (completion.MODELS, MODELS),
        (completion.CONTENDERS, BUILT_IN),
        (completion.DATA_SETS, DATA_SETS),
        (completion.METHODS, METHODS),
        (completion.PURPOSES, PURPOSES),
        (completion.PREOXYGENATION, ANSWERS),
        (completion.COHORTS, COHORTS),
        (completion.FAULT_COUNTS, FAULT_COUNTS),
        (completion.LIFE_FAULTS, tuple(map(str, Kind))),
    ],
)
def test_names_are_those_of_the_rooms_that_know_them(
    names: tuple[str, ...], known: list[str]
) -> None:
    assert names == tuple(known)


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("opensuction c", ["cycle", "calibrate", "compare", "cache"]),
        ("opensuction cycle --pat", ["--patient"]),
        ("opensuction cycle --patient ", list(completion.PATIENTS)),
        ("opensuction cycle --patient ad", ["adult-icu", "adult-ards"]),
        ("opensuction cycle --protocol p", ["paediatric", "paper"]),
        ("opensuction cycle --machine c", ["clinical"]),
        ("opensuction cycle --machine bench-b", ["bench-bouc-wen"]),
        ("opensuction calibrate --compensation ex", ["exact-inverse"]),
        ("opensuction cycle --fault pump", ["pump-runaway", "pump-weak", "pump-lost"]),
        ("opensuction identify my.csv --model d", ["dahl"]),
        ("opensuction cycle --patient my-", []),  # the shell offers files
    ],
)
def test_the_shell_is_offered_what_can_be_meant(
    words: str, offered: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert completed(words, tmp_path, monkeypatch) == offered


def test_every_shell_has_its_completion(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = "opensuction cycle --protocol pae"
    for shell in ("zsh", "fish"):
        assert "paediatric" in " ".join(completed(words, tmp_path, monkeypatch, shell))


def test_completion_loads_no_compiler(tmp_path: Path) -> None:
    environment = {
        "_OPENSUCTION_COMPLETE": "complete_bash",
        "COMP_WORDS": "opensuction cycle --compensation p",
        "COMP_CWORD": "3",
        "PYTHONPROFILEIMPORTTIME": "1",
    }
    ran = opensuction_process(cwd=tmp_path, environment=environment)
    assert ran.stdout.split() == ["prandtl-ishlinskii", "preview"]
    loaded = {line.split("|")[-1].strip().split(".")[0] for line in ran.stderr.splitlines()}
    assert "typer" in loaded  # the list is one of imports
    assert not loaded & {"numba", "numpy", "scipy"}


def test_completion_can_be_shown_and_installed(tmp_path: Path) -> None:
    environment = {
        "HOME": str(tmp_path),
        "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1",
    }
    shown = opensuction_process("--show-completion", "bash", cwd=tmp_path, environment=environment)
    assert shown.returncode == 0, shown.stderr
    assert "complete -o default -F _opensuction_completion opensuction" in shown.stdout
    installed = opensuction_process(
        "--install-completion", "bash", cwd=tmp_path, environment=environment
    )
    assert installed.returncode == 0, installed.stderr
    script = tmp_path / ".bash_completions" / "opensuction.sh"
    assert script.read_text().strip() == shown.stdout.strip()
