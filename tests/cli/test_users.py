"""The ``users`` command as its users meet it."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from opensuction.accounts.accounts import Accounts
from opensuction.records.records import Records
from tests.accounts.example import HERE
from tests.cli.command import opensuction

DATABASE = ("--database", "ward.db")


def told(folder: Path, *arguments: str) -> dict[str, Any]:
    """What the command says as JSON."""
    ran = opensuction("users", *arguments, *DATABASE, "--json", cwd=folder)
    assert (ran.returncode, ran.stderr) == (0, "")
    data: dict[str, Any] = json.loads(ran.stdout)
    return data


@pytest.fixture(scope="module")
def pattern(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a site of one administrator and one clinician, whose passwords take long."""
    folder = tmp_path_factory.mktemp("pattern")
    told(folder, "add", "eva", "--role", "engineer", "--administrator")
    told(folder, "add", "anna", "--role", "clinician")
    return folder


@pytest.fixture
def ward(pattern: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return shutil.copytree(pattern, tmp_path, dirs_exist_ok=True)


def sign_in(folder: Path, name: str, password: str) -> bool:
    """Whether somebody must change the password after signing in."""
    with Records.open(str(folder / "ward.db")) as records:
        return Accounts(records.database).sign_in(name, password, HERE).session.must_change_password


def test_an_account_is_added_with_a_password_that_works_once(tmp_path: Path) -> None:
    ran = opensuction(
        *("users", "add", "eva", "--role", "engineer", "--administrator", *DATABASE), cwd=tmp_path
    )
    assert (ran.returncode, ran.stderr) == (0, "")
    assert len(ran.stdout.splitlines()) == 1
    assert ran.stdout.startswith("eva: one-time password ")
    assert sign_in(tmp_path, "eva", ran.stdout.split()[3].rstrip(","))


def test_accounts_are_listed_a_line_each(ward: Path) -> None:
    told(ward, "deactivate", "anna", "--reason", "left the ward")
    ran = opensuction("users", *DATABASE, cwd=ward)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert ran.stdout.splitlines() == [
        "anna: clinician, deactivated",
        "eva: engineer, administrator, has a one-time password",
    ]


def test_json_is_one_object(ward: Path) -> None:
    data = told(ward)
    assert list(data) == [
        *("database", "act", "account", "one_time_password", "expires_at", "accounts")
    ]
    assert (data["database"], data["act"], data["one_time_password"]) == ("ward.db", "list", None)
    anna, eva = data["accounts"]
    assert anna == {
        "name": "anna",
        "role": "clinician",
        "administrator": False,
        "active": True,
        "must_change_password": True,
        "password_set_at": anna["password_set_at"],
    }
    assert eva["administrator"] is True
    assert anna["password_set_at"].endswith("+00:00")


def test_a_role_is_changed_with_a_reason(ward: Path) -> None:
    data = told(ward, "role", "anna", "--role", "observer", "--reason", "back to school")
    assert [one["role"] for one in data["accounts"]] == ["observer", "engineer"]
    with Records.open(str(ward / "ward.db")) as records:
        act = records.history.list_actions()[0]
    assert (act.done_by, act.what) == ("command-line", "change-role")
    assert act.detail == "anna: observer, was clinician: back to school"


def test_who_is_locked_out_gets_in_with_a_new_password(ward: Path) -> None:
    told(ward, "deactivate", "anna", "--reason", "a mistake")
    data = told(ward, "reset-password", "anna")
    assert data["accounts"][0]["active"] is True
    assert sign_in(ward, "anna", data["one_time_password"])


def test_the_environment_names_the_database(ward: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENSUCTION_DATABASE", str(ward / "ward.db"))
    ran = opensuction("users", cwd=ward)
    assert len(ran.stdout.splitlines()) == 2


def test_records_without_accounts_have_none(tmp_path: Path) -> None:
    Records.open(str(tmp_path / "ward.db")).close()
    ran = opensuction("users", *DATABASE, cwd=tmp_path)
    assert (ran.returncode, ran.stdout) == (0, "ward.db: no accounts yet\n")


BAD = [
    (("lst",), "did you mean 'list'"),
    (("list", "anna"), "takes no name"),
    (("add",), "say whose account: opensuction users add NAME"),
    (("add", "dora"), "--role observer, clinician or engineer"),
    (("add", "dora", "--role", "nurse"), "unknown role 'nurse'"),
    (("add", "Dora", "--role", "observer"), "the name 'Dora' is none"),
    (("add", "anna", "--role", "observer"), "there is an account 'anna' already"),
    (("role", "anna", "--role", "engineer"), "say why"),
    (("deactivate", "anna"), "say why"),
    (("deactivate", "ana", "--reason", "left"), "did you mean 'anna'"),
    (("deactivate", "eva", "--reason", "left"), "is the last administrator"),
    (("reset-password", "nobody"), "unknown account 'nobody'"),
]


@pytest.mark.parametrize(("arguments", "words"), BAD, ids=[" ".join(given) for given, _ in BAD])
def test_bad_input_is_one_line(ward: Path, arguments: tuple[str, ...], words: str) -> None:
    before = told(ward)
    ran = opensuction("users", *arguments, *DATABASE, cwd=ward)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert len(ran.stderr.splitlines()) == 1
    assert words in ran.stderr
    assert told(ward) == before


@pytest.mark.parametrize("act", ["list", "deactivate"])
def test_a_database_misspelt_is_not_made(tmp_path: Path, act: str) -> None:
    arguments = [act] if act == "list" else [act, "anna", "--reason", "left"]
    ran = opensuction("users", *arguments, "--database", "wrad.db", cwd=tmp_path)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert "wrad.db: no such file" in ran.stderr
    assert list(tmp_path.iterdir()) == []
