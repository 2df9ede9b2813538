import io

import pytest
from rich.console import Console

from opensuction.report import terminal
from opensuction.report.terminal import ASCII, UNICODE, Moment, depth_bar
from tests.report import example

CYCLE = (
    Moment("checking", 0.0, 0.0, 0.0, 0.0),
    Moment("inserting", 0.5, 0.0, 0.0, 120.0),
    Moment("inserting", 5.0, 45.0, 0.0, 120.0),
    Moment("suctioning", 10.5, 90.5, 1.0, 80.0),
    Moment("withdrawing", 19.5, 90.0, 1.0, 80.0),
    Moment("parked", 29.5, 0.1, 0.0, 120.0),
)


@pytest.fixture(autouse=True)
def _terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that moves its cursor, wherever the tests run: on a dumb one phases are plain lines."""
    monkeypatch.setenv("TERM", "xterm")


def _console(*, is_terminal: bool) -> tuple[Console, io.StringIO]:
    file = io.StringIO()
    return Console(file=file, force_terminal=is_terminal, width=100, color_system=None), file


def _run(console: Console) -> None:
    with terminal.LiveCycle(console, target_mm=90.0, cap_mm=95.0) as live:
        for moment in CYCLE:
            live.update(moment)


def test_without_a_terminal_each_phase_is_one_plain_line() -> None:
    console, file = _console(is_terminal=False)
    _run(console)
    lines = file.getvalue().splitlines()
    assert len(lines) == 4
    assert "\x1b" not in file.getvalue()
    assert " ".join(lines[1].split()) == "0.5 to 10.5 s Inserting tip 90.5 mm, vacuum 80 mmHg"


def test_on_a_terminal_phases_are_ticked_off() -> None:
    console, file = _console(is_terminal=True)
    _run(console)
    shown = file.getvalue()
    assert "✓ Inserting" in shown
    assert "✓ Withdrawing" in shown
    assert "T target 90.0 mm, C cap 95.0 mm" in shown


def test_cycle_that_ends_in_an_exception_still_gives_the_terminal_back() -> None:
    console, file = _console(is_terminal=True)
    try:
        with terminal.LiveCycle(console, target_mm=None, cap_mm=95.0) as live:
            live.update(CYCLE[2])
            raise KeyboardInterrupt
    except KeyboardInterrupt:
        pass
    assert file.getvalue().rstrip("\n").endswith("\x1b[?25h")  # cursor shown again
    assert "▶ Inserting" in file.getvalue()


def test_each_alarm_is_one_line_with_what_to_do() -> None:
    console, file = _console(is_terminal=False)
    terminal.print_summary(console, example.aborted())
    line = "High alarm, from 16.9 s on: the line vacuum is above its limit. Check the regulator."
    assert line in " ".join(file.getvalue().split())
    console, file = _console(is_terminal=False)
    terminal.print_summary(console, example.summary())
    assert " alarm, " not in file.getvalue()


def test_bar_grows_with_depth_and_marks_target_and_cap() -> None:
    shallow, deep = (depth_bar(tip, 90.0, 95.0, UNICODE) for tip in (10.0, 80.0))
    assert len(shallow) == len(deep)
    assert shallow.count("█") < deep.count("█")
    assert shallow.index("T") < shallow.index("C")
    assert "T" not in depth_bar(10.0, None, 95.0, ASCII)
    assert depth_bar(-30.0, 90.0, 95.0, ASCII).count("#") == 0


def test_summary_says_outcome_figures_limits_and_files_without_colour() -> None:
    console, file = _console(is_terminal=False)
    terminal.print_summary(console, example.summary(), ["runs/1/report.html"])
    shown = " ".join(file.getvalue().split())  # however it wraps
    assert "Completed" in shown
    assert "over the guideline; limit 24.0 s, guideline 15.0 s" in shown
    assert "Written: runs/1/report.html" in shown
    assert "not a medical device" in shown
    assert "No value in this run: lowest oxygen saturation, lowest heart rate" in shown


def test_summary_of_a_patient_has_the_patient_in_it() -> None:
    console, file = _console(is_terminal=False)
    terminal.print_summary(console, example.on_patient(vitals=example.VITALS))
    shown = " ".join(file.getvalue().split())
    for said in ("Lowest oxygen saturation 91.4 %", "Lung volume lost 412 mL", "2.3 to 15.7 cmH2O"):
        assert said in shown
    assert "No value" not in shown


def test_summary_of_an_abort_says_why() -> None:
    console, file = _console(is_terminal=False)
    terminal.print_summary(console, example.aborted())
    assert "Aborted at 17.0 s" in file.getvalue()
    assert "High alarm: the line vacuum is above its limit" in file.getvalue()


def test_console_without_unicode_gets_plain_characters() -> None:
    raw = io.BytesIO()
    with io.TextIOWrapper(raw, encoding="ascii", errors="strict") as file:
        console = Console(file=file, force_terminal=True, width=100, color_system=None)
        _run(console)
        terminal.print_summary(console, example.aborted())
        file.flush()
        assert b"x Inserting" in raw.getvalue()
