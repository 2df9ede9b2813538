"""The catalogue of hysteresis models as tables."""

from opensuction.hysteresis.catalogue.catalogue import CATALOGUE


def markdown() -> str:
    """What each model is, and each of its parameters with symbol, unit and meaning."""
    lines = ["| model | name | source | inverse |", "|---|---|---|---|"]
    lines += [
        f"| {model.title} | `{model.name}` | {model.source} | {model.inverse} |"
        for model in CATALOGUE.values()
    ]
    lines += ["", "| model | parameter | symbol | unit | meaning |", "|---|---|---|---|---|"]
    lines += [
        f"| `{model.name}` | `{one.name}` | {one.symbol} | {one.unit} | {one.meaning} |"
        for model in CATALOGUE.values()
        for one in model.parameters
    ]
    lines += ["", "| model | cannot represent |", "|---|---|"]
    lines += [f"| `{model.name}` | {model.cannot} |" for model in CATALOGUE.values()]
    return "\n".join(["", *lines, "", ""])
