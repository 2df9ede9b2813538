"""The check that nothing is claimed without a test or a fault that shows it."""

from pathlib import Path

import pytest

from tools.traceability import matrix
from tools.traceability.matrix import Mark, Matrix

SOUND = Matrix(
    hazards=({"id": "OS-H01", "fault": [{"name": "motor-stall"}], "requirements": ["OS-R01"]},),
    requirements={"OS-R01": "It stops."},
    marks=(Mark("tests/test_a.py::test_it_stops", "OS-R01"),),
)


def test_a_whole_chain_has_no_gap() -> None:
    assert matrix.gaps(SOUND) == []


@pytest.mark.parametrize(
    ("broken", "gap"),
    [
        (SOUND._replace(marks=()), "requirement OS-R01: no test cites it"),
        (
            SOUND._replace(marks=(*SOUND.marks, Mark("tests/test_a.py::test_b", "OS-R99"))),
            "tests/test_a.py::test_b: cites unknown requirement OS-R99",
        ),
        (
            SOUND._replace(hazards=(SOUND.hazards[0] | {"fault": []},)),
            "hazard OS-H01: no fault shows it",
        ),
        (
            SOUND._replace(hazards=(SOUND.hazards[0] | {"requirements": []},)),
            "hazard OS-H01: no requirement answers it",
        ),
        (
            SOUND._replace(hazards=(SOUND.hazards[0] | {"requirements": ["OS-R07"]},)),
            "hazard OS-H01: unknown requirement OS-R07",
        ),
        (
            SOUND._replace(hazards=SOUND.hazards * 2),
            "hazard OS-H01: more than one of this identifier",
        ),
    ],
)
def test_each_gap_is_one_line_that_names_it(broken: Matrix, gap: str) -> None:
    assert matrix.gaps(broken) == [gap]


def test_marks_of_functions_classes_and_modules_are_read() -> None:
    source = """
import pytest
pytestmark = [pytest.mark.soak, pytest.mark.requirement("OS-R01")]

@pytest.mark.parametrize("x", [1])
@pytest.mark.requirement("OS-R02", "OS-R03")
def test_one(x): ...

@pytest.mark.requirement("OS-R04")
class TestTwo: ...

@pytest.fixture
def requirement(): ...
"""
    assert matrix.marks_of(source, "tests/test_a.py") == [
        Mark("tests/test_a.py", "OS-R01"),
        Mark("tests/test_a.py::test_one", "OS-R02"),
        Mark("tests/test_a.py::test_one", "OS-R03"),
        Mark("tests/test_a.py::TestTwo", "OS-R04"),
    ]


def test_an_identifier_that_is_not_written_out_is_refused() -> None:
    source = "import pytest\n@pytest.mark.requirement(NAME)\ndef test_a(): ...\n"
    with pytest.raises(ValueError, match="malformed"):
        matrix.marks_of(source, "tests/test_a.py")


def test_files_are_read_from_where_they_lie(tmp_path: Path) -> None:
    tests = tmp_path / "tests" / "room"
    tests.mkdir(parents=True)
    (tests / "test_a.py").write_text(
        'import pytest\n\n@pytest.mark.requirement("OS-R01")\ndef test_a(): ...\n'
    )
    (tests / "drive.py").write_text("not Python at all")
    hazards, requirements = tmp_path / "hazard.toml", tmp_path / "requirement.toml"
    hazards.write_text('[[hazard]]\nid = "OS-H01"\n[[hazard.fault]]\nname = "leak"\n')
    requirements.write_text('OS-R01 = "It stops."\n')
    found = matrix.read(hazards, requirements, tmp_path / "tests")
    assert found.marks == (Mark("tests/room/test_a.py::test_a", "OS-R01"),)
    assert matrix.gaps(found) == ["hazard OS-H01: no requirement answers it"]


def test_this_repository_has_no_gap() -> None:
    assert matrix.gaps(matrix.read()) == []
