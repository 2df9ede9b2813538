"""The protocol on a machine that runs: shown, planned, set, refused, on record."""

import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from opensuction.controller import configuration
from opensuction.runtime import machine_folder
from opensuction.runtime.machine_folder import CONFIGURATION
from opensuction.session.running import basis
from tests.console.setup.bed import Bed, bed, until

pytestmark = pytest.mark.real_time


@pytest.fixture(scope="module")
def at_bed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bed]:
    with bed(Path(tmp_path_factory.mktemp("bed"))) as made:
        yield made


@pytest.fixture
def key(request: pytest.FixtureRequest) -> str:
    return f"key-{zlib.crc32(request.node.name.encode()):010d}"


def body(shown: dict[str, Any], key: str, **changed: float) -> dict[str, Any]:
    return {
        "approach": shown["approach"],
        "protocol": {**shown["protocol"], **changed},
        "version": shown["version"],
        "key": key,
    }


def put(at_bed: Bed, role: str | None, sent: dict[str, Any]) -> Any:
    return at_bed.client(role).put("/api/v1/protocol", json=sent)


def in_force(at_bed: Bed) -> configuration.Configuration:
    text = (at_bed.site.folder / CONFIGURATION).read_text(encoding="utf-8")
    return configuration.from_json(text)


def test_every_field_has_unit_range_meaning_and_source_and_the_plan_is_that_in_force(
    at_bed: Bed,
) -> None:
    shown = at_bed.get("/protocol", None)
    for one in shown["fields"]:
        assert one["meaning"]
        assert one["default_source"]
        assert one["unit"] in ("mm", "mm/s", "s", "mmHg")
        assert one["least"] < one["most"]
        assert one["least"] <= shown["protocol"][one["name"]] <= one["most"]
    assert {one["name"] for one in shown["fields"]} == set(shown["protocol"])
    plan = in_force(at_bed).settings.plan
    assert shown["protocol"]["travel_mm"] == plan.motion.target_mm
    assert shown["plan"]["times_s"]["dwell"] == plan.dwell_s
    assert shown["may_change_now"]
    assert all(one["ok"] for one in shown["plan"]["guidelines"])
    ages = {one["age"]: one for one in at_bed.get("/guidelines", None)}
    assert ages["neonate"]["is_patients"]
    assert not ages["adult"]["is_patients"]


def test_a_clinician_sets_a_weaker_vacuum_and_machine_records_and_names_go_with_it(
    at_bed: Bed, key: str
) -> None:
    shown = at_bed.get("/protocol")
    before = in_force(at_bed)
    answer = put(at_bed, "clinician", body(shown, key, vacuum_mmhg=70.0))
    assert answer.status_code == 200, answer.text
    after = in_force(at_bed)
    assert after.settings.plan.vacuum_mmhg == 70.0
    assert after.settings.service == before.settings.service
    told = machine_folder.read(at_bed.site.folder)
    assert told.protocol.name == "paediatric, changed"
    assert '"vacuum_mmhg": 70.0' in told.protocol.content
    assert told.heading["protocol"] == "paediatric, changed"
    now = answer.json()
    assert now["version"] == shown["version"] + 1
    assert now["name"] == "paediatric, changed"
    assert basis.read(at_bed.site.folder).protocol.vacuum_mmhg == 70.0
    done = at_bed.actions()[0]
    assert done[1:] == ("choose-protocol", "paediatric, changed: vacuum_mmhg 80 -> 70")
    until(lambda: at_bed.room.now("outputs.phase") == 0.0)


def test_the_later_of_two_is_told_that_somebody_else_has_changed_it(at_bed: Bed, key: str) -> None:
    shown = at_bed.get("/protocol")
    assert put(at_bed, "clinician", body(shown, key, vacuum_mmhg=72.0)).status_code == 200
    late = put(at_bed, "clinician", body(shown, f"{key}-2", vacuum_mmhg=75.0))
    assert late.status_code == 409
    assert late.json()["errors"][0]["field"] == "version"
    assert in_force(at_bed).settings.plan.vacuum_mmhg == 72.0


