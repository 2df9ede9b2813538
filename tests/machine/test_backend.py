"""Backends of machines: the name in a folder decides which module is loaded."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.ring import RingWriter
from opensuction.kernel.errors import InputError
from opensuction.machine import port as machine_port
from opensuction.machine.port import BACKEND, EVERYTHING, NOTHING
from opensuction.machine.twin.live_judge import LiveJudge
from opensuction.machine.twin.twin_machine import TwinMachine
from opensuction.machine.twin.twin_process import SHOWN
from opensuction.simulation.machine_side import SHOWN_COLUMNS
from tests.cli.command import opensuction
from tests.machine import bare_machine
from tests.machine.bare_machine import BareMachine


@pytest.fixture
def bare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of another kind of machine."""
    bare_machine.prepare(tmp_path, monkeypatch)
    return tmp_path


def begin_older(folder: Path) -> None:
    """A twin as a version before `machine.kind` and capabilities has started it."""
    with RingWriter(folder / SHOWN, SHOWN_COLUMNS, 10, {"version": "0.1", "most": "{}"}) as ring:
        ring.write(np.zeros(len(SHOWN_COLUMNS)))


def test_a_folder_is_attached_to_by_the_kind_that_it_names(bare: Path) -> None:
    assert isinstance(machine_port.attach(bare, THIS_COMPUTER), BareMachine)
    assert machine_port.load(bare).hand_of(bare) is None
    assert machine_port.load(bare).capabilities_of(bare) == NOTHING


def test_a_twin_of_an_older_version_names_no_kind_and_is_attached_to(tmp_path: Path) -> None:
    begin_older(tmp_path)
    port = machine_port.attach(tmp_path, THIS_COMPUTER)
    port.close()
    assert isinstance(port, TwinMachine)
    assert port.facts.capabilities == EVERYTHING
    assert machine_port.load(tmp_path).capabilities_of(tmp_path) == EVERYTHING
    assert not (tmp_path / BACKEND).exists()


def test_a_folder_with_nothing_in_it_is_refused_in_one_line(tmp_path: Path) -> None:
    for opened in (
        partial(machine_port.attach, host=THIS_COMPUTER),
        machine_port.open_truth,
        machine_port.check_faults,
    ):
        with pytest.raises(InputError, match=f"no ring at .*{SHOWN}") as refused:
            opened(tmp_path)
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize("named", ["robot", "", "twin; rm", "opensuction.machine.twin"])
def test_an_unknown_kind_is_refused_with_those_that_are_known(named: str, tmp_path: Path) -> None:
    (tmp_path / BACKEND).write_text(named)
    with pytest.raises(InputError, match=r"unknown kind of machine .*; known: twin, canopen$"):
        machine_port.attach(tmp_path, THIS_COMPUTER)


def test_what_is_no_text_names_none_and_is_not_taken_for_a_twin(tmp_path: Path) -> None:
    begin_older(tmp_path)
    (tmp_path / BACKEND).write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="does not name the kind"):
        machine_port.load(tmp_path)
    (tmp_path / BACKEND).unlink()
    (tmp_path / BACKEND).mkdir()
    with pytest.raises(InputError, match="does not name the kind"):
        machine_port.load(tmp_path)


def test_a_machine_that_knows_no_truth_is_not_judged(bare: Path) -> None:
    with pytest.raises(InputError, match=r"\(bare\) tells no truth: only a twin is judged"):
        machine_port.open_truth(bare)


def test_no_fault_is_put_into_a_machine_that_takes_none(bare: Path) -> None:
    for options in (["--fault", "line-leak=0.5"], ["--mend"], ["--latency-ms", "1"], []):
        done = opensuction("inject", str(bare), *options, cwd=bare)
        assert done.returncode == 2
        assert done.stderr.startswith("opensuction: the machine in ")
        assert "(bare) takes no faults on request" in " ".join(done.stderr.split())


def test_a_truth_that_lacks_what_is_judged_is_refused_by_name(tmp_path: Path) -> None:
    begin_older(tmp_path)
    truth = machine_port.open_truth(tmp_path)
    truth.columns = tuple(name for name in SHOWN_COLUMNS if name != "truth.piece_mm")
    with pytest.raises(InputError, match=r"truth lacks truth\.piece_mm: it cannot be judged"):
        LiveJudge(truth, 30.0)


def test_every_kind_has_what_a_backend_has(tmp_path: Path) -> None:
    for name in machine_port.MODULES:
        machine_port.name_backend(tmp_path, name)
        found = machine_port.load(tmp_path)
        assert callable(found.attach)
        assert callable(found.capabilities_of)
        assert callable(found.hand_of)
        assert callable(found.truth_of)
