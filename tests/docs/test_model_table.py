from docs.generator import model_table
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE


def test_every_parameter_of_every_model_has_its_row() -> None:
    table = model_table.markdown()
    for model in CATALOGUE.values():
        for parameter in model.parameters:
            assert f"| `{model.name}` | `{parameter.name}` | {parameter.symbol} |" in table
    assert all(row.count("|") in {3, 5, 6} for row in table.splitlines() if row)
