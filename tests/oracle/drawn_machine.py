"""Drawn machines and patients, ready for a cycle: patients and approaches in turn."""

from functools import cache

from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import PLAYED
from opensuction.evidence.campaign.sound_machine import HealthyCycle
from opensuction.evidence.trial import draw
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection.faulty_run import RowBuffer

KINDS = draw.list_kinds(draw.PRESETS)


def prepare(index: int, first_seed: int) -> Prepared:
    """The machine at that place, drawn by a seed of its own; without pre-oxygenation."""
    return sound_machine.prepare(KINDS[index % len(KINDS)], first_seed + index, "preview")


def pool(first_seed: int) -> list[Prepared]:
    """A machine for each patient and approach."""
    return [prepare(index, first_seed) for index in range(len(KINDS))]


@cache
def _room() -> RowBuffer:
    return played_cycle.make_room(PLAYED)


def play_healthy(prepared: Prepared) -> HealthyCycle:
    """The machine's cycle without a fault."""
    return sound_machine.play(prepared, _room()).healthy
