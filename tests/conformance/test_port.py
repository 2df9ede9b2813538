"""One suite over every machine that a controller can be put before.

Each is a process, or hardware, with a clock of its own, and so is the computer that tests it: one
that keeps either from its work for longer than the watchdog's time has the drives act on their own,
as they should.
"""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.host.host import Child
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel.codegen import row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import MESSAGE_COLUMNS, Readings
from opensuction.machine import port as machine_port
from opensuction.machine.canopen import device_file
from opensuction.machine.drives import drives_process
from opensuction.machine.port import DESCRIPTION, Description, Port, describe, read_description
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_machine import TwinMachine
from opensuction.machine.twin.twin_process import BEGUN, SHOWN
from opensuction.procedure.planning.protocol import PAPER
from opensuction.session.running import bus_machine
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import Loop, LoopState
from opensuction.simulation.machine_side import MachineSide
from opensuction.simulation.wiring import Wiring
from opensuction.twin import preset
from opensuction.twin.fault import link
from opensuction.twin.fault.bus import PLAUSIBLE
from opensuction.twin.machine import fail_safe
from opensuction.twin.plant import PlantState
from tests.runtime.room import begin_drives

# The test itself commands the machine, an ordinary process: it may be late by half of the drives'
# patience, and the machine by as much.
pytestmark = pytest.mark.real_time(machine_s=0.01, others_s=0.01)

COLUMNS = row.columns(Readings)
NO_NUMBERS = (np.nan, np.inf, -np.inf)
PATIENCE_S = 5.0
GREETING_S = 0.2
"""For so long a controller says that it has started anew; so does the control loop."""
BY_VOLTS = {"commands.insertion_v", "commands.valve_v", "commands.vacuum_mmhg"}
BY_POSITIONS = {"commands.head_mm", "commands.cam_rad", "commands.vacuum_mmhg"}
"""What a machine must say a limit of: without and with servos of its own."""
TURNS_S = 1.5
"""Until a drive's own set point, as far ahead as its speed limit lets it, has come back."""
USUAL_V, USUAL_MM_PER_S = 20.0, 40.0
"""The head inwards, for either."""


class Machine(NamedTuple):
    """A machine that runs, and how a controller is put before it."""

    folder: Path
    connect: Callable[[], Port]
    stop: Callable[[], None]
    """Its power goes."""
    start: Callable[[], None]
    """It is back, with the head at home."""


MACHINES = [
    pytest.param("twin", id="twin"),
    pytest.param("link", id="twin-on-a-bus", marks=pytest.mark.soak),
    pytest.param("drives", id="drives", marks=pytest.mark.soak),
]
"""Each machine. The bus of the second carries each message alike; drives have their own."""


@pytest.fixture(scope="module", params=MACHINES)
def machine(request: pytest.FixtureRequest) -> Iterator[Machine]:
    # A short path: a socket's address has room for 107 characters.
    with TemporaryDirectory() as name:
        make = _drives if request.param == "drives" else partial(_twin, request.param == "link")
        made = make(Path(name))
        made.start()
        yield made
        made.stop()


def _loop() -> tuple[Loop, LoopState]:
    rig = rigs.rig("bench", 1)
    return rigs.assemble(rig, PAPER, CompensationKind.NONE, rigs.uncalibrated(rig.profile), 2)


def _end(process: Child, log: Path) -> None:
    process.terminate()
    assert process.wait(5.0) == 0
    assert log.read_text() == ""


def _twin(is_on_a_link: bool, folder: Path) -> Machine:
    loop, state = _loop()
    played = preset.limit_rack(loop.machine, loop.controller.limits.park_head_mm)
    watchdog = fail_safe.of(played, loop.controller.limits.park_head_mm)
    side = MachineSide(played, Wiring(link.healthy(1), watchdog))
    plant = PlantState(state.machine, state.bedside)
    processes: list[Child] = []

    def start() -> None:
        carrier = PLAUSIBLE if is_on_a_link else None
        processes.append(twin_machine.launch(folder, side, plant, carrier))

    def stop() -> None:
        _end(processes.pop(), folder / twin_machine.LOG)

    return Machine(folder, lambda: TwinMachine(folder), stop, start)


