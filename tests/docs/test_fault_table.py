from docs.generator import fault_table
from opensuction.twin.fault.fault_table import ROWS


def test_every_fault_has_a_row_with_its_strength() -> None:
    table = fault_table.markdown()
    for fault in ROWS:
        assert f"| {int(fault)} | `{fault.title}`" in table
    row = next(line for line in table.splitlines() if "`line-leak`" in line)
    assert "| leak in addition, 0.02 to 50 mL/s/mmHg | 2 mL/s/mmHg |" in row
