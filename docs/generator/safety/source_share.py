"""Kinds of source of the twin's parameters, with the number of parameters of each kind."""

import re
from collections import Counter

from docs.generator.document import table
from opensuction.kernel.errors import InputError
from opensuction.twin.machine import dc_axis
from opensuction.twin.parameter import BENCH, CLINICAL
from opensuction.twin.parameter_row import Parameter
from opensuction.twin.patient.patient_parameter import ROWS

TAG = re.compile(r"\[([A-Za-z][\w-]*)\]")
KINDS = {
    "paper": "[paper]",
    "datasheet": "[datasheet]",
    "literature": "other literature",
    "calibrated": "[calibrated]",
    "computed": "[computed]",
    "design": "[design]",
    "K": "[K]",
    "assumed": "[assumed]",
}
"""Kinds of sources from the firmest to the least, as the page shows them."""


def kind(entry: Parameter) -> str:
    """What a parameter rests on first: the first tag of its source.

    Raises InputError for a source without a tag.
    """
    found = TAG.search(entry.source)
    if found is None:
        raise InputError(f"{entry.meaning}: its source '{entry.source}' has no tag")
    return found[1] if found[1] in KINDS else "literature"


def markdown() -> str:
    """A row for each kind of source, a column for each table of parameters."""
    tables: dict[str, list[Parameter]] = {
        "bench": list(BENCH.values()),
        "clinical, where other": [
            entry for name, entry in CLINICAL.items() if entry != BENCH[name]
        ],
        "patients": [row[0] for row in ROWS.values()],
        "teaching hand": list(dc_axis.HAND_PARAMETERS.values()),
    }
    counts = {name: Counter(map(kind, entries)) for name, entries in tables.items()}
    rows = [
        (shown, *(str(count[one] or "") for count in counts.values()))
        for one, shown in KINDS.items()
        if any(count[one] for count in counts.values())
    ]
    rows.append(("together", *(str(count.total()) for count in counts.values())))
    weak = [100.0 * (one["K"] + one["assumed"]) / one.total() for one in counts.values()]
    rows.append(("[K] or [assumed]", *(f"{share:.0f} %" for share in weak)))
    return "\n".join(["", *table(("rests on", *tables), rows), "", ""])
