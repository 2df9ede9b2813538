"""A trial that is broken off by its user keeps what is done, at once."""

import json
import signal
import time
from pathlib import Path

import pytest

from opensuction.evidence.trial import trial
from tests.cli.command import begun, opensuction

pytestmark = pytest.mark.real_time


@pytest.mark.sweep
def test_ctrl_c_keeps_what_a_trial_has_done_and_says_how_to_go_on(tmp_path: Path) -> None:
    """Within a second; what comes of it is what a trial comes to that nobody broke off."""
    few = ("trial", "--cycles", "12", "--cohort", "neonate", "--faults", "none", "--workers", "1")
    with begun(*few, "--out", "t", cwd=tmp_path) as process:
        log = tmp_path / "t" / trial.NAME
        while not log.exists() or log.read_bytes().count(b"\n") < 3:
            time.sleep(0.05)
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
        began_s = time.monotonic()
        _, words = process.communicate(timeout=20)
        assert time.monotonic() - began_s < 5.0  # a second, on a machine that has one to spare
    assert process.returncode == 130
    line = words.splitlines()[-1]
    assert line.startswith("opensuction: interrupted; ")
    assert line.endswith(" of 12 cycles are kept; go on with: opensuction trial --resume --out t")
    found = trial.read(tmp_path / "t")
    assert 2 <= len(found.parts) < 12
    assert [path.name for path in (tmp_path / "t").iterdir()] == [trial.NAME]
    done = opensuction("trial", "--resume", "--out", "t", "--json", cwd=tmp_path)
    assert json.loads(done.stdout)["complete"], done.stderr
    assert "of them there already" in done.stderr
    whole = trial.read(tmp_path / "t").parts
    assert whole.items() > found.parts.items()
    last = trial.list_parts(found.heading.trial, 12)[11]
    assert whole[11] == trial.play(last)
    again = opensuction("trial", "--resume", "--out", "t", "--json", cwd=tmp_path)
    assert json.loads(again.stdout)["cycles_per_s"] is None  # nothing was left to do
