"""The campaign on a module of its own: a process for each mutant, no file changed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tools.mutation.__main__ import everything, main, target
from tools.mutation.campaign import ROOT, Result, Survivor, Target


def campaign(*arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "src")])}
    return subprocess.run(
        [sys.executable, "-m", "tools.mutation", *arguments],
        env=environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.soak
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_every_mistake_in_the_lights_is_noticed(tmp_path: Path) -> None:
    out = tmp_path / "score.json"
    source = target("safety.alarm.alarm_signal:is_lit").path()
    before = source.read_bytes()
    done = campaign(
        "safety.alarm.alarm_signal:is_lit", "--workers", "2", "--out", str(out), "--least", "100"
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""
    assert source.read_bytes() == before
    score = json.loads(out.read_text(encoding="utf-8"))
    assert score["mutants"] == score["killed"] > 0
    assert score["score_percent"] == 100.0
    (module,) = score["modules"]
    assert module["module"] == "opensuction.safety.alarm.alarm_signal"
    assert module["survivors"] == []


def test_an_unknown_module_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["mutation", "safety.nonsense"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert "unknown module safety.nonsense; one of safety.alarm.alarm, " in capsys.readouterr().err


def test_every_module_of_safety_is_tried_with_tests_that_exist() -> None:
    assert "procedure.cycle.transition" in everything()
    assert {"safety.governor.governor", "safety.watch.watch", "safety.alarm.alarm"} <= set(
        everything()
    )
    for name in everything():
        chosen = target(name)
        assert chosen.path().is_file()
        assert chosen.test_files()


def test_a_module_without_tests_is_an_error() -> None:
    with pytest.raises(FileNotFoundError, match=r"no tests for opensuction\.safety\.limits"):
        Target("opensuction.safety.limits", ("tests/safety/test_nowhere.py",)).test_files()


def test_the_score_is_the_share_that_was_noticed() -> None:
    survivor = Survivor(line=3, column=1, change="a -> b")
    assert Result("m", 4, 3, 1, (survivor,), 1.0).score_percent == 75.0
    assert Result("m", 0, 0, 0, (), 1.0).score_percent == 100.0