def _drives(folder: Path) -> Machine:
    """Emulated drives on a bus of this computer, and the driver before them."""
    loop, state = _loop()
    behind = folder / "drives"
    behind.mkdir()
    processes: list[Child] = []

    def start() -> None:
        for left in (SHOWN, BEGUN, drives_process.SERVOS):
            (behind / left).unlink(missing_ok=True)
        processes.append(begin_drives(behind, loop, state, THIS_COMPUTER))
        bus_machine.lay(folder, bus_machine.load(behind / device_file.NAME))

    def stop() -> None:
        _end(processes.pop(), behind / "drives.log")

    def connect() -> Port:
        made, readings = machine_port.attach(folder, THIS_COMPUTER), np.empty(len(COLUMNS))
        assert wait(lambda: made.read(readings) > 0, made.facts.answers_s)
        return made

    return Machine(folder, connect, stop, start)


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
    """Read and give the same command once a period, as a loop does."""
    made, readings, ends = sent(**values), np.empty(len(COLUMNS)), time.monotonic() + seconds
    while time.monotonic() < ends:
        port.read(readings)
        port.write(made)
        time.sleep(port.facts.period_s)


def drive_in(port: Port, seconds: float) -> None:
    """Have the head go in: by volts, and by a position that goes on."""
    readings, begun = np.full(len(COLUMNS), np.nan), time.monotonic()
    port.read(readings)
    from_mm = np.nan_to_num(readings[COLUMNS.index("head_mm")])
    made = sent(insertion_v=USUAL_V, insertion_on=1.0)
    while (after_s := time.monotonic() - begun) < seconds:
        made[MESSAGE_COLUMNS.index("commands.head_mm")] = from_mm + USUAL_MM_PER_S * after_s
        port.read(readings)
        port.write(made)
        time.sleep(port.facts.period_s)


def greet(port: Port) -> None:
    drive(port, GREETING_S, released=1.0)


def read(port: Port, name: str) -> float:
    readings = np.full(len(COLUMNS), np.nan)
    assert port.read(readings) > 0
    return float(readings[COLUMNS.index(name)])


def wait(holds: Callable[[], bool], patience_s: float = PATIENCE_S) -> bool:
    ends = time.monotonic() + patience_s
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
    assert set(facts.most) >= BY_VOLTS or set(facts.most) >= BY_POSITIONS
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
    drive(port, 0.5)  # of a machine on a bus they are asked for
    last, ended = port.read(readings), time.monotonic()
    due = (ended - begun) / port.facts.period_s
    assert 0.5 * due < last - first < 1.1 * due
    assert np.isfinite(readings).all()
    assert readings[COLUMNS.index("head_valid")] == 1.0


def test_it_obeys(port: Port) -> None:
    before = read(port, "head_mm")
    drive_in(port, 0.6)
    assert read(port, "head_mm") > before + 5.0


def test_without_commands_it_comes_home_by_itself(port: Port) -> None:
    drive_in(port, 1.0)
    inside = read(port, "head_mm")
    assert inside > 10.0
    assert wait(lambda: read(port, "head_mm") < 1.0)


def test_once_it_acts_on_its_own_it_obeys_only_who_has_started_anew(port: Port) -> None:
    drive_in(port, 0.3)
    time.sleep(3.0 * port.facts.watchdog_s)
    assert wait(lambda: read(port, "head_mm") < 1.0)
    drive_in(port, 0.3)
    assert read(port, "head_mm") < 1.0
    greet(port)
    drive_in(port, 0.3)
    assert read(port, "head_mm") > 1.5


