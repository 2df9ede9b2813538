"""Estimates of risk: ordered, checked on loading, and no bolder than what stands behind them."""

from pathlib import Path

import pytest

from opensuction.evidence.safety_case import hazard
from opensuction.evidence.safety_case.hazard_claim import (
    MATRIX,
    PROBABILITY_WORDS,
    SEVERITY_WORDS,
    Acceptability,
    HarmProbability,
    HarmSeverity,
    Hazard,
    rank,
)
from opensuction.kernel.errors import InputError
from tests.evidence.safety_case.hazard_example import FAULT, ROW

RISK = """
[hazard.risk]
probability = "occasional"
residual_severity = "serious"
residual_probability = "remote"
because = "Three means, each of which suffices."
"""
MOST_STEPS = 2
"""Levels by which controls may lower a probability in the project's own table. 20,000 single faults
without a breach bound the share of faults that break something by 1 in 6,700, nearly four levels;
two are kept back for what the twin does not know."""


def loaded(folder: Path, text: str) -> Hazard:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    (one,) = hazard.load(path)
    return one


def test_an_estimate_is_read_and_may_be_left_out(tmp_path: Path) -> None:
    risk = loaded(tmp_path, ROW + RISK + FAULT).risk
    assert risk is not None
    assert risk.probability == HarmProbability.OCCASIONAL
    assert risk.residual_severity == HarmSeverity.SERIOUS
    assert loaded(tmp_path, ROW + FAULT).risk is None


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"remote"', '"rare"', ("residual_probability", "rare", "remote")),
        ('"remote"', '"frequent"', ("residual_probability", "frequent", "above", "occasional")),
        ('"remote"', '"occasional"', ("residual_probability", "as before")),
        ('residual_severity = "serious"', 'residual_severity = "critical"', ("above 'serious'",)),
        ('probability = "occasional"\n', "", ("probability is missing",)),
        ("because", "why", ("unknown key why", "because")),
        ("Three means, each of which suffices.", " ", ("because: is empty",)),
        ("[hazard.risk]", "[[hazard.risk]]", ("not a section",)),
    ],
)
def test_a_bad_estimate_is_refused_in_one_line(
    tmp_path: Path, old: str, new: str, words: tuple[str, ...]
) -> None:
    with pytest.raises(InputError) as refused:
        loaded(tmp_path, ROW + RISK.replace(old, new, 1) + FAULT)
    message = str(refused.value)
    assert "\n" not in message
    for word in ("mine.toml: OS-H01, risk", *words):
        assert word in message


def test_what_nothing_measures_is_not_claimed_to_be_controlled(tmp_path: Path) -> None:
    blind = FAULT + 'response = "not-measured"\nalarm = []\npriority = "none"\n'
    with pytest.raises(InputError, match=r"OS-H01, risk: .*nothing measures.*pump-runaway"):
        loaded(tmp_path, ROW + RISK + blind)


def test_worse_is_never_more_acceptable() -> None:
    for severity, row in MATRIX.items():
        ranks = [rank(row[probability]) for probability in HarmProbability]
        assert ranks == sorted(ranks), severity
    for probability in HarmProbability:
        ranks = [rank(MATRIX[severity][probability]) for severity in HarmSeverity]
        assert ranks == sorted(ranks), probability
    assert MATRIX[HarmSeverity.CRITICAL][HarmProbability.IMPROBABLE] != Acceptability.ACCEPTABLE


def test_every_level_is_explained() -> None:
    assert list(SEVERITY_WORDS) == list(HarmSeverity)
    assert list(PROBABILITY_WORDS) == list(HarmProbability)


def test_every_hazard_of_the_project_is_estimated_and_no_control_does_wonders() -> None:
    for one in hazard.load():
        risk = one.risk
        assert risk is not None, one.row.id
        assert len(risk.because) > 40, one.row.id
        assert rank(risk.probability) - rank(risk.residual_probability) <= MOST_STEPS, one.row.id
        lowered = rank(one.row.severity) - rank(risk.residual_severity)
        assert lowered <= 1, one.row.id
