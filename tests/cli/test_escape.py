"""Nothing that a file or a person names speaks to the terminal or ends in a traceback."""

import io
import json
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from opensuction.cli import app, entry
from opensuction.cli.command.identify import IdentifyOptions
from opensuction.cli.progress import PlainConsole, ProgressTeller
from opensuction.recording.cycle_file import frame
from opensuction.recording.cycle_file.frame import Heading
from tests.cli.command import Ran, opensuction, opensuction_process, run_main
from tests.cli.test_identify import motion

HOSTILE = {
    "colour": ("a\x1b[31mb", r"a\x1b[31mb"),
    "title": ("\x1b]0;owned\x07 (mm)", r"\x1b]0;owned\x07 (mm)"),
    "eight bits": ("a\x9b2Jb", r"a\x9b2Jb"),
    "no UTF-8": ("n\udcff\udc9b", r"n\udcff\udc9b"),
    "another line": ("a\nopensuction: OK\r", r"a\nopensuction: OK\r"),
    "the other way": ("a\u202egpj.csv", r"a\u202egpj.csv"),
}
"""Text of a person or a file, and what is seen of it."""
LACKING = {
    "ascii": r"H\xf6he (\xb5m), \u03c6",
    "latin-1": r"Höhe (µm), \u03c6",
    "utf-8": "Höhe (µm), φ",
}
"""How a heading shows on terminals of these letters."""


class Terminal:
    """What a console of one encoding was sent."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, encoding: str = "utf-8") -> None:
        self._bytes = io.BytesIO()
        self.stream = io.TextIOWrapper(self._bytes, encoding=encoding)
        monkeypatch.setattr(sys, "stdout", self.stream)

    @property
    def shown(self) -> str:
        self.stream.flush()
        return self._bytes.getvalue().decode(self.stream.encoding)


def print_everyhow(console: Console, text: str) -> None:
    """A line, a styled one, a sentence, and a table's heading and cells, of strings and texts."""
    table = Table(box=None, pad_edge=False)
    table.add_column(text, no_wrap=True)
    table.add_column("next", no_wrap=True)
    table.add_row(text, "cell")
    table.add_row(Text(text), Text("cell"))
    console.print(text)
    console.print(Text(text, style="bold"))
    console.print(Padding(Text(text), (0, 0, 0, 2)))
    console.print(table)


