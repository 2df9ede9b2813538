"""The hazard table: read whole, or refused in one line that names row and field."""

import re
from pathlib import Path

import pytest

import opensuction
from opensuction.evidence.safety_case import hazard, hazard_case
from opensuction.evidence.safety_case.hazard_case import KINDS, STRATA
from opensuction.evidence.safety_case.hazard_claim import PHASES, UNHEARD, Hazard, Response
from opensuction.kernel.errors import InputError
from opensuction.safety.condition import Condition
from opensuction.safety.handling import Priority
from tests.evidence.safety_case.hazard_example import FAULT, ROW, WEAK

SOUND = ROW + FAULT + WEAK
SOURCES = Path(opensuction.__file__).parent


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


def test_a_fault_comes_on_every_patient_by_both_approaches_where_nothing_else_is_said(
    tmp_path: Path,
) -> None:
    text = SOUND.replace("strengths = [0.7]", "strengths = [0.7, 0.9]\nafter_s = [0.1, 0.3]")
    (one,) = hazard.load(written(tmp_path, text))
    found = hazard_case.cases(one, (1, 2, 3))
    weak = [case for case in found if case.claim.name == "pump-weak"]
    assert len(weak) == 4 * 2 * 2 * 2 * 3
    assert len({case.title for case in weak}) == len(weak)
    assert len(found) == len(weak) + 4 * 2 * 3
    assert {(case.patient, case.approach) for case in found} == set(KINDS)


def test_strengths_take_turns_where_each_meets_every_part_of_the_span_all_the_same() -> None:
    """Of five seeds on all patients; with fewer runs every strength is run in each."""
    for one in hazard.load():
        for claim in one.claims:
            strengths = claim.strengths or [0.0]
            if len(strengths) == 1 or len(claim.patients) * len(claim.approaches) < len(KINDS):
                continue
            whole = hazard_case.cases(Hazard(one.row, (claim,)), (1, 2, 3, 4, 5))
            for span in {case.span for case in whole} - {"backing_off"}:
                found = [case for case in whole if case.span == span]
                assert len(found) == 40
                parts = {(case.strength, int(STRATA * case.share * 0.999)) for case in found}
                assert len(parts) == STRATA * len(strengths)
            quick = hazard_case.cases(Hazard(one.row, (claim,)), (1,))
            assert len(quick) == len(strengths) * len(
                {(one.patient, one.approach, one.span) for one in quick}
            )


def test_all_is_every_phase_that_an_approach_has(tmp_path: Path) -> None:
    (one,) = hazard.load(written(tmp_path, SOUND.replace('["closing"]', '["all"]')))
    found = [case for case in hazard_case.cases(one, (1,)) if case.claim.name == "pump-weak"]
    assert len(found) == 4 * (7 + 8)
    by_travel = {case.span for case in found if case.approach == "travel"}
    assert by_travel == set(PHASES["contact"]) - {"backing_off"}


def test_a_row_may_be_for_some_and_says_why(tmp_path: Path) -> None:
    text = SOUND.replace(
        'phases = ["closing"]',
        'patient = ["neonate", "child-10kg"]\n'
        'approach = "contact"\nonly_because = "they are small"',
    )
    (one,) = hazard.load(written(tmp_path, text))
    found = [case for case in hazard_case.cases(one, (1,)) if case.claim.name == "pump-weak"]
    assert {(case.patient, case.approach) for case in found} == {
        ("neonate", "contact"),
        ("child-10kg", "contact"),
    }
    assert {case.span for case in found} == {"airway"}


def test_five_seeds_see_every_part_of_the_time_inside_on_every_patient() -> None:
    """A Latin square with both edges, whichever row of a table it is."""
    for row in range(7):
        shares = {}
        for patient, approach in KINDS:
            shares[patient, approach] = [
                hazard_case.find_share(patient, approach, seed, row) for seed in range(1, 6)
            ]
            parts = {min(int(STRATA * share), STRATA - 1) for share in shares[patient, approach]}
            assert parts == set(range(STRATA))
        every = [share for found in shares.values() for share in found]
        assert len(set(every)) == len(every) == 40
        assert (min(every), max(every)) == (0.0, 1.0)
        for seed in range(5):
            parts = {int(STRATA * found[seed] * 0.999) for found in shares.values()}
            assert parts == set(range(STRATA))


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
        (
            '["inserting"]',
            '["backing_off"]\napproach = "travel"\nonly_because = "so"',
            ("OS-H01, fault 1", "backing_off", "travel"),
        ),
        ('["inserting"]', '["set-up"]', ("OS-H01, fault 1", "set-up", "impossible")),
        ('["inserting"]', "[]", ("OS-H01, fault 1", "phases")),
        ('"serious"', '"bad"', ("hazard 1", "severity", "bad")),
        ("out-without-suction", "fine", ("OS-H01, fault 1", "safe_state", "fine")),
        ('"OS-R07"', '"OS-R99"', ("OS-H01", "requirements", "OS-R99")),
        ("because", "why", ("OS-H01", "because")),
        ("name = ", "fault = ", ("OS-H01, fault 1", "fault")),
        ("phases = ", "phase = ", ("OS-H01, fault 1", "phase")),
        ('"OS-H01"', "7", ("hazard 1", "id")),
        ("[[hazard]]", "[[hazards]]", ("hazards",)),
        ("safe_ms = 10000", "safe_ms = 60001", ("OS-H01, fault 1", "safe_ms", "60000")),
        ("out-without-suction", "still-without-suction", ("OS-H01, fault 1", "safe_state")),
        ('["inserting"]', '["airway"]\nafter_s = [1.0]', ("OS-H01, fault 1", "after_s")),
        ('["inserting"]', '["opening"]\npatient = "dog"', ("OS-H01, fault 1", "patient", "dog")),
        ('["inserting"]', '["opening"]\npatient = "neonate"', ("OS-H01, fault 1", "only_because")),
        ('"OS-H01"', '""', ("hazard 1", "id", "empty")),
        ('["OS-R07"]', "[]", ("hazard 1", "requirements", "empty")),
        ('["inserting"]', '["opening"]\nshows = "now"', ("OS-H01, fault 1", "shows", "now")),
        (
            '"VACUUM_EXCEEDED", "PUMP_RUNAWAY"',
            '"VACUUM_EXCEEDED", "CONSOLE_LOST"',
            ("OS-H01, fault 1", "alarm: CONSOLE_LOST is raised by nothing in the twin"),
        ),
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
            for_all = claim.approach == claim.patient == "all"
            assert for_all or len(claim.only_because) > 10, (one.row.id, claim.name)


def test_a_condition_that_is_called_unheard_is_raised_nowhere_and_the_others_are() -> None:
    """By the sources of those who can raise one: a claim of an alarm that cannot come is none."""
    rooms = ("safety/governor", "safety/watch", "controller", "procedure")
    files = [file for room in rooms for file in (SOURCES / room).rglob("*.py")]
    text = "\n".join(file.read_text() for file in (*files, SOURCES / "simulation/outcome.py"))
    raised = {
        one for one in Condition if re.search(rf"Condition\.{one.name}\b|\b{one.name} =", text)
    }
    assert set(Condition) - raised == UNHEARD
