import re
from pathlib import Path
from typing import Any

import pytest

from docs.generator import model_table
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE

PAGE = Path(__file__).resolve().parents[2] / "docs" / "hysteresis.md"


def test_every_parameter_of_every_model_has_its_row() -> None:
    table = model_table.markdown()
    for model in CATALOGUE.values():
        for parameter in model.parameters:
            assert f"| `{model.name}` | `{parameter.name}` | {parameter.symbol} |" in table
    assert all(row.count("|") in {3, 5, 6} for row in table.splitlines() if row)


def test_the_examples_of_the_page_run() -> None:
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 2
    names: dict[str, Any] = {}
    for block in blocks:
        exec(block, names)  # noqa: S102 - the page is ours, and a reader will paste it
    # Slopes of .95 - .8 after a reversal: rounding of the tip passes on sevenfold.
    assert names["again_mm"] == pytest.approx(names["head_mm"], abs=1e-11)
    assert names["reached"].all()
    again = names["simulate"](names["model"], names["fitted"], names["head_mm"], -1.0)
    assert again == pytest.approx(names["tip_mm"], abs=1e-9)
