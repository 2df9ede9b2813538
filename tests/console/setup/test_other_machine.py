"""A console before a machine that is no twin: it works, and offers nothing that is not there."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest

from opensuction.kernel.vocabulary import NOT_A_DEVICE
from opensuction.machine.port import DESCRIPTION, EVERYTHING, NOTHING, Capabilities, describe
from opensuction.runtime import machine_folder
from tests.console import written_machine
from tests.console.served import Served, served
from tests.machine.bare_machine import MACHINE_FACTS


def begin(folder: Path, monkeypatch: pytest.MonkeyPatch, has: Capabilities) -> Iterator[Served]:
    told = describe(MACHINE_FACTS._replace(capabilities=has))
    monkeypatch.setitem(written_machine.TOLD, DESCRIPTION, told)
    with served(folder) as made:
        about = machine_folder.read(made.site.folder)
        machine = about.machine._replace(is_twin=False)
        machine_folder.write(made.site.folder, about._replace(machine=machine))
        yield made


@pytest.fixture
def bare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    yield from begin(tmp_path, monkeypatch, NOTHING)


@pytest.fixture
def taught(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    """One that a person's own hand moves."""
    yield from begin(tmp_path, monkeypatch, NOTHING._replace(taught_by_hand=True))


def get(console: Served, path: str) -> Any:
    answer = console.client("clinician").get(f"/api/v1{path}")
    assert answer.status_code == 200, answer.text
    return answer.json()


def take(console: Served, step: str) -> tuple[int, str]:
    sent = {"step": step, "version": get(console, "/teaching")["version"], "key": uuid4().hex}
    answer = console.client("clinician").post("/api/v1/teaching", json=sent)
    return answer.status_code, str(answer.json().get("detail"))


def test_it_says_what_the_machine_lacks_and_names_no_twin(bare: Served) -> None:
    told = get(bare, "/machine")
    assert told["capabilities"] == NOTHING._asdict()
    assert told["lacks"] == list(NOTHING.lacking)
    assert told["notice"] == NOT_A_DEVICE
    assert "twin" not in get(bare, "/patient")["fixed"]


def test_a_machine_that_no_hand_moves_is_not_taught(bare: Served) -> None:
    assert get(bare, "/teaching")["steps"] == []
    status, said = take(bare, "prepare")
    assert status == 409
    assert "no hand can move this machine's catheter head" in said


def test_a_person_s_own_hand_teaches_without_a_simulated_one(taught: Served) -> None:
    assert get(taught, "/teaching")["steps"] == ["prepare"]
    assert get(taught, "/teaching")["feels"] is None
    assert get(taught, "/machine")["lacks"] == [
        *("patient monitor", "light barrier at the tube's mouth", "simulated hand"),
        *("truth for a judge", "faults on request"),
    ]


def test_no_simulated_machine_is_identified_in_place_of_a_real_one(bare: Served) -> None:
    sent = {"reason": "a new conduit", "version": 0, "key": uuid4().hex}
    answer = bare.client("engineer").post("/api/v1/identification", json=sent)
    assert answer.status_code == 409, answer.text
    assert "this machine is real" in answer.json()["detail"]
    assert get(bare, "/identification")["runs"] == []


def test_a_controller_of_an_older_version_describes_none_and_its_machine_is_a_twin(
    console: Served,
) -> None:
    assert get(console, "/machine")["capabilities"] == EVERYTHING._asdict()
    assert get(console, "/machine")["lacks"] == []
    assert get(console, "/teaching")["steps"] == ["prepare"]


def test_what_describes_no_machine_is_said_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(written_machine.TOLD, DESCRIPTION, "{")
    with served(tmp_path) as made:
        answer = made.client("clinician").get("/api/v1/machine")
    assert answer.status_code == 503
    assert "does not describe its machine" in answer.json()["detail"]
