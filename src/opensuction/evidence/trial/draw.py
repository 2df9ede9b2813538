"""Random draw of each cycle of a trial: its machine, its faults, their strengths and instants.

All of it follows from the trial and the cycle's number, so that any cycle can be played again alone
and any part of a trial on its own, and a longer trial begins with the cycles of a shorter one.

Cohorts of a trial: sets of patients by name.
"""

from typing import NamedTuple, get_args

from opensuction.evidence.campaign.sound_machine import Kind, find_strength
from opensuction.kernel import random_stream
from opensuction.result.trial_result import FaultCount, Trial
from opensuction.session.cycle.resolution import APPROACHES
from opensuction.settings.validation import choose
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES

PRESETS = "presets"
COHORTS: dict[str, tuple[str, ...]] = {
    PRESETS: tuple(PATIENT_TABLES),
    **{name: (name,) for name in PATIENT_TABLES},
}
"""Presets of patients by the name of their set: all of them, or one."""


def list_kinds(cohort: str) -> tuple[Kind, ...]:
    """Every patient of a cohort by every approach, in the order in which machines take turns.

    Raises InputError for an unknown name.
    """
    patients = choose(cohort, COHORTS, "--cohort")
    return tuple(Kind(patient, approach) for patient in patients for approach in APPROACHES)


PURPOSE = 72
"""Number of the noise stream of trials."""
BLOCKS = 4
"""Pairs of random numbers that a cycle may draw: two faults take three numbers each."""
FAULT_COUNTS: dict[str, int] = {name: many for many, name in enumerate(get_args(FaultCount))}
"""How many faults come to a cycle, by the name that the command line takes."""
MACHINE_SEEDS = 1_000_000
"""Seeds of machines that a trial has for itself."""
TRIES = 20
"""How many machines may be drawn for one that can do its protocol."""
SEEDS = 2**32

FAULTS = tuple(fault for fault, row in ROWS.items() if not row.is_setup)
"""Whatever can happen to a running machine."""


class DrawnFault(NamedTuple):
    """A fault of a cycle, as it is drawn."""

    fault: Fault
    strength: float
    share: float
    """When it comes, as a share of the time in the airway and the second before, 0 to 1."""


def count_per_machine(trial: Trial) -> int:
    """Cycles on one machine; where nothing is injected, machines are all that differs.

    To prepare one, and to play its own cycle, takes as long as some five cycles with faults.
    """
    return 1 if trial.faults == "none" else 50


def find_machine(trial: Trial, number: int) -> int:
    """Machine, from 0 on, of the cycle of a number, 1 or more: as many take turns as kinds."""
    kinds = len(list_kinds(trial.cohort))
    group, within = divmod(number - 1, kinds * count_per_machine(trial))
    return group * kinds + within % kinds


def list_numbers(trial: Trial, machine: int, cycles: int) -> list[int]:
    """Numbers of the cycles of a machine, of those up to ``cycles``."""
    kinds = len(list_kinds(trial.cohort))
    group, kind = divmod(machine, kinds)
    first = 1 + group * kinds * count_per_machine(trial) + kind
    numbers = range(first, first + kinds * count_per_machine(trial), kinds)
    return [number for number in numbers if number <= cycles]


def count_machines(trial: Trial, cycles: int) -> int:
    """Number of machines that so many cycles take."""
    kinds = len(list_kinds(trial.cohort))
    groups, within = divmod(cycles, kinds * count_per_machine(trial))
    return groups * kinds + min(within, kinds)


def kind_of(trial: Trial, machine: int) -> Kind:
    """Patient and approach of a machine."""
    kinds = list_kinds(trial.cohort)
    return kinds[machine % len(kinds)]


def machine_seed(trial: Trial, machine: int, again: int) -> int:
    """Seed that draws a machine and its patient. again: how often one before it was no use."""
    within = (machine + again * MACHINE_SEEDS // TRIES) % MACHINE_SEEDS
    return (trial.seed * MACHINE_SEEDS + within) % SEEDS


def chance_seed(trial: Trial, number: int) -> int:
    """Seed of what is chance in a cycle's faults."""
    return (trial.seed * MACHINE_SEEDS + number) % SEEDS


def _draw_uniforms(trial: Trial, number: int) -> list[float]:
    source = random_stream.stream(trial.seed, PURPOSE)._replace(counter=number * BLOCKS)
    drawn: list[float] = []
    for _ in range(BLOCKS):
        first, second, source = random_stream.uniform_pair(source)
        drawn += [first, second]
    return drawn


def draw_faults(trial: Trial, number: int) -> tuple[DrawnFault, ...]:
    """Faults of the cycle of a number: any of them, of any strength, at any time inside."""
    uniform = _draw_uniforms(trial, number)
    faults = []
    for i in range(FAULT_COUNTS[trial.faults]):
        pick, strong, share = uniform[3 * i : 3 + 3 * i]
        fault = FAULTS[min(int(pick * len(FAULTS)), len(FAULTS) - 1)]
        faults.append(DrawnFault(fault, find_strength(fault, strong), share))
    return tuple(faults)
