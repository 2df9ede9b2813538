from pathlib import Path

import pytest

from opensuction.kernel.errors import InputError
from opensuction.twin import parameter_table, patient_table
from opensuction.twin.patient_parameter import PRESETS, ROWS

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "patient.md"


def test_the_documentation_holds_the_parameters_as_they_are() -> None:
    """If this fails: make docs."""
    text = DOCUMENT.read_text(encoding="utf-8")
    assert parameter_table.spliced(text, patient_table.markdown()) == text


def test_every_parameter_has_its_line() -> None:
    lines = patient_table.markdown().splitlines()[2:]
    assert len(lines) == len(ROWS)
    for line, name in zip(lines, ROWS, strict=True):
        assert line.startswith(f"| `{name}` | ")
        assert line.count("|") == len(PRESETS) + 5  # a bar inside a text would break the table


def test_a_document_without_marks_is_refused() -> None:
    with pytest.raises(InputError, match="lacks the line"):
        parameter_table.spliced("# The patient\n", "")