def test_a_limit_is_an_engineers_with_a_reason_and_nobody_passes_a_guideline(
    at_bed: Bed, key: str
) -> None:
    shown = at_bed.get("/protocol")
    tighter = shown["protocol"]["in_airway_budget_s"] + 1.0
    sent = body(shown, key, in_airway_budget_s=tighter)
    assert put(at_bed, None, sent).status_code == 401
    assert put(at_bed, "observer", sent).status_code == 403
    assert put(at_bed, "clinician", sent).status_code == 403
    without = put(at_bed, "engineer", sent)
    assert without.status_code == 422
    assert without.json()["errors"][0]["field"] == "reason"
    therapy = put(at_bed, "engineer", body(shown, f"{key}-t", vacuum_mmhg=77.0) | {"reason": "x"})
    assert therapy.status_code == 403
    answer = put(at_bed, "engineer", {**sent, "reason": "a slow valve"})
    assert answer.status_code == 200, answer.text
    assert in_force(at_bed).settings.limits.in_airway_s == tighter
    _, what, detail = at_bed.actions()[0]
    assert what == "change-limits"
    assert detail.endswith("reason: a slow valve")
    shown = at_bed.get("/protocol")
    beyond = put(
        at_bed, "engineer", body(shown, f"{key}-b", in_airway_budget_s=40.0) | {"reason": "why not"}
    )
    assert beyond.status_code == 422
    assert beyond.json()["errors"][0]["field"] == "in_airway_budget_s"
    assert in_force(at_bed).settings.limits.in_airway_s == tighter


def test_what_cannot_be_is_refused_beside_its_field_and_nothing_is_changed(
    at_bed: Bed, key: str
) -> None:
    shown, before = at_bed.get("/protocol"), in_force(at_bed)
    sent = body(shown, key, vacuum_mmhg=149.0, cap_mm=1.0)
    answer = put(at_bed, "clinician", sent)
    assert answer.status_code == 422
    errors = {one["field"]: one["detail"] for one in answer.json()["errors"]}
    assert "set cap_mm to" in errors["cap_mm"]
    assert "100 mmHg" in errors["vacuum_mmhg"]
    assert in_force(at_bed) == before
    plan = at_bed.client("clinician").post(
        "/api/v1/protocol/plan", json={"approach": "travel", "protocol": sent["protocol"]}
    )
    assert plan.status_code == 200
    assert {one["field"] for one in plan.json()["refused"]} == set(errors)


def test_nothing_is_set_while_the_machine_is_at_work(at_bed: Bed, key: str) -> None:
    shown = at_bed.get("/protocol")
    at_bed.room.begin_cycle()
    answer = put(at_bed, "clinician", body(shown, key, vacuum_mmhg=76.0))
    assert answer.status_code == 409
    assert "only while the machine is parked" in answer.json()["detail"]
    assert not at_bed.get("/protocol")["may_change_now"]
    at_bed.room.press("abort")
    until(lambda: at_bed.get("/protocol")["phase"] in ("halted", "parked"))
    at_bed.room.press("reset")
    until(lambda: at_bed.get("/protocol")["may_change_now"])


def test_the_clinical_protocol_is_one_press_away_and_has_its_own_name_again(
    at_bed: Bed, key: str
) -> None:
    shown = at_bed.get("/protocol")
    fitted = next(one for one in shown["presets"] if one["approach"] == "travel")
    sent = {**body(shown, key), "protocol": fitted["protocol"], "approach": "travel"}
    answer = put(at_bed, "clinician", sent)
    assert answer.status_code == 200, answer.text
    assert answer.json()["name"] == "paediatric"
    again = put(at_bed, "clinician", {**sent, "version": answer.json()["version"], "key": key * 2})
    assert again.status_code == 409


def test_the_twins_patient_gets_another_pseudonym_and_no_other_body(at_bed: Bed, key: str) -> None:
    shown = at_bed.get("/patient", None)
    assert shown["age"] == "neonate"
    client = at_bed.client("clinician")
    sent = {"pseudonym": "P-0042", "version": shown["version"], "key": key}
    other = client.put("/api/v1/patient", json={**sent, "age": "adult"})
    assert other.status_code == 409
    assert "opensuction serve --patient" in other.json()["detail"]
    name = client.put("/api/v1/patient", json={**sent, "pseudonym": "Mr Smith"})
    assert name.status_code == 422
    assert name.json()["errors"][0]["field"] == "pseudonym"
    assert at_bed.client("engineer").put("/api/v1/patient", json=sent).status_code == 403
    assert client.put("/api/v1/patient", json=sent).status_code == 200
    assert machine_folder.read(at_bed.site.folder).patient == "P-0042"
    assert at_bed.actions()[0][1:] == ("choose-patient", "pseudonym P-1 -> P-0042")
