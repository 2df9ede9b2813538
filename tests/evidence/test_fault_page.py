from pathlib import Path

from opensuction.evidence import fault_page
from opensuction.report.document import spliced
from opensuction.twin.fault.fault_table import KINDS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "faults.md"


def test_the_page_is_what_make_docs_would_write() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert spliced(page, fault_page.markdown()) == page


def test_every_fault_has_a_row_with_its_strength() -> None:
    table = fault_page.markdown()
    for fault in KINDS:
        assert f"| {int(fault)} | `{fault.title}`" in table
    row = next(line for line in table.splitlines() if "`line-leak`" in line)
    assert "| leak in addition, 0.02 to 50 mL/s/mmHg | 2 mL/s/mmHg |" in row
