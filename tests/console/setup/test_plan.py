"""Whatever is drafted: the planner's word or the reasons why not, and never a failure."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from starlette.testclient import TestClient

from opensuction.console.guard.limits import UNHURRIED
from opensuction.console.setup import draft
from opensuction.controller import setup
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning.protocol import Protocol
from opensuction.session.running import basis
from tests.console.served import served
from tests.session.running.test_basis import at_bed

ADULT = at_bed()
NAMES = [one.name for one in draft.fields()]
PRESENT = {name: getattr(ADULT.protocol, name) for name in NAMES}
ANYTHING = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.floats(0.0, 150.0),
    st.text(max_size=64),
    st.sampled_from([10**400, -(10**400), 5e-324, 1e308]),
)
IN_RANGE = st.fixed_dictionaries(
    {one.name: st.floats(one.least, one.most, exclude_min=one.is_above) for one in draft.fields()}
)
NEARBY = st.fixed_dictionaries(
    {
        name: st.one_of(st.just(value), st.floats(0.8 * value, 1.2 * value + 0.1))
        for name, value in PRESENT.items()
    }
)
ODD = st.dictionaries(st.sampled_from([*NAMES, "bench_only", "x", ""]), ANYTHING, max_size=16)
DRAFTS = st.one_of(NEARBY, IN_RANGE, ODD, ODD.map(lambda odd: {**PRESENT, **odd}))


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with served(Path(tmp_path_factory.mktemp("console")), limits=UNHURRIED) as made:
        basis.write(made.site.folder, ADULT)
        with made.client("clinician") as found:
            yield found


def plan(client: TestClient, protocol: dict[str, Any], approach: str) -> Any:
    content = json.dumps({"approach": approach, "protocol": protocol})
    headers = {"Content-Type": "application/json"}
    while True:
        answer = client.post("/api/v1/protocol/plan", content=content, headers=headers)
        if answer.status_code != 429:
            return answer


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(protocol=DRAFTS, approach=st.sampled_from(["travel", "contact"]))
def test_every_draft_has_a_plan_or_refusals_that_name_their_fields(
    client: TestClient, protocol: dict[str, Any], approach: str
) -> None:
    answer = plan(client, protocol, approach)
    if answer.status_code == 422:  # no form would send it: a text of a number that is none
        assert answer.json()["errors"]
        return
    assert answer.status_code == 200, answer.text
    found = json.loads(answer.text, parse_constant=pytest.fail)
    assert found["refused"] or found["plan"]
    for one in found["refused"]:
        assert one["field"] in (*NAMES, "bench_only", "") or one["field"] in protocol
        assert one["sentence"]
        assert "\n" not in one["sentence"]


@given(protocol=st.one_of(NEARBY, IN_RANGE), by_contact=st.booleans())
def test_what_is_not_refused_makes_settings_and_what_is_would_have_been_dangerous(
    protocol: dict[str, float], by_contact: bool
) -> None:
    found = draft.read(protocol, by_contact, ADULT.site, bench_only=False)
    if draft.judge(ADULT, found):
        return
    assert found.protocol is not None
    made = setup.settings(
        ADULT.profile,
        found.protocol,
        ADULT.compensation,
        ADULT.calibration,
        by_contact,
        ADULT.site,
    )
    assert made.limits.cap_mm <= ADULT.site.carina_mm + (13.0 if by_contact else 0.0)
    assert made.limits.in_airway_s <= 30.0
    assert found.protocol.negative_pressure_budget_s <= 15.0
    assert found.protocol.vacuum_mmhg <= 150.0


@given(protocol=IN_RANGE)
def test_a_draft_is_refused_wherever_the_settings_are(protocol: dict[str, float]) -> None:
    found = draft.read(protocol, False, ADULT.site, bench_only=False)
    assert isinstance(found.protocol, Protocol)
    try:
        setup.plan_settings(
            ADULT.profile, found.protocol, ADULT.compensation, ADULT.calibration, False, ADULT.site
        )
    except InputError:
        assert draft.judge(ADULT, found)


def test_the_present_protocol_is_refused_nothing_and_a_wrong_number_says_its_range() -> None:
    assert not draft.judge(ADULT, draft.read(PRESENT, False, ADULT.site, bench_only=False))
    for value, words in (
        (math.nan, "not a finite number"),
        (500.0, "above the limit of 150 mmHg"),
        ("strong", "not a number"),
        (None, "missing"),
    ):
        given_ = {**PRESENT, "vacuum_mmhg": value}
        (one,) = draft.read(given_, False, ADULT.site, bench_only=False).refused
        assert one.field == "vacuum_mmhg"
        assert words in one.sentence
        assert "at least 20 and at most 150" in one.sentence


def test_nobody_plans_without_signing_in_and_no_other_shape_is_taken(client: TestClient) -> None:
    good: dict[str, Any] = {"approach": "travel", "protocol": PRESENT}
    others: tuple[Any, ...] = (
        {**good, "approach": "guess"},
        {**good, "more": 1},
        {**good, "protocol": {f"f{i}": 1.0 for i in range(40)}},
        {**good, "protocol": {"vacuum_mmhg": [1]}},
        {"approach": "travel"},
        [],
    )
    for wrong in others:
        assert client.post("/api/v1/protocol/plan", json=wrong).status_code == 422
    taught = client.post("/api/v1/protocol/plan", json={**good, "carina": "taught"})
    assert taught.status_code == 409
    assert client.get("/api/v1/protocol").status_code == 200
    client.cookies.clear()
    assert client.post("/api/v1/protocol/plan", json=good).status_code == 401
