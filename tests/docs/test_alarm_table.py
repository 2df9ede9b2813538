from docs.generator import alarm_table
from docs.generator.alarm_table import VALUES
from opensuction.safety.condition import Condition


def test_every_condition_has_a_row() -> None:
    table = alarm_table.conditions()
    for condition in Condition:
        assert f"| {int(condition)} | `{condition.name}` | " in table
    assert len(table.splitlines()) == 2 + len(Condition)
    row = next(line for line in table.splitlines() if "`CIRCUIT_DISCONNECTED`" in line)
    assert row.split(" | ")[2:7] == ["high", "", "", "", ""]
    row = next(line for line in table.splitlines() if "`VALVE_STUCK_CLOSED`" in line)
    assert row.split(" | ")[2:7] == ["medium", "yes", "", "120 s", "none"]


def test_what_is_not_verified_is_marked_so() -> None:
    table = alarm_table.values()
    assert len(table.splitlines()) == 2 + len(VALUES)
    for name, value in VALUES.items():
        row = next(line for line in table.splitlines() if line.startswith(f"| {name} |"))
        assert row.endswith(f"| {value.source} |")
    assert "| high sound: pulse | 0.15 | 0.075 to 0.2 | s | [K] |" in table
    assert "| low sound: interval of bursts | 16 | 15 or more | s | [K] |" in table
    assert "| low light, cyan: flashing | 0 | 0 | Hz | [K] |" in table
    assert "| high sound: fundamental | 660 | 150 to 1000 | Hz | [PUI-Audio] |" in table


def test_the_matrix_has_a_row_for_each_harm() -> None:
    assert alarm_table.matrix() == (
        "| | immediate | prompt | delayed |\n"
        "|---|---|---|---|\n"
        "| death | high | high | medium |\n"
        "| reversible | high | medium | low |\n"
        "| minor | medium | low | low |\n"
    )
