"""The hazard table: read whole, or refused in one line that names row and field."""

from pathlib import Path

import pytest

from opensuction.evidence.safety_case import hazard, hazard_case
from opensuction.evidence.safety_case.hazard import Response
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.safety.priority import Priority
from tests.evidence.safety_case.hazard_example import FAULT, ROW, WEAK

SOUND = ROW + FAULT + WEAK


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_fault_inherits_what_its_row_demands_and_may_demand_its_own(tmp_path: Path) -> None:
    (one,) = hazard.load(written(tmp_path, SOUND))
    runaway, weak = one.claims
    assert (runaway.detected_ms, weak.detected_ms) == (2000.0, 500.0)
    assert runaway.safe_ms == weak.safe_ms == 10000.0
    assert runaway.priority == Priority.HIGH
    assert runaway.response == Response.ALARM


def test_every_strength_phase_instant_and_seed_is_a_run(tmp_path: Path) -> None:
    text = SOUND.replace("strengths = [0.7]", "strengths = [0.7, 0.9]\nafter_s = [0.1, 0.3]")
    text = text.replace('phases = ["closing"]', 'phases = ["all"]')
    (one,) = hazard.load(written(tmp_path, text))
    found = hazard_case.cases(one, (1, 2, 3))
    weak = [case for case in found if case.claim.name == "pump-weak"]
    assert len(weak) == 2 * 7 * 2 * 3
    assert len({case.title for case in weak}) == len(weak)
    assert len(found) == len(weak) + 3
    assert {case.phase for case in weak} >= {Phase.CHECKING, Phase.CLOSING}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('cause = "Pump runs away"\n', "", ("hazard 1", "cause")),
        ("detected_ms = 2000\n", "", ("OS-H01, fault 1", "detected_ms")),
        ("safe_ms = 10000", "safe_ms = -1", ("OS-H01, fault 1", "safe_ms", "0")),
        ("safe_ms = 10000", "safe_ms = nan", ("OS-H01, fault 1", "safe_ms", "finite")),
        ("pump-runaway", "pump-runawy", ("OS-H01, fault 1", "pump-runawy", "pump-runaway")),
        ("VACUUM_EXCEEDED", "VACUUM_HIGH", ("OS-H01, fault 1", "alarm", "VACUUM_HIGH")),
        ('priority = "high"', 'priority = "medium"', ("OS-H01, fault 1", "priority", "high")),
        ("[0.7]", "[1.7]", ("OS-H01, fault 2", "1.7", "pump-weak")),
        ('["opening"]', '["backing_off"]', ("OS-H01, fault 1", "backing_off", "travel")),
        ('["opening"]', '["set-up"]', ("OS-H01, fault 1", "set-up", "impossible")),
        ('["opening"]', "[]", ("OS-H01, fault 1", "phases")),
        ('"serious"', '"bad"', ("hazard 1", "severity", "bad")),
        ("out-without-suction", "fine", ("OS-H01, fault 1", "safe_state", "fine")),
        ('"OS-R07"', '"OS-R99"', ("OS-H01", "requirements", "OS-R99")),
        ("because", "why", ("OS-H01", "because")),
        ("name = ", "fault = ", ("OS-H01, fault 1", "fault")),
        ("phases = ", "phase = ", ("OS-H01, fault 1", "phase")),
        ('"OS-H01"', "7", ("hazard 1", "id")),
        ("[[hazard]]", "[[hazards]]", ("hazards",)),
    ],
)
def test_a_bad_table_is_refused_in_one_line(
    tmp_path: Path, old: str, new: str, words: tuple[str, ...]
) -> None:
    text = SOUND if old != "[[hazard]]" else "[[hazards]]\n"
    path = written(tmp_path, text.replace(old, new, 1))
    with pytest.raises(InputError) as refused:
        hazard.load(path)
    message = str(refused.value)
    assert "\n" not in message
    assert str(path) in message
    for word in words:
        assert word in message


def test_an_identifier_twice_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"OS-H01.*2 times"):
        hazard.load(written(tmp_path, SOUND + SOUND))


def test_a_row_without_a_fault_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="OS-H01: fault: none given"):
        hazard.load(written(tmp_path, ROW))


def test_every_row_of_the_projects_own_table_argues_its_bounds() -> None:
    for one in hazard.load():
        for claim in one.claims:
            assert len(claim.because) > 10, (one.row.id, claim.name)
            assert claim.detected_ms <= max(claim.safe_ms, 30000.0)
