"""Progress that is shown to a waiting person: compilation, its extent, its time."""

import threading
from typing import Any

import pytest
from rich.table import Table

from opensuction.cli import progress
from opensuction.cli.progress import PlainConsole, ProgressTeller
from opensuction.kernel.compiler import compilation
from opensuction.kernel.compiler.compilation import Compilation, Stage


class Compiler:
    """Tells of a compilation as the kernel does, until it may go on."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.hear: Any = None
        self.told = threading.Event()
        monkeypatch.setattr(compilation, "listen", self.listen)

    def listen(self, listener: Any) -> None:
        self.hear = listener or self.hear

    def work(self) -> str:
        self.hear(Compilation("a.root", Stage.BEGUN, 0))
        self.hear(Compilation("a.root", Stage.TRANSLATED, 41))
        assert self.told.wait(20.0)
        self.hear(Compilation("a.root", Stage.OPTIMISING, 41))
        self.hear(Compilation("a.root", Stage.FINISHED, 42))
        return "done"


@pytest.fixture
def compiler(monkeypatch: pytest.MonkeyPatch) -> Compiler:
    monkeypatch.setattr(progress, "SHORT_S", 0.0)
    monkeypatch.setattr(progress, "NEWS_S", 0.01)
    return Compiler(monkeypatch)


def test_a_compilation_is_told_with_how_far_it_is(
    compiler: Compiler, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def tell(self: ProgressTeller, line: str) -> None:
        original(self, line)
        if "functions" in line:
            compiler.told.set()

    original = ProgressTeller.tell
    monkeypatch.setattr(ProgressTeller, "tell", tell)
    assert ProgressTeller().wait(compiler.work, "Preparing") == "done"
    said = capsys.readouterr()
    assert said.out == ""
    lines = said.err.splitlines()
    assert lines[0] == "Compiling the control core: once for this version, up to a minute"
    assert lines[1] == "Compiling: translating, 41 functions, 0 s"
    assert lines[-1] == "Compiled in 0 s, and kept for the next time"


def test_what_compiles_nothing_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert ProgressTeller().wait(lambda: 42, "Preparing") == 42
    assert capsys.readouterr() == ("", "")


def test_what_the_work_raises_is_raised_here() -> None:
    def work() -> None:
        raise ValueError("as it is")

    with pytest.raises(ValueError, match="as it is"):
        ProgressTeller().wait(work)


@pytest.mark.parametrize("name", ["runs/[a]/report.html", "[/x] a hazard", "a :bug: b", r"a\[b]"])
def test_what_a_person_named_is_printed_as_it_is(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Neither swallowed, nor taken for the end of a style that was not begun."""
    table = Table()
    table.add_column(name)
    table.add_row(name)
    console = PlainConsole()
    console.print(name)
    console.print(table)
    assert capsys.readouterr().out.count(name) == 3


def test_how_far_the_work_is_shows_in_a_line_now_and_then(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    teller = ProgressTeller()
    teller.show("1 of 9 cycles")  # too early for a line
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(progress, "NEWS_S", 0.0)
    teller.show("8 of 9 cycles")
    assert capsys.readouterr().err == "8 of 9 cycles\n"
