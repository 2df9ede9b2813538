"""The shipped conduits: what is in the files, and that their recordings still say so."""

from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from opensuction.settings import conduit_file

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "data" / "mrd"
SETTLED = 50
"""The load switches on within the first .5 s at 100 Hz."""
COLUMNS = {"motor_deg": 1, "spindle_deg": 2}


@pytest.mark.parametrize("name", conduit_file.NAMES)
def test_a_file_says_where_it_comes_from_and_what_it_leaves(name: str) -> None:
    file = resources.files("opensuction.settings") / "conduit" / f"{name}.toml"
    head = file.read_text(encoding="utf-8").split("recording =")[0]
    for said in ("University of Minnesota", "10.1109/LRA.2018.2849862", "Open Database License"):
        assert said in head
    shipped = conduit_file.load(name)
    assert np.all(shipped.conduit.gains >= 0.0)
    # A model of the head's way alone leaves about what repeats of a stroke scatter by.
    assert shipped.residual_mm < 1.6 * shipped.scatter_mm


def test_every_file_has_a_name() -> None:
    folder = resources.files("opensuction.settings") / "conduit"
    files = {entry.name for entry in folder.iterdir() if entry.name.endswith(".toml")}
    assert files == {f"{name}.toml" for name in conduit_file.NAMES}


@pytest.mark.skipif(not FOLDER.exists(), reason="real recordings are not here")
@pytest.mark.parametrize("name", conduit_file.NAMES)
def test_a_fit_anew_is_the_shipped_conduit(name: str) -> None:
    recording, column, _ = conduit_file.source(name)
    table = np.loadtxt(FOLDER / f"{recording}.csv", delimiter=",", skiprows=1)[SETTLED:]
    again = conduit_file.fit(name, table[:, COLUMNS[column]], table[:, 3])
    shipped = conduit_file.load(name)
    # Files are rounded to a part in a hundred thousand.
    assert again.residual_mm == pytest.approx(shipped.residual_mm, abs=1e-4)
    assert again.scatter_mm == pytest.approx(shipped.scatter_mm, abs=1e-4)
    assert again.mm_per_deg == pytest.approx(shipped.mm_per_deg, rel=1e-5)
    assert again.conduit.gains == pytest.approx(shipped.conduit.gains, abs=1e-3)