def test_reading_and_writing_never_wait(port: Port) -> None:
    """Far less than a period in the middle, though this machine may stand still in between."""
    readings, made = np.empty(len(COLUMNS)), sent()
    taken = []
    for _ in range(500):
        begun = time.perf_counter()
        port.read(readings)
        port.write(made)
        taken.append(time.perf_counter() - begun)
        time.sleep(0.5 * port.facts.period_s)
    assert np.median(taken) < 0.2 * port.facts.period_s


def full(port: Port, times: float) -> dict[str, float]:
    """A command of so many times what the machine says that it obeys at most."""
    names = {"commands.insertion_v", "commands.head_mm"} & set(port.facts.most)
    return {name: times * port.facts.most[name] for name in names} | {"insertion_on": 1.0}


def speed_mm_per_s(port: Port, times: float) -> float:
    """Of the head under a command, once it has its speed; by the machine's own clock."""
    drive(port, 0.3, **full(port, times))
    readings, place = np.empty(len(COLUMNS)), COLUMNS.index("head_mm")
    first = port.read(readings)
    from_mm = readings[place]
    drive(port, 0.3, **full(port, times))
    last = port.read(readings)
    return float((readings[place] - from_mm) / ((last - first) * port.facts.period_s))


@pytest.mark.sweep
@pytest.mark.parametrize("times", [10.0, pytest.param(1e300, marks=pytest.mark.soak)])
def test_more_than_it_says_is_cut_to_that(machine: Machine, port: Port, times: float) -> None:
    usual = speed_mm_per_s(port, 1.0)
    assert usual > 5.0
    port.close()
    come_home(machine)
    with closing(machine.connect()) as again:
        greet(again)
        assert speed_mm_per_s(again, times) == pytest.approx(usual, rel=0.1)
        drive(again, 0.5, **full(again, times))
        drive(again, TURNS_S * ("commands.head_mm" in again.facts.most), **full(again, -times))
        assert speed_mm_per_s(again, -times) == pytest.approx(-usual, rel=0.1)


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
        drive_in(port, 0.2)
        before = read(port, "head_mm")
        assert before > 1.0
        value = NO_NUMBERS[turn % len(NO_NUMBERS)]
        usual = {"insertion_v": USUAL_V, "head_mm": before, "insertion_on": 1.0, "released": 1.0}
        bad = {**usual, column.removeprefix("commands."): value}
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
    drive_in(port, 0.5)
    port.close()
    with closing(machine.connect()) as after:
        assert wait(lambda: read(after, "head_mm") < 1.0)
        # Its numbers begin anew, and without a greeting it is not obeyed either.
        drive_in(after, 0.3)
        assert read(after, "head_mm") < 1.0
        greet(after)
        drive_in(after, 0.3)
        assert read(after, "head_mm") > 1.5


@pytest.mark.sweep
def test_a_second_controller_is_refused_and_the_first_one_goes_on(
    machine: Machine, port: Port
) -> None:
    drive_in(port, 0.2)
    for _ in range(3):
        with pytest.raises(InputError, match="another process"):
            machine.connect()
        before = read(port, "head_mm")
        drive_in(port, 0.2)
        assert read(port, "head_mm") > before + 1.0


def test_a_machine_that_was_started_again_is_read_again_and_obeys_who_starts_anew(
    machine: Machine, port: Port
) -> None:
    drive_in(port, 0.5)
    machine.stop()
    readings = np.empty(len(COLUMNS))
    gone = port.read(readings)
    drive_in(port, 0.1)
    assert port.read(readings) == gone  # nothing new, and nobody waits for it
    machine.start()
    ends = time.monotonic() + PATIENCE_S
    while (back := port.read(readings)) <= gone and time.monotonic() < ends:
        drive_in(port, 0.1)
    assert back > gone
    drive_in(port, 0.5)
    port.read(readings)
    assert readings[COLUMNS.index("head_mm")] < 1.0  # it takes nobody for one that knows it
    drive_in(port, 0.1)
    assert port.read(readings) > back
    greet(port)
    drive_in(port, 0.3)
    assert read(port, "head_mm") > 1.5
