"""Distribution of tick times over a run of any length."""

from pathlib import Path

import numpy as np
import pytest

from opensuction.ipc.ring import RingWriter
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import RING
from opensuction.session.running.run import Tally

TOOK, SKIPPED = ROW_COLUMNS.index("loop.computed_s"), ROW_COLUMNS.index("loop.skipped")
SLOTS = 1000


def test_quantiles_hold_over_a_run_of_minutes(tmp_path: Path) -> None:
    """120,000 ticks: two minutes, of which only counts are kept."""
    took_s = np.random.default_rng(5).gamma(4.0, 2e-5, 120_000)
    took_s[[7, 80_000]] = 0.0345, 0.028
    tally = Tally(tmp_path)
    row = np.zeros(len(ROW_COLUMNS))
    with RingWriter(tmp_path / RING, ROW_COLUMNS, SLOTS, {}) as ring:
        for number, took in enumerate(took_s):
            row[TOOK], row[SKIPPED] = took, 2.0 * (number == 11)
            ring.write(row)
            if number % SLOTS == SLOTS - 1:
                tally.look()
    assert (tally.ticks, tally.missed) == (120_000, 2)
    for share in (0.5, 0.99, 0.999):
        assert tally.computed_s(share) == pytest.approx(np.quantile(took_s, share), abs=2e-6)
    assert tally.computed_s(1.0) == 0.0345


def test_nothing_is_said_of_no_tick(tmp_path: Path) -> None:
    assert np.isnan(Tally(tmp_path).computed_s(0.99))
