"""Progress of a command on stderr: lines, a spinner on a terminal, news of compilations."""

import threading
import time
from collections.abc import Callable
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, TypeVar

from rich.console import Console
from rich.padding import Padding
from rich.status import Status
from rich.table import Table
from rich.text import Text

from opensuction.settings import wording

if TYPE_CHECKING:
    from opensuction.kernel.compiler.compilation import Compilation

POLL_S = 0.1
"""How often a wait looks for signals and news."""
SHORT_S = 1.0
"""A compilation that takes no longer is not worth a line."""
NEWS_S = 10.0
"""Between two lines of how it goes on where there is no spinner."""

Result = TypeVar("Result")


class PlainConsole(Console):
    """A console that prints text as it is and lets a closed pipe be known.

    Names of files, columns and hazards come from people: ``[/x]`` in one is no style to end,
    ``:x:`` no picture, and what would speak to the terminal, begin another line or has no letter
    there is shown as an escape. Only cells of a table may have several lines.
    """

    def __init__(self, stderr: bool = False) -> None:
        super().__init__(stderr=stderr, highlight=False, markup=False, emoji=False)

    def print(self, *objects: Any, **options: Any) -> None:
        """Print objects as `Console.print` does, and none of their text raw."""
        super().print(*(self._escape(one) for one in objects), **options)

    def say(self, text: str) -> str:
        """Text as this console shows it, in one line."""
        return wording.one_line(text, self.encoding)

    def _escape(self, shown: Any) -> Any:
        if isinstance(shown, str):
            return self.say(shown)
        if isinstance(shown, Text):
            escaped = shown.copy()
            escaped.plain = self.say(shown.plain)
            return escaped
        if isinstance(shown, Padding):
            around = (shown.top, shown.right, shown.bottom, shown.left)
            return Padding(self._escape(shown.renderable), around, style=shown.style)
        if isinstance(shown, Table):
            return self._escape_table(shown)
        return shown

    def _escape_table(self, table: Table) -> Table:
        """The same table, for it is printed once: what its cells say is measured escaped."""
        for column in table.columns:
            column.header, *column._cells = (
                Text("\n").join(self._escape(Text(one)) for one in cell.split("\n"))
                if isinstance(cell, str)
                else self._escape(cell)
                for cell in (column.header, *column._cells)
            )
        return table

    def on_broken_pipe(self) -> None:
        """Raise it once more: what rich does by itself is to leave without a word."""
        raise BrokenPipeError


class _Compilations:
    """Those of one wait; written by the thread that compiles, read by the one that waits."""

    def __init__(self) -> None:
        self._is_running = False
        self._stage = "translating"
        self._functions = self._earlier_functions = 0
        self._began_s = self._ended_s = self._earlier_s = 0.0

    def hear(self, news: "Compilation") -> None:
        """Note how one goes on."""
        from opensuction.kernel.compiler.compilation import Stage

        self._functions = self._earlier_functions + news.functions
        if news.stage == Stage.BEGUN:
            self._began_s = time.monotonic()
            self._stage = "translating"
            self._is_running = True
        elif news.stage == Stage.OPTIMISING:
            self._stage = "making machine code"
        elif news.stage == Stage.FINISHED:
            self._ended_s = time.monotonic()
            self._earlier_s += self._ended_s - self._began_s
            self._earlier_functions = self._functions
            self._is_running = False

    @property
    def are_running(self) -> bool:
        """True while something is compiled, or was a moment ago: one function follows another."""
        return self._is_running or time.monotonic() - self._ended_s < SHORT_S

    @property
    def seconds(self) -> float:
        """Spent on compiling so far."""
        return self._earlier_s + (time.monotonic() - self._began_s if self._is_running else 0.0)

    @property
    def state(self) -> str:
        """Progress of the compilation, in a line."""
        return f"Compiling: {self._stage}, {self._functions} functions, {self.seconds:.0f} s"


class ProgressTeller:
    """Tells on stderr how the work goes on; stdout is for the result."""

    def __init__(self) -> None:
        self._console = PlainConsole(stderr=True)
        self._began_s = time.monotonic()
        self._standing: str | None = None
        self._told_s = 0.0

    @property
    def elapsed_s(self) -> float:
        """Time since the command began."""
        return time.monotonic() - self._began_s

    def tell(self, line: str) -> None:
        """A line of its own; from any thread."""
        self._console.print(line, soft_wrap=True)

    def show(self, standing: str) -> None:
        """Show progress beside the spinner, or in a line now and then; from any thread."""
        self._standing = self._console.say(standing)
        if not self._console.is_terminal and self.elapsed_s - self._told_s >= NEWS_S:
            self._told_s = self.elapsed_s
            self.tell(standing)

    def wait(self, work: Callable[[], Result], doing: str | None = None) -> Result:
        """Do slow work in the background, so that signals are heard; raises what it raised.

        doing: said beside a spinner on a terminal; None: no spinner, the work shows itself.
        """
        results: list[Result] = []
        failures: list[BaseException] = []
        compilations = _Compilations()

        def run() -> None:
            # Loaded here, as all that takes long.
            from opensuction.kernel.compiler import compilation

            compilation.listen(compilations.hear)
            try:
                results.append(work())
            except BaseException as failure:
                failures.append(failure)
            finally:
                compilation.listen(None)

        worker = threading.Thread(target=run, daemon=True)
        worker.start()
        spins = doing is not None and self._console.is_terminal
        with self._console.status(doing or "") if spins else nullcontext() as status:
            self._follow(worker, compilations, status)
        if compilations.seconds > SHORT_S:
            self.tell(f"Compiled in {compilations.seconds:.0f} s, and kept for the next time")
        if failures:
            raise failures[0]
        return results[0]

    def _follow(
        self, worker: threading.Thread, compilations: _Compilations, spinner: Status | None
    ) -> None:
        """Wait; what is compiled shows beside the spinner, or now and then in a line."""
        doing, due_s = spinner and spinner.status, SHORT_S
        while worker.is_alive():
            worker.join(POLL_S)
            spent_s = compilations.seconds
            if spent_s > due_s:
                if due_s == SHORT_S:
                    self.tell("Compiling the control core: once for this version, up to a minute")
                elif spinner is None:
                    self.tell(compilations.state)
                due_s = NEWS_S * (1.0 + spent_s // NEWS_S)
            if spinner is not None:
                slow = spent_s > SHORT_S and compilations.are_running
                standing = compilations.state if slow else self._standing
                spinner.update(Text(standing) if standing else doing)
