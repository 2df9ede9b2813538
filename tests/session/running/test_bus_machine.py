"""A machine on a bus: which choices fit it, and what its folder keeps for the next controller."""

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from opensuction.host.host import finish
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.machine import port
from opensuction.machine.canopen import device_file
from opensuction.machine.drives import drives_process
from opensuction.machine.twin import twin_machine
from opensuction.runtime import controller_memory, machine_folder
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.nonvolatile_memory import NonvolatileMemory
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.cycle.resolution import ResolvedCycle
from opensuction.session.running import bus_machine, machine
from opensuction.session.running.bus_machine import BusMachine
from opensuction.simulation.machine_side import MachineSide
from tests.session.running.test_predecessor import REST_S, leave

NAME = f"test-bus-{os.getpid()}"


def resolved(compensation: str = "none", taught_mm: float | None = None) -> ResolvedCycle:
    return resolution.resolve(
        CycleChoice(RigChoice("bench"), compensation=compensation, taught_mm=taught_mm)
    )


@pytest.fixture(scope="module")
def prepared() -> Prepared:
    return cycle_run.prepare(resolved())


def device(folder: Path, *changes: tuple[str, str]) -> Path:
    """A device file that is the emulated drives' but for some words."""
    text = device_file.EMULATED.read_text(encoding="utf-8")
    for before, after in changes:
        assert text.count(before) == 1
        text = text.replace(before, after)
    path = folder / "machine.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def real(tmp_path: Path) -> BusMachine:
    return bus_machine.load(device(tmp_path, ("in_silico = true", "in_silico = false")))


@pytest.fixture
def emulated(tmp_path: Path, prepared: Prepared) -> BusMachine:
    """A machine with a twin behind its nodes."""
    drives_process.prepare(tmp_path, prepared.loop, prepared.start, seed=1)
    return bus_machine.load(device(tmp_path))


@pytest.fixture(autouse=True)
def _own_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a machine must not forget lies in the user's data folder."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


@pytest.fixture
def folder() -> Iterator[Path]:
    made = machine_folder.make(NAME)
    yield made
    machine_folder.clear(made)
    made.rmdir()


def test_a_bus_of_this_computer_is_named_by_its_whole_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    device(tmp_path)
    monkeypatch.chdir(tmp_path)
    found = bus_machine.load(Path("machine.toml"))
    laid = tmp_path / "elsewhere"
    laid.mkdir()
    bus_machine.lay(laid, found)
    assert found.device.bus.channel == str(tmp_path / "emulated")
    assert device_file.find(laid) == found.device
    assert port.kind_of(laid) == port.CANOPEN


def test_the_address_of_another_bus_is_left_as_it_is(tmp_path: Path) -> None:
    path = device(
        tmp_path,
        ('interface = "unix" ', 'interface = "socketcan" '),
        ('channel = "emulated"', 'channel = "can0"'),
    )
    found = bus_machine.load(path)
    assert found.text == path.read_text(encoding="utf-8")
    assert found.device.bus.channel == "can0"
    assert found.twin is None


@pytest.mark.parametrize(
    ("chosen", "starts_itself", "said"),
    [
        (resolved(), True, "a person starts each"),
        (resolved("preview"), False, "identified on the twin"),
        (
            resolution.resolve(CycleChoice(RigChoice("clinical"), compensation="none")),
            False,
            "taught on the twin",
        ),
    ],
)
def test_what_only_a_twin_can_do_is_not_asked_of_a_real_machine(
    real: BusMachine, chosen: ResolvedCycle, starts_itself: bool, said: str
) -> None:
    with pytest.raises(InputError, match=said) as refused:
        bus_machine.check_choice(real, chosen, starts_itself)
    assert len(str(refused.value).splitlines()) == 1


def test_a_real_machine_with_its_own_length_and_model_is_served(real: BusMachine) -> None:
    chosen = resolution.resolve(
        CycleChoice(RigChoice("clinical"), compensation="none", taught_mm=70.0)
    )
    bus_machine.check_choice(real, chosen, starts_itself=False)


@pytest.mark.parametrize(
    ("park_mm", "highest", "key"), [(-160.5, 450.0, "lowest"), (-160.0, 90.0, "highest")]
)
def test_a_range_that_the_head_has_to_leave_is_refused(
    tmp_path: Path, prepared: Prepared, park_mm: float, highest: float, key: str
) -> None:
    found = bus_machine.load(device(tmp_path, ("highest = 450.0", f"highest = {highest}")))
    controller = prepared.loop.controller
    limits = controller.limits._replace(park_head_mm=park_mm)
    loop = prepared.loop._replace(controller=controller._replace(limits=limits))
    with pytest.raises(InputError, match=f"insertion.{key} of 'emulated'"):
        bus_machine.check_prepared(found, prepared._replace(loop=loop), starts_itself=False)


def test_drives_that_play_another_machine_are_refused(
    emulated: BusMachine, prepared: Prepared
) -> None:
    bus_machine.check_prepared(emulated, prepared, starts_itself=True)
    choice = prepared.resolved.choice
    other = choice._replace(rig=choice.rig._replace(seed=2))
    with pytest.raises(InputError, match="the options that they were started with"):
        bus_machine.check_prepared(
            emulated, cycle_run.prepare(resolution.resolve(other)), starts_itself=True
        )


