import math

import pytest

from opensuction.evidence.paper.claim import PaperClaim, plain

CLAIM = PaperClaim("a", "Table I", 2.0, 2.4, 0.5, "mm", "predicted")


def test_within_tolerance_is_ok_on_both_sides() -> None:
    assert CLAIM.ok
    assert CLAIM._replace(measured=1.5).ok
    assert not CLAIM._replace(measured=2.6).ok


def test_what_could_not_be_measured_does_not_hold() -> None:
    assert not CLAIM._replace(measured=math.nan).ok


@pytest.mark.parametrize(
    ("measured", "explanation", "verdict"),
    [(2.4, "", "ok"), (2.4, "needless", "ok"), (9.0, "known", "explained"), (9.0, "", "differs")],
)
def test_verdict(measured: float, explanation: str, verdict: str) -> None:
    claim = CLAIM._replace(measured=measured, explanation=explanation)
    assert claim.verdict == verdict
    assert plain(claim)["verdict"] == verdict
    assert plain(claim)["ok"] == (verdict == "ok")
