"""An identification of the machine's kind beside the machine that runs, accepted by an engineer."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest

from opensuction.controller import configuration
from opensuction.kernel.vocabulary import RESTING
from opensuction.runtime import machine_folder
from opensuction.runtime.machine_folder import CONFIGURATION
from opensuction.session.running import basis
from tests.console.setup.bed import Bed, bed, until

pytestmark = pytest.mark.real_time

PATH = "/api/v1/identification"
TAKES_S = 400.0
"""At the lowest priority, on a computer that is busy."""


@pytest.fixture(scope="module")
def at_bed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bed]:
    with bed(Path(tmp_path_factory.mktemp("bed"))) as made:
        yield made


def sent(reason: str, version: int = 0) -> dict[str, Any]:
    return {"reason": reason, "version": version, "key": uuid4().hex}


@pytest.mark.sweep
def test_found_beside_the_machine_and_accepted_with_a_reason(at_bed: Bed) -> None:
    engineer = at_bed.client("engineer")
    assert at_bed.client("clinician").post(PATH, json=sent("new")).status_code == 403
    assert engineer.post(PATH, json=sent("")).status_code == 422
    begun = engineer.post(PATH, json=sent("a new conduit"))
    assert begun.status_code == 202, begun.text
    assert engineer.post(PATH, json=sent("twice")).status_code == 409
    run = begun.json()["id"]
    early = engineer.post(f"{PATH}/{run}/accept", json=sent("now"))
    assert early.status_code == 409
    until(lambda: at_bed.get(f"/identification/{run}")["state"] != "running", TAKES_S)
    found = at_bed.get(f"/identification/{run}")
    assert found["state"] == "found", found["detail"]
    assert "nothing was measured on it" in found["measured"]
    assert 0.6 < found["result"]["gap_ratio"] < 1.4
    loop = found["loop"]
    assert len(loop["head"]) == len(loop["tip"]) == len(loop["inward"]) > 100
    assert {0, 1} <= set(loop["inward"])
    before = configuration.from_json((at_bed.site.folder / CONFIGURATION).read_text())
    version = at_bed.get("/identification")["version"]
    stale = engineer.post(f"{PATH}/{run}/accept", json=sent("better", version + 7))
    assert stale.status_code == 409
    taken = engineer.post(f"{PATH}/{run}/accept", json=sent("better", version))
    assert taken.status_code == 200, taken.text
    after = configuration.from_json((at_bed.site.folder / CONFIGURATION).read_text())
    assert after.settings.compensation.model != before.settings.compensation.model
    parameters = machine_folder.read(at_bed.site.folder).parameter_file
    assert parameters is not None
    assert parameters.name == f"calibration-{run}.toml"
    assert basis.read(at_bed.site.folder).calibrated_by == f"accepted {parameters.name}"
    _, what, detail = at_bed.actions()[0]
    assert what == "accept-calibration"
    assert parameters.sha256 in detail
    assert detail.endswith("reason: better")
    # Where the new model parks the head elsewhere, the machine takes it out and waits for a person.
    until(lambda: at_bed.room.phase() in RESTING)
    assert at_bed.room.is_out()
    again = engineer.post(f"{PATH}/{run}/accept", json=sent("again", version + 1))
    assert again.status_code == 409


def test_what_is_not_there_is_not_found(at_bed: Bed) -> None:
    assert at_bed.client("engineer").get(f"{PATH}/nothing").status_code == 404
    assert at_bed.client(None).get(PATH).status_code == 401
