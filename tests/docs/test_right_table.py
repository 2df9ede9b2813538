from docs.generator import right_table
from opensuction.accounts.rule.right import RIGHTS


def test_every_right_has_its_row() -> None:
    rows = {row.split("|")[2].strip(): row for row in right_table.markdown().splitlines() if row}
    for right, permission in RIGHTS.items():
        assert permission.sentence in rows[f"`{right}`"]
    assert rows["`stop`"].count("yes") == 5
    assert [cell.strip() for cell in rows["`start`"].split("|")[3:-1]] == [
        "",
        "",
        "yes",
        "",
        "",
        "",
    ]
    assert rows["`change-limits`"].endswith("| with a reason |")
