"""A recording as a machine in real time leaves it, made once."""

from pathlib import Path

import pytest

from opensuction.session.choice import CycleChoice, RigChoice
from tests.session.recorded import played


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recording")
    choice = CycleChoice(rig=RigChoice(machine="bench"), compensation="none")
    cycle = played.play(folder / "whole.mcap", choice)
    return played.without_truth(cycle.path, folder / "real.mcap")
