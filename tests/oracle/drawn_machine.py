"""Drawn machines and patients, ready for a cycle: patients and approaches in turn."""

from opensuction.evidence.trial import cohort, sound_machine
from opensuction.session.cycle.cycle_run import Prepared

KINDS = cohort.list_kinds(cohort.PRESETS)


def prepare(index: int, first_seed: int) -> Prepared:
    """The machine at that place, drawn by a seed of its own; without pre-oxygenation."""
    return sound_machine.prepare(KINDS[index % len(KINDS)], first_seed + index, "preview")


def pool(first_seed: int) -> list[Prepared]:
    """A machine for each patient and approach."""
    return [prepare(index, first_seed) for index in range(len(KINDS))]
