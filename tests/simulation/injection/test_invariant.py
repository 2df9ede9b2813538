"""Every invariant notices its own breach, and a sound cycle breaks none."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.check import CheckItem
from opensuction.safety.condition import Condition
from opensuction.session.choice import CycleChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import invariant
from opensuction.simulation.trace import Columns

Spoil = Callable[[Columns], None]


@cache
def sound() -> tuple[Prepared, Columns]:
    """A contact cycle on a patient."""
    choice = CycleChoice(approach="contact", compensation="exact-inverse")
    prepared = cycle_run.prepare(resolution.resolve(choice))
    return prepared, cycle_run.play(prepared)


def spoiled(spoil: Spoil) -> Columns:
    columns = {name: values.copy() for name, values in sound()[1].items()}
    spoil(columns)
    return columns


def middle(columns: Columns, phase: Phase) -> int:
    """A tick in the middle of a phase."""
    ticks = np.flatnonzero(columns["phase"] == phase)
    return int(ticks[ticks.size // 2])


def put(name: str, phase: Phase, value: float, ticks: int = 1) -> Spoil:
    def spoil(columns: Columns) -> None:
        first = middle(columns, phase)
        columns[name][first : first + ticks] = value

    return spoil


def cut_ignored(columns: Columns) -> None:
    columns["verdict.trips"][middle(columns, Phase.SUCTIONING) :] = 1 << Condition.VACUUM_EXCEEDED


def opened_on_the_way_in(columns: Columns) -> None:
    first = middle(columns, Phase.INSERTING)
    columns["commands.cam_rad"][first : first + 50] = np.linspace(0.0, 0.1, 50)


COMMAND_SIDE: list[tuple[str, Spoil]] = [
    ("commands.valve_v is a number", put("commands.valve_v", Phase.OPENING, np.nan)),
    ("voltage within the supply", put("commands.insertion_v", Phase.INSERTING, 24.5)),
    (
        "no voltage on the insertion axis without torque",
        put("commands.insertion_on", Phase.INSERTING, 0.0),
    ),
    ("no voltage on the valve axis without torque", put("commands.valve_on", Phase.OPENING, 0.0)),
    ("head command within its speed", put("commands.head_mm", Phase.SUCTIONING, 99.0)),
    ("vacuum command within its limit", put("commands.vacuum_mmhg", Phase.SUCTIONING, 151.0)),
    ("valve told to open only for suction", opened_on_the_way_in),
    ("no vacuum where a trip cuts it", cut_ignored),
    ("no advance with the valve open", put("commands.head_mm", Phase.SUCTIONING, 99.0)),
]


def test_a_sound_cycle_breaks_none() -> None:
    prepared, columns = sound()
    assert invariant.command_side(columns, prepared.loop.controller) == []


@pytest.mark.parametrize(("name", "spoil"), COMMAND_SIDE)
def test_a_command_that_should_not_be_is_noticed(name: str, spoil: Spoil) -> None:
    found = invariant.command_side(spoiled(spoil), sound()[0].loop.controller)
    assert name in {breach.invariant for breach in found}


def test_more_vacuum_than_the_patients_is_only_for_the_relief_valves_own_test() -> None:
    """Behind a valve that is read closed, the head parked: neither the one nor the other away."""
    settings, columns = sound()[0].loop.controller, sound()[1]
    tested = columns["commands.vacuum_mmhg"] > settings.limits.vacuum_mmhg
    assert set(columns["check_item"][tested]) == {float(CheckItem.RELIEF_OPENS)}

    def found(name: str, value: float) -> list[str]:
        changed = {**columns, name: np.where(tested, value, columns[name])}
        return [breach.invariant for breach in invariant.command_side(changed, settings)]

    broken = ["vacuum command within its limit"]
    highest_mmhg, park_mm = settings.limits.line.parked_closed_mmhg, settings.limits.park_head_mm
    assert found("commands.vacuum_mmhg", highest_mmhg) == []
    assert found("commands.vacuum_mmhg", highest_mmhg + 0.1) == broken
    assert found("readings.cam_rad", 0.03) == broken
    assert found("readings.cam_valid", 0.0) == broken
    assert found("readings.head_mm", park_mm + 3.1) == broken
    assert found("readings.head_valid", 0.0) == broken
    assert found("phase", float(Phase.PRELOADING)) == broken


def test_every_invariant_has_a_breach_here() -> None:
    # The pair of axes, and the numbers of every command, share an entry each.
    assert len(COMMAND_SIDE) == len(invariant.COMMAND_SIDE) + 1
