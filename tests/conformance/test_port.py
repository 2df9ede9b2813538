"""One suite over every machine that a controller can be put before.

Each is a process, or hardware, with a clock of its own, and so is the computer that tests it: one
that keeps either from its work for longer than the watchdog's time has the drives act on their own,
as they should.
"""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.host.host import Child
from opensuction.kernel.codegen import row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import MESSAGE_COLUMNS, Readings
from opensuction.machine import port as machine_port
from opensuction.machine.port import DESCRIPTION, Description, Port, describe, read_description
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_machine import TwinMachine
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation.machine_side import MachineSide
from opensuction.simulation.wiring import Wiring
from opensuction.twin import preset
from opensuction.twin.fault import link
from opensuction.twin.fault.bus import PLAUSIBLE
from opensuction.twin.machine import fail_safe
from opensuction.twin.plant import PlantState

# The test itself commands the machine, an ordinary process: it may be late by half of the drives'
# patience, and the machine by as much.
pytestmark = pytest.mark.real_time(machine_s=0.01, others_s=0.01)

COLUMNS = row.columns(Readings)
NO_NUMBERS = (np.nan, np.inf, -np.inf)
PATIENCE_S = 5.0
GREETING_S = 0.2
"""For so long a controller says that it has started anew; so does the control loop."""
OBEYED = {"commands.insertion_v", "commands.valve_v", "commands.vacuum_mmhg"}
"""What every machine must say a limit of."""


class Machine(NamedTuple):
    """A machine that runs, and how a controller is put before it."""

    folder: Path
    connect: Callable[[], Port]
    stop: Callable[[], None]
    """Its power goes."""
    start: Callable[[], None]
    """It is back, with the head at home."""


MACHINES = [
    pytest.param(None, id="twin"),
    pytest.param(PLAUSIBLE, id="twin-on-a-bus", marks=pytest.mark.soak),
]
"""Each machine. The bus carries each message alike."""


@pytest.fixture(scope="module", params=MACHINES)
def machine(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Machine]:
    folder = tmp_path_factory.mktemp("twin")
    rig = rigs.rig("bench", 1)
    known = rigs.uncalibrated(rig.profile)
    loop, state = rigs.assemble(rig, PAPER, CompensationKind.NONE, known, 2)
    played = preset.limit_rack(loop.machine, loop.controller.limits.park_head_mm)
    watchdog = fail_safe.of(played, loop.controller.limits.park_head_mm)
    side = MachineSide(played, Wiring(link.healthy(1), watchdog))
    plant = PlantState(state.machine, state.bedside)
    processes: list[Child] = []

    def stop() -> None:
        process = processes.pop()
        process.terminate()
        assert process.wait(5.0) == 0
        assert (folder / twin_machine.LOG).read_text() == ""

    def start() -> None:
        processes.append(twin_machine.launch(folder, side, plant, request.param))

    start()
    yield Machine(folder, lambda: TwinMachine(folder), stop, start)
    stop()


@pytest.fixture
def port(machine: Machine) -> Iterator[Port]:
    """A controller's port, that has just started; the head is home at the end."""
    made = machine.connect()
    try:
        greet(made)
        yield made
    finally:
        made.close()
        come_home(machine)


def come_home(machine: Machine) -> None:
    """Nobody commands it: it comes out by itself."""
    made = machine.connect()
    assert wait(lambda: read(made, "head_mm") < 1.0)
    made.close()


def sent(**values: float) -> np.ndarray:
    made = np.zeros(len(MESSAGE_COLUMNS))
    for name, value in values.items():
        made[MESSAGE_COLUMNS.index(name if name in MESSAGE_COLUMNS else f"commands.{name}")] = value
    return made


def drive(port: Port, seconds: float, **values: float) -> None:
    """Give the same command once a period."""
    made, ends = sent(**values), time.monotonic() + seconds
    while time.monotonic() < ends:
        port.write(made)
        time.sleep(port.facts.period_s)


def greet(port: Port) -> None:
    drive(port, GREETING_S, released=1.0)


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
    assert isinstance(facts.in_silico, bool)
    assert 0.0 < facts.period_s < facts.watchdog_s < 0.1
    assert set(facts.most) >= OBEYED
    assert set(facts.most) <= set(MESSAGE_COLUMNS)
    assert all(0.0 < most < np.inf for most in facts.most.values())
    told = {DESCRIPTION: describe(facts)}  # it is kept as text
    assert read_description(told) == Description(facts.in_silico, facts.capabilities)
    assert json.loads(told[DESCRIPTION])["most"] == facts.most


def test_it_has_what_it_claims(machine: Machine, port: Port) -> None:
    has, kind, folder = port.facts.capabilities, machine_port.load(machine.folder), machine.folder
    assert kind.capabilities_of(folder) == has
    assert (kind.hand_of(folder) is not None) == has.simulated_hand
    assert (kind.truth_of(folder) is not None) == has.truth
    assert has.taught_by_hand or not has.simulated_hand


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
    greet(port)
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


