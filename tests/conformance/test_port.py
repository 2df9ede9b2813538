"""One suite over every machine that a controller can be put before.

Each is a process, or hardware, with a clock of its own.
"""

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.devices import twin_machine
from opensuction.devices.ports import Port
from opensuction.devices.twin_machine import TwinMachine
from opensuction.kernel.generated import row
from opensuction.kernel.readings import Readings
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation.machine_side import SENT_COLUMNS, MachineSide
from opensuction.simulation.wiring import Wiring
from opensuction.twin import preset
from opensuction.twin.fault import link
from opensuction.twin.machine import drive_watchdog
from opensuction.twin.plant import PlantState

COLUMNS = row.columns(Readings)
PATIENCE_S = 5.0


class Machine(NamedTuple):
    """A machine that runs, and how a controller is put before it."""

    connect: Callable[[], Port]


@pytest.fixture(scope="module", params=["twin"])
def machine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machine]:
    folder = tmp_path_factory.mktemp("twin")
    rig = rigs.rig("bench", 1)
    known = rigs.uncalibrated(rig.profile)
    loop, state = rigs.assemble(rig, PAPER, CompensationKind.NONE, known, 2)
    played = preset.limit_rack(loop.machine, loop.controller.limits.park_head_mm)
    watchdog = drive_watchdog.of(played, loop.controller.limits.park_head_mm)
    side = MachineSide(played, Wiring(link.healthy(1), watchdog))
    process = twin_machine.launch(folder, side, PlantState(state.machine, state.bedside))
    yield Machine(lambda: TwinMachine(folder))
    process.terminate()
    assert process.wait(5.0) == 0
    assert (folder / twin_machine.LOG).read_text() == ""


@pytest.fixture
def port(machine: Machine) -> Iterator[Port]:
    """A controller's, that has just started; the head is home at the end."""
    made = machine.connect()
    drive(made, 0.05, released=1.0)
    yield made
    made.close()
    again = machine.connect()
    assert wait(lambda: read(again, "head_mm") < 1.0)
    again.close()


def sent(**values: float) -> np.ndarray:
    made = np.zeros(len(SENT_COLUMNS))
    for name, value in values.items():
        made[SENT_COLUMNS.index(name if name in SENT_COLUMNS else f"commands.{name}")] = value
    return made


def drive(port: Port, seconds: float, **values: float) -> None:
    """Give the same command once a period."""
    made, ends = sent(**values), time.monotonic() + seconds
    while time.monotonic() < ends:
        port.write(made)
        time.sleep(port.facts.period_s)


def read(port: Port, name: str) -> float:
    readings = np.full(len(COLUMNS), np.nan)
    assert port.read(readings) > 0
    return float(readings[COLUMNS.index(name)])


def wait(holds: Callable[[], bool]) -> bool:
    ends = time.monotonic() + PATIENCE_S
    while not holds():
        if time.monotonic() > ends:
            return False
        time.sleep(0.002)
    return True


def test_it_says_what_it_is(port: Port) -> None:
    facts = port.facts
    assert facts.name
    assert facts.version
    assert 0.0 < facts.period_s < facts.watchdog_s < 0.1
    assert facts.most["commands.insertion_v"] > 0.0


def test_its_readings_are_new_with_each_of_its_periods(port: Port) -> None:
    readings = np.empty(len(COLUMNS))
    first, begun = port.read(readings), time.monotonic()
    time.sleep(0.5)
    last, ended = port.read(readings), time.monotonic()
    due = (ended - begun) / port.facts.period_s
    assert 0.5 * due < last - first < 1.1 * due
    assert np.isfinite(readings).all()
    assert readings[COLUMNS.index("head_valid")] == 1.0


def test_it_obeys(port: Port) -> None:
    before = read(port, "head_mm")
    drive(port, 0.6, insertion_v=20.0, insertion_on=1.0)
    assert read(port, "head_mm") > before + 5.0


def test_without_commands_it_comes_home_by_itself(port: Port) -> None:
    drive(port, 1.0, insertion_v=20.0, insertion_on=1.0)
    inside = read(port, "head_mm")
    assert inside > 10.0
    assert wait(lambda: read(port, "head_mm") < 1.0)


def test_once_it_acts_on_its_own_it_obeys_only_who_has_started_anew(port: Port) -> None:
    drive(port, 0.3, insertion_v=20.0, insertion_on=1.0)
    time.sleep(3.0 * port.facts.watchdog_s)
    assert wait(lambda: read(port, "head_mm") < 1.0)
    drive(port, 0.3, insertion_v=20.0, insertion_on=1.0)
    assert read(port, "head_mm") < 1.0
    drive(port, 0.05, released=1.0)
    drive(port, 0.3, insertion_v=20.0, insertion_on=1.0)
    assert read(port, "head_mm") > 1.5


def test_reading_and_writing_never_wait(port: Port) -> None:
    """Far less than a period in the middle, though this machine may stand still in between."""
    readings, made = np.empty(len(COLUMNS)), sent()
    taken = []
    for _ in range(2000):
        begun = time.perf_counter()
        port.read(readings)
        port.write(made)
        taken.append(time.perf_counter() - begun)
    assert np.median(taken) < 0.2 * port.facts.period_s
