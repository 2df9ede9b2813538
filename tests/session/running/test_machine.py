"""A machine that an earlier run has left: taken up as it is, or named as another one."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.controller import configuration
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import name_of
from opensuction.machine.twin.twin_machine import TwinMachine
from opensuction.records.records import Records
from opensuction.runtime import machine_folder
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.running import basis, machine

NAME = f"test-taken-up-{os.getpid()}"


def prepared() -> Prepared:
    choice = CycleChoice(RigChoice("bench"), compensation=name_of(CompensationKind.NONE))
    return cycle_run.prepare(resolution.resolve(choice))


@pytest.fixture(scope="module")
def playing() -> Iterator[Prepared]:
    made = prepared()
    twin = machine.begin(NAME, made, None, anew=False).twin
    assert isinstance(twin, subprocess.Popen)
    yield made
    machine.end(machine_folder.find(NAME))
    assert twin.wait(5.0) == 0
    machine_folder.clear(machine_folder.find(NAME))
    machine_folder.find(NAME).rmdir()


@pytest.fixture
def begun(playing: Prepared) -> Iterator[Prepared]:
    """Of a machine whose twin plays, and whom nobody looks after; its files come back as begun."""
    folder = machine_folder.find(NAME)
    names = machine_folder.CONFIGURATION, machine_folder.BEGUN_WITH, machine_folder.BASIS
    kept = {folder / name: (folder / name).read_bytes() for name in names}
    yield playing
    for path, data in kept.items():
        path.write_bytes(data)


def test_what_people_have_set_on_it_stays_as_they_set_it(begun: Prepared) -> None:
    folder = machine_folder.find(NAME)
    present = configuration.from_json((folder / machine_folder.CONFIGURATION).read_text())
    plan = present.settings.plan._replace(dwell_s=0.5 * present.settings.plan.dwell_s)
    changed = present._replace(settings=present.settings._replace(plan=plan))
    text = configuration.to_json(changed)
    (folder / machine_folder.CONFIGURATION).write_text(text)
    basis.write(folder, basis.of(begun)._replace(version=2))
    again = machine.begin(NAME, prepared(), None, anew=False)
    assert again.twin is None
    assert (folder / machine_folder.CONFIGURATION).read_text() == text
    assert basis.read(folder).version == 2
    with closing(TwinMachine(folder)) as port:
        assert port.facts.in_silico


def test_records_that_take_no_alarm_are_refused_before_a_machine_begins(tmp_path: Path) -> None:
    database = str(tmp_path / "records.db")
    with Records.open(database) as records, records.database.writing() as connection:
        connection.exec_driver_sql(
            "CREATE TRIGGER refused BEFORE INSERT ON alarm "
            "BEGIN SELECT RAISE(ABORT, 'no more'); END"
        )
    with pytest.raises(InputError, match="does not take the entry: no more"):
        machine.check_records(database)


def test_one_that_was_begun_otherwise_is_refused_and_left_alone(begun: Prepared) -> None:
    folder = machine_folder.find(NAME)
    text = (folder / machine_folder.CONFIGURATION).read_text()
    controller = begun.loop.controller
    limits = controller.limits._replace(in_airway_s=0.5 * controller.limits.in_airway_s)
    other = begun.loop._replace(controller=controller._replace(limits=limits))
    with pytest.raises(InputError, match="still plays, with other settings"):
        machine.begin(NAME, begun._replace(loop=other), None, anew=False)
    (folder / machine_folder.BEGUN_WITH).unlink()
    with pytest.raises(InputError, match="still plays, with other settings"):
        machine.begin(NAME, begun, None, anew=False)
    assert (folder / machine_folder.CONFIGURATION).read_text() == text