def speed_mm_per_s(port: Port, volts: float) -> float:
    """Of the head under a voltage, once it has its speed; by the machine's own clock."""
    drive(port, 0.3, insertion_v=volts, insertion_on=1.0)
    readings, place = np.empty(len(COLUMNS)), COLUMNS.index("head_mm")
    first = port.read(readings)
    from_mm = readings[place]
    drive(port, 0.3, insertion_v=volts, insertion_on=1.0)
    last = port.read(readings)
    return float((readings[place] - from_mm) / ((last - first) * port.facts.period_s))


@pytest.mark.sweep
@pytest.mark.parametrize("times", [10.0, pytest.param(1e300, marks=pytest.mark.soak)])
def test_more_than_it_says_is_cut_to_that(machine: Machine, port: Port, times: float) -> None:
    most_v = port.facts.most["commands.insertion_v"]
    usual = speed_mm_per_s(port, most_v)
    assert usual > 5.0
    port.close()
    come_home(machine)
    with closing(machine.connect()) as again:
        greet(again)
        assert speed_mm_per_s(again, times * most_v) == pytest.approx(usual, rel=0.1)
        drive(again, 0.5, insertion_v=times * most_v, insertion_on=1.0)
        assert speed_mm_per_s(again, -times * most_v) == pytest.approx(-usual, rel=0.1)


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("every", "first"),
    [(5, 0), *(pytest.param(1, each, marks=pytest.mark.soak) for each in (0, 1, 2))],
)
def test_a_command_with_anything_in_it_that_is_no_number_is_none(
    port: Port, every: int, first: int
) -> None:
    """Neither obeyed nor a sign of life, in whichever of its fields it is.

    every: so many-th of the fields; `simulation/test_machine_side.py` has all of them. first: of
    the values, which the fields have by turns.
    """
    for turn, column in enumerate(MESSAGE_COLUMNS[::every], first):
        greet(port)
        drive(port, 0.2, insertion_v=20.0, insertion_on=1.0)
        before = read(port, "head_mm")
        assert before > 1.0
        value = NO_NUMBERS[turn % len(NO_NUMBERS)]
        bad = {"insertion_v": 20.0, "insertion_on": 1.0, "released": 1.0, column: value}
        made, ends = sent(**bad), time.monotonic() + PATIENCE_S
        while read(port, "head_mm") >= 1.0 and time.monotonic() < ends:
            port.write(made)
            time.sleep(port.facts.period_s)
        assert read(port, "head_mm") < 1.0, (column, value)
        readings = np.empty(len(COLUMNS))
        port.read(readings)
        assert np.isfinite(readings).all()


@pytest.mark.sweep
def test_what_one_controller_has_left_is_not_obeyed_for_the_next(
    machine: Machine, port: Port
) -> None:
    drive(port, 0.5, insertion_v=20.0, insertion_on=1.0)
    port.close()
    with closing(machine.connect()) as after:
        assert wait(lambda: read(after, "head_mm") < 1.0)
        # Its numbers begin anew, and without a greeting it is not obeyed either.
        drive(after, 0.3, insertion_v=20.0, insertion_on=1.0)
        assert read(after, "head_mm") < 1.0
        greet(after)
        drive(after, 0.3, insertion_v=20.0, insertion_on=1.0)
        assert read(after, "head_mm") > 1.5


@pytest.mark.sweep
def test_a_second_controller_is_refused_and_the_first_one_goes_on(
    machine: Machine, port: Port
) -> None:
    drive(port, 0.2, insertion_v=20.0, insertion_on=1.0)
    for _ in range(3):
        with pytest.raises(InputError, match="another process"):
            machine.connect()
        before = read(port, "head_mm")
        drive(port, 0.2, insertion_v=20.0, insertion_on=1.0)
        assert read(port, "head_mm") > before + 1.0


def test_a_machine_that_was_started_again_is_read_again_and_obeys_who_starts_anew(
    machine: Machine, port: Port
) -> None:
    drive(port, 0.5, insertion_v=20.0, insertion_on=1.0)
    machine.stop()
    readings = np.empty(len(COLUMNS))
    gone = port.read(readings)
    drive(port, 0.1, insertion_v=20.0, insertion_on=1.0)
    assert port.read(readings) == gone  # nothing new, and nobody waits for it
    machine.start()
    drive(port, 0.5, insertion_v=20.0, insertion_on=1.0)
    back = port.read(readings)
    assert back > gone
    assert readings[COLUMNS.index("head_mm")] < 1.0  # it takes nobody for one that knows it
    drive(port, 0.1, insertion_v=20.0, insertion_on=1.0)
    assert port.read(readings) > back
    greet(port)
    drive(port, 0.3, insertion_v=20.0, insertion_on=1.0)
    assert read(port, "head_mm") > 1.5
