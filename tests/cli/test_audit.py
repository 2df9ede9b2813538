"""The ``audit`` command as its users meet it."""

import json
from pathlib import Path

import pytest

from opensuction.records.records import Records
from tests.cli.command import opensuction, opensuction_process
from tests.records import recorded
from tests.records.example import fill, unguarded


@pytest.fixture
def head(tmp_path: Path) -> str:
    """The last hash of a database of records."""
    with Records.open(str(tmp_path / "ward.db")) as records:
        fill(records, 1)
        return records.head().hash


def test_whole_records_are_said_to_be_so(tmp_path: Path, head: str) -> None:
    ran = opensuction("audit", "--database", "ward.db", cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert ran.stdout == (
        f"ward.db: OK: 10 entries, last hash {head}\n"
        "ward.db: 1 recording unbound: no hash on record\n"
    )


def test_json_is_one_object(tmp_path: Path, head: str) -> None:
    ran = opensuction("audit", "--database", "sqlite:///ward.db", "--json", cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert json.loads(ran.stdout) == {
        "ok": True,
        "database": "ward.db",
        "entries": 10,
        "last_hash": head,
        "broken": None,
        "broken_at": None,
        "expected_head": None,
        "recordings": {"read": 0, "faults": [], "unbound": 1, "unbound_since": []},
    }


def test_the_environment_names_the_database(
    tmp_path: Path, head: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENSUCTION_DATABASE", str(tmp_path / "ward.db"))
    ran = opensuction("audit", "--expect-head", head, "--json", cwd=tmp_path)
    assert json.loads(ran.stdout)["expected_head"] == head


@pytest.mark.usefixtures("head")
def test_broken_records_are_one_line_and_status_1(tmp_path: Path) -> None:
    with Records.open(str(tmp_path / "ward.db")) as records, unguarded(records) as connection:
        connection.exec_driver_sql("UPDATE cycle_end SET outcome = 'aborted'")
    ran = opensuction("audit", "--database", "ward.db", cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (1, "")
    assert len(ran.stdout.splitlines()) == 1
    assert ran.stdout.startswith("ward.db: BROKEN: cycle_end '")
    ran = opensuction("audit", "--database", "ward.db", "--json", cwd=tmp_path)
    assert ran.returncode == 1
    data = json.loads(ran.stdout)
    assert (data["ok"], data["broken_at"]) == (False, 9)
    assert "its outcome is not what it was" in data["broken"]


@pytest.mark.usefixtures("head")
def test_a_head_that_is_not_there_is_status_1(tmp_path: Path) -> None:
    noted = "ab" * 32
    ran = opensuction("audit", "--database", "ward.db", "--expect-head", noted, cwd=tmp_path)
    assert ran.returncode == 1
    assert "no entry has the expected hash abababababab..." in ran.stdout


def test_each_recording_that_is_not_as_it_was_is_a_line(tmp_path: Path) -> None:
    with Records.open(str(tmp_path / "ward.db")) as records:
        recorded.fill(records, tmp_path)
    ran = opensuction("audit", "--database", "ward.db", cwd=tmp_path)
    assert ran.stdout.splitlines()[1:] == ["ward.db: OK: 4 recordings as their recorders left them"]
    first, second = (tmp_path / recorded.name_of(cycle) for cycle in (1, 2))
    second.replace(first)
    ran = opensuction("audit", "--database", "ward.db", cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (1, "")
    swapped, missing = ran.stdout.splitlines()
    assert swapped.startswith(f"ward.db: BROKEN: the recording {first.name} of cycle 1 of")
    assert f"was swapped: the file there is the recording {second.name} of cycle 2" in swapped
    assert f"{second.name} of cycle 2 of machine M-1 is missing in " in missing
    ran = opensuction("audit", "--database", "ward.db", "--json", cwd=tmp_path)
    data = json.loads(ran.stdout)
    assert data["broken"] == data["recordings"]["faults"][0]
    assert len(data["recordings"]["faults"]) == 2
    ran = opensuction("audit", "--database", "ward.db", "--trail-only", cwd=tmp_path)
    assert (ran.returncode, len(ran.stdout.splitlines())) == (0, 1)


BAD = [
    (("--database", "ward.db", "--recordings", "nowhere"), "--recordings nowhere: no such folder"),
    (("--database", "nowhere.db"), "no such file"),
    (("--database", "mysql://anna:secret@host/records"), "no kind of database"),
    (("--database", "postgresql://anna:secret@127.0.0.1:1/records"), "the server is not there"),
    (("--database", "ward.db", "--expect-head", "abc"), "no SHA-256"),
    (("--database", "."), "is a folder"),
]


@pytest.mark.usefixtures("head")
@pytest.mark.parametrize(("arguments", "words"), BAD, ids=[" ".join(given) for given, _ in BAD])
def test_bad_input_is_one_line(tmp_path: Path, arguments: tuple[str, ...], words: str) -> None:
    ran = opensuction("audit", *arguments, cwd=tmp_path)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert len(ran.stderr.splitlines()) == 1
    assert words in ran.stderr
    assert "secret" not in ran.stderr


def test_as_a_process_it_says_the_same(tmp_path: Path, head: str) -> None:
    ran = opensuction_process("audit", "--database", "ward.db", cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert head in ran.stdout
