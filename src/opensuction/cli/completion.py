"""Names that options take, for help and shell completion.

Written here once more, because the rooms that hold them take a third of a second to load, and
completion answers between two key strokes; ``tests/cli/test_completion.py`` holds them against
those rooms.
"""

from collections.abc import Callable, Iterable

from opensuction.runtime import machine_button
from opensuction.twin.fault.fault import BY_NAME

MACHINES = (
    "bench",
    "clinical",
    "bench-bouc-wen",
    "bench-rubbing",
    "bench-preisach-00",
    "bench-preisach-25",
    "bench-preisach-45",
    "bench-readout-00",
    "bench-readout-25",
    "bench-readout-45",
)
PROTOCOLS = ("adult", "paediatric", "paper")
PATIENTS = ("adult-icu", "adult-ards", "child-10kg", "neonate")
CATHETERS = ("6fr", "8fr", "10fr", "12fr", "14fr")
CONDUITS = ("standard", "short", "looped")
APPROACHES = ("travel", "contact")
COMPENSATIONS = (
    "none",
    "direct-inverse",
    "exact-inverse",
    "gap-width",
    "lookup-table",
    "prandtl-ishlinskii",
    "preview",
    "model-preview",
)
MODELS = (
    "modified-dahl",
    "dahl",
    "bouc-wen",
    "prandtl-ishlinskii",
    "preisach",
    "play-readout",
    "generalised",
    "residual-readout",
    "maxwell-slip",
)
CONTENDERS = (*MODELS, "modified-bouc-wen", "bouc-wen-oscillator", "straight-line")
DATA_SETS = (
    "grasper-00",
    "grasper-25",
    "grasper-45",
    "mr-damper",
    "friction-damper",
    "column",
    "wall",
    "servo",
    "servo-pair",
    "simulated-mr-damper",
    "bouc-wen-benchmark",
)
PURPOSES = ("predict", "compensate", "transfer")
METHODS = (
    "variable-projection",
    "genetic-algorithm",
    "differential-evolution",
    "non-negative",
    "rising",
    "regularised",
)
FAULTS = tuple(BY_NAME)
COHORTS = ("presets", *PATIENTS)
FAULT_COUNTS = ("none", "single", "double")
LIFE_FAULTS = (
    "kill",
    "kill-writing",
    "freeze",
    "standstill",
    "slow",
    "wall-clock",
    "mail",
    "disk-full",
    "disk-failing",
    "disk-slow",
    "database",
    "power",
    "stop",
    "impatient",
)
PREOXYGENATION = ("confirmed", "skipped")
FORMATS = ("csv", "parquet")
REQUESTS = tuple(machine_button.BY_NAME)
ACTS_ON_USERS = ("list", "add", "role", "deactivate", "reset-password")
ROLES = ("observer", "clinician", "engineer")


def complete_from(names: Iterable[str]) -> Callable[[str], list[str]]:
    """Completer of the beginning of these names; a shell offers files where none fits."""

    def complete(incomplete: str) -> list[str]:
        return [name for name in names if name.startswith(incomplete)]

    return complete
