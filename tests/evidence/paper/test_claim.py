import math

import pytest

from opensuction.evidence.paper import reproduction
from opensuction.evidence.paper.claim import (
    AGREES,
    ARITHMETIC,
    CALIBRATED,
    COMPUTED,
    DIFFERS,
    NO_EVIDENCE,
    PREDICTED,
    PRINTED,
    PaperClaim,
    judge,
    tally,
)
from opensuction.evidence.paper.paper_contact import ContactRow
from opensuction.evidence.paper.paper_tracking import TrackingRow
from opensuction.evidence.paper.reproduction import Reproduction
from opensuction.report.sheet import Sheet
from opensuction.result.plain import to_json

CLAIM = PaperClaim("a", "Table I", PRINTED, PREDICTED, 2.0, 2.4, 0.2, 0.5, "mm")


def test_within_tolerance_is_ok_on_both_sides() -> None:
    assert CLAIM.ok
    assert CLAIM._replace(measured=1.5).ok
    assert not CLAIM._replace(measured=2.6).ok


def test_what_could_not_be_measured_does_not_hold() -> None:
    assert CLAIM._replace(measured=math.nan).verdict == DIFFERS


@pytest.mark.parametrize(
    ("changes", "verdict", "why"),
    [
        ({}, AGREES, ""),
        # A largest error of 1.34 mm held to 1.5 mm: no error at all would pass.
        ({"paper": 1.34, "measured": 0.4, "tolerance": 1.5}, NO_EVIDENCE, "0 would pass, too"),
        # Nor does a compensator tell anything whose figure the uncompensated machine reaches.
        ({"nulls": (0.0, 2.5)}, NO_EVIDENCE, "2.5 would pass, too"),
        ({"kind": CALIBRATED}, NO_EVIDENCE, "the twin was calibrated to it"),
        ({"kind": ARITHMETIC, "source": COMPUTED}, NO_EVIDENCE, "no twin takes part"),
        ({"measured": 9.0}, DIFFERS, ""),
        ({"measured": 9.0, "kind": CALIBRATED}, DIFFERS, "the twin was calibrated to it"),
    ],
)
def test_verdict(changes: dict[str, object], verdict: str, why: str) -> None:
    claim = CLAIM._replace(**changes)  # type: ignore[arg-type]
    told = to_json(judge(claim))
    assert (claim.verdict, claim.why_no_evidence) == (verdict, why)
    assert told["verdict"] == verdict
    assert told["ok"] is (verdict != DIFFERS)
    assert told["evidence"] is (why == "")


def test_a_difference_is_explained_or_not_and_agreement_needs_no_reason() -> None:
    far = CLAIM._replace(measured=9.0)
    assert far.is_unexplained
    assert not far._replace(explanation="known").is_unexplained
    assert not CLAIM.is_unexplained


def test_no_standard_error_is_none_and_the_tally_counts_each_claim_once() -> None:
    assert to_json(judge(CLAIM._replace(standard_error=math.nan)))["standard_error"] is None
    claims = [CLAIM, CLAIM._replace(kind=CALIBRATED), CLAIM._replace(measured=9.0)]
    assert tally(claims) == {AGREES: 1, NO_EVIDENCE: 1, DIFFERS: 1}


def test_a_claim_and_its_verdict_are_one_object() -> None:
    data = to_json(judge(CLAIM._replace(note="five trials")))
    assert list(data) == [*PaperClaim._fields, "ok", "evidence", "why_no_evidence", "verdict"]
    assert (data["paper"], data["nulls"], data["note"]) == (2.0, [0.0], "five trials")
    assert to_json(judge(CLAIM._replace(measured=math.nan)))["measured"] is None


def test_the_result_of_a_reproduction_has_every_claim_number_and_row() -> None:
    row = TrackingRow(1, 1, 15.413, 15.1, 2.4578, 1.9, 2.7, 0.5, 0.1)
    stop = ContactRow(65.0, 1, 1, 0.1, 65.217, 65.4, 0.4, True)
    page = Sheet("t", "v", True, "l", (), ())
    found = Reproduction([CLAIM, CLAIM._replace(measured=9.0)], (row,), (stop,), page)
    data = to_json(reproduction.to_result(found, 2.5))
    assert [claim["ok"] for claim in data["claims"]] == [True, False]
    assert data["verdicts"] == {AGREES: 1, NO_EVIDENCE: 0, DIFFERS: 1}
    assert data["table1"] == [row._asdict()]
    assert data["table2"] == [stop._asdict()]
    assert data["numbers"] == [number._asdict() for number in reproduction.NUMBERS]
    assert data["wall_s"] == 2.5
