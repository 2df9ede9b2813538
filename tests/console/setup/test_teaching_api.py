"""The travel length taught on a machine that runs, by the twin's hand; and its catheter changed."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest

from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.runtime import machine_folder
from tests.console.setup.bed import Bed, bed, until
from tests.runtime.machine_room import wait

pytestmark = pytest.mark.real_time


@pytest.fixture(scope="module")
def at_bed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bed]:
    with bed(Path(tmp_path_factory.mktemp("bed"))) as made:
        yield made


def step(at_bed: Bed, name: str, role: str | None = "clinician") -> Any:
    version = at_bed.get("/teaching")["version"]
    sent = {"step": name, "version": version, "key": uuid4().hex}
    return at_bed.client(role).post("/api/v1/teaching", json=sent)


def done(at_bed: Bed, name: str) -> dict[str, Any]:
    answer = step(at_bed, name)
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def stage(at_bed: Bed) -> str:
    return str(at_bed.get("/teaching", None)["stage"])


def push_until(at_bed: Bed, there: Callable[[], bool]) -> None:
    """A hand pushes until it is so far."""
    at_bed.settle()
    done(at_bed, "begin")
    until(lambda: stage(at_bed) == "moving")
    done(at_bed, "push")
    until(lambda: there() or at_bed.room.phase() in RESTING, 40.0)
    assert at_bed.room.phase() == Phase.TEACHING, at_bed.room.state()


def press(at_bed: Bed, *buttons: str) -> None:
    at_bed.room.press(*buttons)


@pytest.mark.sweep
def test_step_by_step_the_carina_is_taught_and_the_protocol_fits_it(at_bed: Bed) -> None:
    before = at_bed.get("/protocol")
    assert at_bed.get("/teaching", None)["steps"] == ["prepare"]
    assert step(at_bed, "begin").status_code == 409
    assert step(at_bed, "prepare", "engineer").status_code == 403
    done(at_bed, "prepare")
    at_bed.settle()
    assert stage(at_bed) == "prepared"
    assert at_bed.get("/protocol")["is_teaching"]
    # No cycle starts with the limits that a person teaches with.
    press(at_bed, "start")
    until(lambda: at_bed.room.now("outputs.counters.refusal") == Refusal.NOT_TAUGHT)
    push_until(at_bed, lambda: at_bed.room.truth("truth.contact_n") > 0.05)
    held_mm = at_bed.room.truth("truth.tip_mm")
    taught = done(at_bed, "confirm")
    until(lambda: at_bed.get("/teaching")["result"] == "taken")
    taught = at_bed.get("/teaching")
    assert abs(taught["taught_mm"] - held_mm) < 3.0
    assert taught["least_mm"] <= taught["taught_mm"] <= taught["most_mm"]
    # The simulated hand draws back by itself then.
    until(lambda: at_bed.room.phase() in RESTING, 40.0)
    until(lambda: stage(at_bed) == "taught")
    assert at_bed.room.phase() == Phase.PARKED
    presets = at_bed.get("/protocol")["presets"]
    fitted = next(
        one for one in presets if (one["approach"], one["carina"]) == ("travel", "taught")
    )
    assert fitted["carina_mm"] == taught["taught_mm"]
    at_bed.settle()
    done(at_bed, "take")
    at_bed.settle()
    assert stage(at_bed) == "idle"
    after = at_bed.get("/protocol")
    assert after["carina_mm"] == taught["taught_mm"]
    assert after["protocol"] == fitted["protocol"]
    assert after["taught_by"].startswith("taught by ")
    assert after["version"] == before["version"] + 2
    whats = [what for _, what, _ in at_bed.actions()]
    assert whats[:2] == ["take-taught-length", "prepare-teaching"]
    assert machine_folder.read(at_bed.site.folder).protocol.name == "paediatric"
    press(at_bed, "oxygen_skipped", "start")
    until(lambda: at_bed.room.phase() == Phase.CHECKING)
    press(at_bed, "abort")
    until(lambda: at_bed.room.phase() in (Phase.HALTED, Phase.PARKED))
    press(at_bed, "reset")
    until(lambda: at_bed.room.phase() == Phase.PARKED)


def test_stopped_while_a_hand_pushes_it_comes_out_and_what_was_before_can_be_set_again(
    at_bed: Bed,
) -> None:
    at_bed.settle()
    before = at_bed.get("/protocol")
    done(at_bed, "prepare")
    at_bed.settle()
    push_until(at_bed, lambda: bool(at_bed.get("/teaching")["is_away"]))
    press(at_bed, "abort")
    until(lambda: at_bed.room.phase() == Phase.HALTED, 30.0)
    assert at_bed.room.is_out()
    # Its drive is off now, and no hand takes that for another invitation.
    assert not wait(lambda: not at_bed.room.is_out(), 3.0)
    assert stage(at_bed) == "busy"
    assert step(at_bed, "take").status_code == 409
    press(at_bed, "reset")
    at_bed.settle()
    assert stage(at_bed) == "prepared"
    done(at_bed, "leave")
    at_bed.settle()
    after = at_bed.get("/protocol")
    for name in ("protocol", "carina_mm", "name", "approach"):
        assert after[name] == before[name]
    assert not after["is_teaching"]


def test_the_drive_brings_a_head_home_that_a_hand_has_let_go(at_bed: Bed) -> None:
    at_bed.settle()
    done(at_bed, "prepare")
    at_bed.settle()
    push_until(at_bed, lambda: bool(at_bed.get("/teaching")["is_away"]))
    done(at_bed, "home")
    until(lambda: stage(at_bed) == "prepared", 40.0)
    assert at_bed.room.is_out()
    done(at_bed, "leave")


def test_a_catheter_is_changed_out_of_service_and_its_day_begins_anew(at_bed: Bed) -> None:
    at_bed.settle()
    room, client = at_bed.room, at_bed.client("clinician")
    sent = {"label": "C-0099", "key": uuid4().hex}
    assert client.put("/api/v1/catheter", json=sent).status_code == 409
    press(at_bed, "service")
    until(lambda: room.phase() == Phase.OUT_OF_SERVICE)
    before = at_bed.get("/catheter", None)
    assert before["is_out_of_service"]
    old = client.put("/api/v1/catheter", json={**sent, "label": before["label"]})
    assert old.status_code == 409
    assert old.json()["errors"][0]["field"] == "label"
    assert at_bed.client("observer").put("/api/v1/catheter", json=sent).status_code == 403
    answer = client.put("/api/v1/catheter", json=sent)
    assert answer.status_code == 200, answer.text
    after = answer.json()
    assert after["label"] == "C-0099"
    assert after["left_s"] > after["life_s"] - 5.0
    assert after["left_s"] > before["left_s"]
    assert machine_folder.read(at_bed.site.folder).catheter.label == "C-0099"
    assert at_bed.actions()[0][1:] == ("change-catheter", "c-1 -> C-0099, 6 Fr")
    press(at_bed, "return_to_service")
    until(lambda: room.phase() == Phase.PARKED)
