"""``device check`` as its users meet it."""

import io
import json
import os
import signal
import time
from contextlib import closing
from pathlib import Path

import pytest

from opensuction.cli.command.device import DeviceOptions, run
from opensuction.cli.entry import DONE, FAILED
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel.errors import InputError
from opensuction.machine.canopen import canopen_machine, device_file
from tests.cli.command import begun, wait_for

FILE = "Device file for a controller: "


class Terminal(io.StringIO):
    """Somebody at a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def real(tmp_path: Path) -> Path:
    """A device file of nodes that are not emulated."""
    text = device_file.EMULATED.read_text(encoding="utf-8")
    path = tmp_path / "real.toml"
    path.write_text(text.replace("in_silico = true", "in_silico = false"), encoding="utf-8")
    return path


def test_an_unknown_act_and_a_missing_file_are_refused(tmp_path: Path) -> None:
    for wrong, right in (("chek", "check"), ("hme", "home")):
        with pytest.raises(InputError, match=rf"unknown act '{wrong}': did you mean '{right}'\?"):
            run(DeviceOptions(wrong, tmp_path / "none.toml"))
    with pytest.raises(InputError, match="no such file"):
        run(DeviceOptions("check", tmp_path / "none.toml"))


def test_nothing_moves_without_a_person_who_says_yes(
    real: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("yes\n"))
    with pytest.raises(InputError, match="ask a person at the machine"):
        run(DeviceOptions("check", real, moves=True))
    for answer in ("", "no\n", "y\n"):
        monkeypatch.setattr("sys.stdin", Terminal(answer))
        with pytest.raises(InputError, match="nothing was moved"):
            run(DeviceOptions("check", real, moves=True))
    assert "Is the catheter out of everybody" in capsys.readouterr().err
    assert not (real.parent / "emulated").exists()  # nobody was on the bus


def test_nothing_is_homed_without_a_method_and_a_person_who_says_yes(
    real: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(InputError, match=r"its drives know where they are; give the method"):
        run(DeviceOptions("home", real))
    text = real.read_text(encoding="utf-8")
    real.write_text(text.replace("method = 0 ", "method = 37 ", 1), encoding="utf-8")
    monkeypatch.setattr("sys.stdin", Terminal("no\n"))
    with pytest.raises(InputError, match="nothing was moved"):
        run(DeviceOptions("home", real))
    said = capsys.readouterr().err
    assert "The insertion drive will take itself to be at 0 mm: it has to stand there now." in said
    assert "The head will move" not in said  # that is asked with --move
    assert not (real.parent / "emulated").exists()  # nobody was on the bus


def test_a_machine_that_a_controller_has_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / device_file.NAME
    path.write_text(device_file.EMULATED.read_text(encoding="utf-8"), encoding="utf-8")
    with (
        closing(canopen_machine.attach(tmp_path, THIS_COMPUTER)),
        pytest.raises(InputError, match="driven by another process"),
    ):
        run(DeviceOptions("check", path))


@pytest.mark.real_time
@pytest.mark.soak
def test_emulated_drives_are_checked_and_a_wrong_scale_is_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name = f"t{os.getpid()}-{time.monotonic_ns() % 10**9}"
    process = begun("drives", "--machine", "bench", "--name", name, cwd=tmp_path)
    try:
        said = wait_for("Ctrl-C takes them off the bus", process.stderr)
        (path,) = (Path(line[len(FILE) :]) for line in said.splitlines() if line.startswith(FILE))
        assert run(DeviceOptions("check", path)) == DONE
        shown = capsys.readouterr().out
        assert "node   1  insertion drive  vendor" in shown
        assert "✓ As its device file says" in shown
        text = path.read_text(encoding="utf-8")
        homed = tmp_path / "homed.toml"
        homed.write_text(text.replace("method = 0\n", "method = 37\n", 1), encoding="utf-8")
        assert run(DeviceOptions("home", homed)) == DONE
        shown = capsys.readouterr().out
        assert "insertion homed by method 37: at 0.00 mm, took itself to be at 0.0" in shown
        wrong = tmp_path / "wrong.toml"
        wrong.write_text(text.replace("gear_ratio = 3.0", "gear_ratio = 6.0"), encoding="utf-8")
        assert run(DeviceOptions("check", wrong, moves=True, as_json=True)) == FAILED
        found = json.loads(capsys.readouterr().out)
        # Of the head alone: valve and vacuum are as they should be.
        (problem,) = found["problems"]
        assert "wrong by a factor of 2 " in problem
        assert [one["axis"] for one in found["moves"]] == ["insertion", "valve"]
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60.0)
        for one in path.parent.iterdir():
            one.unlink()
        path.parent.rmdir()