def test_nobody_gives_oxygen_to_a_patient_whom_no_folder_names(
    tmp_path: Path, prepared: Prepared
) -> None:
    found = bus_machine.load(device(tmp_path))
    passes = prepared.loop.controller.service.passes._replace(asks_for_oxygen=True)
    controller = prepared.loop.controller
    controller = controller._replace(service=controller.service._replace(passes=passes))
    asking = prepared._replace(loop=prepared.loop._replace(controller=controller))
    with pytest.raises(InputError, match="--preoxygenation skipped"):
        bus_machine.check_prepared(found, asking, starts_itself=True)
    bus_machine.check_prepared(found, asking, starts_itself=False)


@pytest.mark.usefixtures("folder")
def test_the_ventilator_behind_the_nodes_is_set(
    emulated: BusMachine, prepared: Prepared, monkeypatch: pytest.MonkeyPatch
) -> None:
    changed = dict[Path, MachineSide]()
    monkeypatch.setattr(twin_machine, "change", changed.__setitem__)
    running = machine.begin(NAME, prepared, None, anew=False, bus=emulated)
    running.ventilate(full=False)
    assert emulated.twin is not None
    assert list(changed) == [emulated.twin]
    (side,) = changed.values()
    assert side.wiring.watchdog.silence_s == 0.0  # as the drives' twin


def test_the_next_controller_keeps_what_the_last_one_knew(
    emulated: BusMachine, prepared: Prepared, folder: Path
) -> None:
    running = machine.begin(NAME, prepared, None, anew=False, bus=emulated)
    assert running.in_silico
    assert running.about.machine.is_twin
    assert running.about.heading["device"] == "emulated"
    leave(folder, -500.0, Phase.ABORTING)
    running.end()
    for _ in range(2):  # whoever begins, and begins again
        running = machine.begin(NAME, prepared, None, anew=False, bus=emulated)
        before = controller_memory.read_before(folder)
        assert before is not None
        assert before.phase == Phase.ABORTING
        assert before.kept.episode.rest_left_s == pytest.approx(REST_S)
        assert running.lost is None
        assert port.kind_of(folder) == port.CANOPEN
    machine.begin(NAME, prepared, None, anew=True, bus=emulated)
    assert controller_memory.read_before(folder) is None


def switch_off(folder: Path) -> None:
    """The computer was off: what lay in its memory is gone."""
    machine_folder.clear(folder)


def test_a_controller_keeps_what_was_known_before_the_computer_was_off(
    emulated: BusMachine, prepared: Prepared, folder: Path
) -> None:
    running = machine.begin(NAME, prepared, None, anew=False, bus=emulated)
    assert running.recalled is None
    assert running.about.memory is not None
    row = dict.fromkeys(ROW_COLUMNS, 0.0)
    row["state.core.upkeep.episode.rest_left_s"] = REST_S
    row["state.core.upkeep.episode.passes"] = 2.0
    row["state.core.procedure.phase"] = float(Phase.SUCTIONING)
    memory = NonvolatileMemory(Path(running.about.memory), THIS_COMPUTER)
    memory.take(np.array(list(row.values())), prepared.loop.controller.service.passes)
    assert finish(memory.close(60.0), THIS_COMPUTER.clock)
    switch_off(folder)
    for is_first in (True, False):  # whoever begins, and begins again
        running = machine.begin(NAME, prepared, None, anew=False, bus=emulated)
        assert (running.recalled is not None) == is_first
        before = controller_memory.read_before(folder)
        assert before is not None
        assert before.phase == Phase.SUCTIONING
        assert before.kept.episode.passes == 2
        assert before.kept.episode.rest_left_s == pytest.approx(REST_S)
        assert before.off_s < 60.0
    switch_off(folder)
    machine.begin(NAME, prepared, None, anew=True, bus=emulated)
    switch_off(folder)
    assert machine.begin(NAME, prepared, None, anew=False, bus=emulated).recalled is None


@pytest.mark.usefixtures("folder")
def test_a_memory_that_cannot_be_read_stops_a_start(
    emulated: BusMachine, prepared: Prepared
) -> None:
    path = machine.memory_of(NAME)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("{", encoding="utf-8")
    with pytest.raises(InputError, match="--anew"):
        machine.begin(NAME, prepared, None, anew=False, bus=emulated)
    assert path.exists()
    machine.begin(NAME, prepared, None, anew=True, bus=emulated)
    assert not path.exists()


@pytest.mark.usefixtures("folder")
def test_what_a_twin_was_given_goes_with_the_computer(
    prepared: Prepared, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(twin_machine, "start", lambda *_: None)
    assert machine.begin(NAME, prepared, None, anew=False).about.memory is None


def test_a_patient_on_a_bus_is_another_one_than_a_twin(
    emulated: BusMachine, prepared: Prepared, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(twin_machine, "start", lambda *_: None)
    machine.begin(NAME, prepared, None, anew=False)
    leave(folder, 60.0)
    machine.begin(NAME, prepared, None, anew=False, bus=emulated)
    assert controller_memory.read_before(folder) is None
    leave(folder, 60.0)
    machine.begin(NAME, prepared, None, anew=False)
    assert controller_memory.read_before(folder) is None


def test_a_controller_that_still_runs_is_taken_up_with_the_same_device_file_alone(
    emulated: BusMachine, prepared: Prepared, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine.begin(NAME, prepared, None, anew=False, bus=emulated)
    controls = folder / machine_folder.CONTROLS
    monkeypatch.setattr(machine, "holder", lambda path: 1 if path == controls else None)
    assert machine.begin(NAME, prepared, None, anew=False, bus=emulated).twin is None
    other = emulated._replace(text=emulated.text + "\n# another one\n")
    with pytest.raises(InputError, match="with other settings"):
        machine.begin(NAME, prepared, None, anew=False, bus=other)
    with pytest.raises(InputError, match="with other settings"):
        machine.begin(NAME, prepared, None, anew=False)
