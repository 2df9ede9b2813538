"""A recording as a machine in real time leaves it, made once; work on it in this process."""

from pathlib import Path

import pytest

from opensuction.session.choice import CycleChoice, RigChoice
from tests.console.history.past import work_here
from tests.session.recorded import played


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recording")
    choice = CycleChoice(rig=RigChoice(machine="bench"), compensation="none")
    cycle = played.play(folder / "whole.mcap", choice)
    return played.without_truth(cycle.path, folder / "real.mcap")


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Recordings are worked on in this process: that another one does it is not the point."""
    work_here(monkeypatch)