@pytest.mark.parametrize("case", [name for name in HOSTILE if name != "another line"])
def test_text_never_speaks_to_the_terminal(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal(monkeypatch)
    raw, seen = HOSTILE[case]
    print_everyhow(PlainConsole(), raw)
    assert terminal.shown.replace("\n", "").isprintable()
    # Of a text, as against a string, the library drops the bell.
    assert terminal.shown.count(seen) + terminal.shown.count(seen.replace(r"\x07", "")) >= 6
    *_, heading_line, first, second = terminal.shown.splitlines()
    assert heading_line.index("next") == first.index("cell") == second.index("cell")


def test_a_name_begins_no_line_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal(monkeypatch)
    raw, seen = HOSTILE["another line"]
    console = PlainConsole()
    console.print(f"Report: {raw}")
    console.print(Text(f"Written: {raw}"))
    assert terminal.shown.splitlines() == [f"Report: {seen}", r"Written: a\nopensuction: OK"]


@pytest.mark.parametrize("encoding", LACKING)
def test_letters_that_a_terminal_lacks_are_escapes(
    encoding: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = Terminal(monkeypatch, encoding)
    print_everyhow(PlainConsole(), "Höhe (µm), φ")
    assert terminal.shown.count(LACKING[encoding]) == 6
    *_, heading_line, first, second = terminal.shown.splitlines()
    assert heading_line.index("next") == first.index("cell") == second.index("cell")


@pytest.mark.parametrize("case", HOSTILE)
def test_progress_and_refusals_are_lines_of_plain_letters(
    case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    raw, seen = HOSTILE[case]
    ProgressTeller().tell(raw)
    assert capsys.readouterr().err == f"{seen}\n"
    for arguments in (
        ("cycle", "--machine", raw),
        ("cycle", "--fault", raw),
        ("cycle", f"--{raw}"),
        (raw,),
        ("replay", f"{raw}.mcap"),
        ("identify", f"{raw}.csv", "--input", raw, "--output", "y"),
        ("audit", "--database", f"{raw}.db"),
        ("run", "--name", raw),
    ):
        ran = opensuction(*arguments, cwd=tmp_path)
        assert (ran.returncode, ran.stdout) == (2, "")
        last = ran.stderr.splitlines()[-1]
        assert last.startswith("opensuction: ")
        assert ran.stderr.replace("\n", "").isprintable()
    assert list(tmp_path.iterdir()) == []


def record(file: Path) -> None:
    """A recording with letters beyond ASCII in the names of its columns, and a hostile one."""
    rows = [f"{t!r},{x!r},{y!r},0" for t, x, y in np.column_stack(motion()).tolist()]
    names = "t_s,Höhe (µm),φ (mm),x\x1b[2J (mm)"
    file.write_text("\n".join([names, *rows]) + "\n", encoding="utf-8")


COLUMNS = ("--input", "Höhe (µm)", "--output", "φ (mm)", "--model", "dahl")


def run_in_ascii(*arguments: str, cwd: Path) -> Ran:
    """Run a command in this process, with streams that have no other letters."""
    streams = [io.TextIOWrapper(io.BytesIO(), encoding="ascii") for _ in range(2)]
    status = run_main(*arguments, cwd=cwd, stdout=streams[0], stderr=streams[1])
    for stream in streams:
        stream.seek(0)
    return Ran(status, streams[0].read(), streams[1].read())


def run_in_c(*arguments: str, cwd: Path) -> Ran:
    """Run a command in a process whose system knows no other letters."""
    environment = {"LC_ALL": "C", "PYTHONUTF8": "0"}
    return opensuction_process(*arguments, cwd=cwd, environment=environment)


@pytest.mark.parametrize("run", [run_in_ascii, run_in_c])
def test_a_terminal_without_the_letters_of_a_recording_shows_its_fit(
    run: Callable[..., Ran], tmp_path: Path
) -> None:
    seen = LACKING["ascii"]
    record(tmp_path / "n\udcff\x1b[1m.csv")
    ran = run("identify", "n\udcff\x1b[1m.csv", *COLUMNS, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert f"n\\udcff\\x1b[1m.csv: {seen.split(',', maxsplit=1)[0]} to \\u03c6 (mm)" in ran.stderr
    assert "Written: runs/" in ran.stdout
    assert ran.stdout.replace("\n", "").isprintable()


def test_results_of_a_file_that_is_no_utf_8_are_whole(tmp_path: Path) -> None:
    record(tmp_path / "n\udcff.csv")
    ran = opensuction("identify", "n\udcff.csv", *COLUMNS, "--json", "--out", "o", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert json.loads(ran.stdout)["recording"]["file"] == "n\udcff.csv"
    written = tomllib.loads((tmp_path / "o" / "identification.toml").read_text(encoding="utf-8"))
    assert written["recording"]["file"] == r"n\udcff.csv"
    assert r"n\udcff.csv" in (tmp_path / "o" / "report.html").read_text(encoding="utf-8")


def test_an_unknown_column_lists_the_others_in_plain_letters(tmp_path: Path) -> None:
    record(tmp_path / "a.csv")
    ran = opensuction("identify", "a.csv", "--input", "Hohe", "--output", "φ (mm)", cwd=tmp_path)
    assert ran.returncode == 2
    assert r"x\x1b[2J (mm)" in ran.stderr
    assert "\x1b" not in ran.stderr


def test_a_heading_takes_the_name_of_any_file() -> None:
    about = {"machine": "m\udcff.toml", "patient": "Höhe.toml", "protocol": "a\x1b[1m"}
    made = Heading("0.1.0", "{}", "a", "b", 1, about)
    read = frame.from_metadata("a.mcap", frame.to_metadata(made))
    assert read.about == {**about, "machine": r"m\udcff.toml"}


def test_columns_are_known_where_the_locale_takes_their_letters_for_bytes() -> None:
    bytes_each = "Höhe (µm)".encode().decode("ascii", "surrogateescape")
    given = {
        "file": Path(f"{bytes_each}.csv"),
        "input": [bytes_each, "plain"],
        "output": "Höhe (µm)",
        "time": None,
        "input_unit": "\udcc2\udcb5m",
        "output_unit": "\udcff",
    }
    options = entry._fill(IdentifyOptions, _Given(given))
    assert options.recording.input == ("Höhe (µm)", "plain")
    assert (options.recording.output, options.recording.time) == ("Höhe (µm)", None)
    assert (options.recording.input_unit, options.recording.output_unit) == ("µm", "\udcff")
    assert options.recording.file == Path(f"{bytes_each}.csv")  # as the system knows it


class _Given(dict[str, object]):
    """What was given; nothing for all else."""

    def __missing__(self, _: str) -> None:
        return None


def test_streams_lose_no_command_a_letter(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal(monkeypatch, "ascii")
    monkeypatch.setattr(sys, "argv", ["opensuction", "--help"])
    with pytest.raises(SystemExit) as ended:
        app.main()
    assert ended.value.code == 0
    sys.stdout.write("5 µm \udcff\n")
    assert terminal.shown.endswith("5 \\xb5m \\udcff\n")
