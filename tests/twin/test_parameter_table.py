from pathlib import Path

import pytest

from opensuction.kernel.errors import InputError
from opensuction.twin import parameter_table
from opensuction.twin.parameter import BENCH, CLINICAL

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "twin.md"


def test_the_documentation_holds_the_parameters_as_they_are() -> None:
    """If this fails: make docs."""
    text = DOCUMENT.read_text(encoding="utf-8")
    assert parameter_table.spliced(text, parameter_table.machines()) == text


def test_every_parameter_has_its_line() -> None:
    lines = parameter_table.markdown(BENCH).splitlines()[2:]
    assert len(lines) == len(BENCH)
    for line, name in zip(lines, BENCH, strict=True):
        assert line.startswith(f"| `{name}` | ")
        assert line.count("|") == 7  # a bar inside a text would break the table


def test_only_what_differs_is_shown_of_the_bedside_machine() -> None:
    shown = parameter_table.difference(CLINICAL, BENCH)
    assert "no_load_mm_per_s" in shown
    assert "bend_rad" not in shown
    for name in BENCH:
        assert (name in shown) is (BENCH[name] != CLINICAL[name])


def test_a_document_without_marks_is_refused() -> None:
    with pytest.raises(InputError, match="lacks the line"):
        parameter_table.spliced("# The twin\n", "")
