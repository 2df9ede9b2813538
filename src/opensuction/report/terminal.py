"""A cycle in the terminal: live while it runs, and its summary afterwards.

Depth of the tip as a bar of characters, and the characters that a console can show.

One instant of a running cycle, as whoever plays it tells whoever shows it.
"""

from collections.abc import Iterable
from types import TracebackType
from typing import Final, NamedTuple, Self

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from opensuction.kernel.vocabulary import CYCLE, Phase
from opensuction.report import ending, figures, headline, narrative
from opensuction.report.figure import FigureVerdict
from opensuction.report.notice import notices
from opensuction.report.wording import DISCLAIMER, REST, phase_words, quantity
from opensuction.result.cycle_result import CycleResult


class Moment(NamedTuple):
    """Values that a live display shows of an instant."""

    phase: str
    """Name as in summaries: lower case, ``backing_off``."""
    time_s: float
    tip_mm: float
    valve_open_ratio: float
    line_vacuum_mmhg: float


CELLS: Final = 40
"""Width of the bar."""

MARGIN_RATIO: Final = 1.1
"""Depth at the end of the bar over the cap, so that the cap has a place within it."""


class Glyphs(NamedTuple):
    """Characters of the display; plain ones where the terminal knows no others."""

    done: str
    now: str
    later: str
    failed: str
    look: str
    full: str
    empty: str


UNICODE: Final = Glyphs(done="✓", now="▶", later="·", failed="✗", look="!", full="█", empty="░")
ASCII: Final = Glyphs(done="x", now=">", later=".", failed="!", look="?", full="#", empty="-")


def glyphs(console: Console) -> Glyphs:
    """Characters that a console can show."""
    return ASCII if console.options.ascii_only else UNICODE


def depth_bar(tip_mm: float, target_mm: float | None, cap_mm: float, marks: Glyphs) -> str:
    """Depth from the tube's end as a bar; ``T`` stands at the target, ``C`` at the cap.

    target_mm: None where the cycle stops by contact.

    >>> depth_bar(50.0, 90.0, 100.0, ASCII)
    '##################--------------T--C----'
    """
    per_cell = MARGIN_RATIO * cap_mm / CELLS
    filled = min(max(round(tip_mm / per_cell), 0), CELLS)
    cells = [marks.full] * filled + [marks.empty] * (CELLS - filled)
    for depth, letter in ((target_mm, "T"), (cap_mm, "C")):
        if depth is not None:
            cells[min(max(round(depth / per_cell) - 1, 0), CELLS - 1)] = letter
    return "".join(cells)


PLANNED: Final = [phase.name.lower() for phase in CYCLE if phase != Phase.BACKING_OFF]
"""Phases of a cycle that stops by travel, in order."""

REFRESH_PER_S: Final = 10
"""Redraws of the live display, however often it is updated."""

INDENT: Final = (0, 0, 0, 2)
"""Padding of sentences: two columns at the left, also where they wrap."""

VERDICT_STYLES: Final = {
    FigureVerdict.GOOD: "green",
    FigureVerdict.NOTICE: "yellow",
    FigureVerdict.BAD: "bold red",
}
"""Colour besides the remark in words; the others have none."""

HEADLINE_STYLES: Final = {
    FigureVerdict.GOOD: "bold green",
    FigureVerdict.NOTICE: "bold yellow",
    FigureVerdict.BAD: "bold red",
}
"""Colours of the first line."""

ALARM_STYLES: Final = {"high": "bold red", "medium": "yellow", "low": "cyan"}
"""Colours of IEC 60601-1-8, besides the priority in words."""


class LiveCycle:
    """Live display of one cycle; a context manager.

    On a terminal: the phases ticked off one by one, the tip's depth against target and cap, valve
    and vacuum, redrawn in place. Elsewhere (a file, a pipe): one line for each phase that ended.
    Call ``update`` as often as is handy, up to every tick of a paced run.
    """

    def __init__(self, console: Console, target_mm: float | None, cap_mm: float) -> None:
        """Display on a console. target_mm: None where the cycle stops by contact."""
        self._console = console
        self._target_mm = target_mm
        self._cap_mm = cap_mm
        self._marks = glyphs(console)
        self._seen: list[tuple[str, float]] = []
        self._moment: Moment | None = None
        self._over = False
        self._in_place = console.is_terminal and not console.is_dumb_terminal
        self._live = Live(
            get_renderable=self._rendered, console=console, refresh_per_second=REFRESH_PER_S
        )

    def __enter__(self) -> Self:
        if self._in_place:
            self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._over = error is None
        if self._in_place:
            self._live.stop()
        elif self._moment is not None:
            self._print_ended(self._moment)

    def update(self, moment: Moment) -> None:
        """Show a new instant. Cheap: it draws nothing by itself."""
        if not self._seen or self._seen[-1][0] != moment.phase:
            if self._seen and not self._in_place:
                self._print_ended(moment)
            self._seen.append((moment.phase, moment.time_s))
        self._moment = moment

    def _print_ended(self, moment: Moment) -> None:
        """One line on the phase that has just ended, for a console that is no terminal."""
        name, start_s = self._seen[-1]
        if name in REST:
            return
        self._console.print(
            f"{start_s:6.1f} to {moment.time_s:5.1f} s  {phase_words(name).label:<16}"
            f" tip {moment.tip_mm:6.1f} mm, vacuum {moment.line_vacuum_mmhg:4.0f} mmHg",
            highlight=False,
            soft_wrap=True,
        )

    def _phase_lines(self) -> Iterable[Text]:
        """Phases that were, the one that is, and those that are planned to come."""
        now_s = self._moment.time_s if self._moment else 0.0
        ends_s = [start_s for _, start_s in self._seen[1:]] + [now_s]
        for i, ((name, start_s), end_s) in enumerate(
            zip(self._seen, ends_s, strict=False), start=1
        ):
            running = i == len(self._seen) and not self._over
            words = phase_words(name)
            if name in REST:
                continue
            if words.kind == "fault":
                mark, style = self._marks.failed, "bold red"
            elif running:
                mark, style = self._marks.now, "bold"
            else:
                mark, style = self._marks.done, "green"
            lasted = quantity(end_s - start_s, "s")
            yield Text(f" {mark} {words.label:<16} {lasted:>7}", style=style)
        names = [name for name, _ in self._seen]
        if any(phase_words(name).kind == "fault" for name in names):
            return
        for name in PLANNED:
            if name not in names:
                yield Text(f" {self._marks.later} {phase_words(name).label}", style="dim")

    def _rendered(self) -> RenderableType:
        lines: list[RenderableType] = list(self._phase_lines())
        moment = self._moment
        if moment is None:
            return Group(*lines)
        bar = depth_bar(moment.tip_mm, self._target_mm, self._cap_mm, self._marks)
        target = "" if self._target_mm is None else f"T target {self._target_mm:.1f} mm, "
        lines += [
            Text(f" tip    {bar} {moment.tip_mm:6.1f} mm"),
            Text(f"        {target}C cap {self._cap_mm:.1f} mm", style="dim"),
            Text(
                f" valve  {100.0 * moment.valve_open_ratio:3.0f} % open"
                f"   vacuum {moment.line_vacuum_mmhg:3.0f} mmHg   time {moment.time_s:5.1f} s"
            ),
        ]
        return Group(*lines)


def _figure_table(result: CycleResult) -> Table:
    """Key figures with their limits; those that are missing are named below, not here."""
    table = Table(box=None, padding=(0, 2, 0, 0), show_header=False, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column(justify="right", no_wrap=True)
    table.add_column()
    for figure in figures.figures(result):
        if figure.verdict is FigureVerdict.ABSENT:
            continue
        parts = [figure.remark, figure.limit]
        if figure.verdict is FigureVerdict.GOOD:
            parts = [figure.remark]  # the sentences have the limit; a line each is read at a glance
        held = "; ".join(part for part in parts if part)
        table.add_row(
            Text(figure.name),
            Text(figure.value),
            Text(held, style=VERDICT_STYLES.get(figure.verdict, "")),
        )
    return table


def print_summary(console: Console, result: CycleResult, files: Iterable[object] = ()) -> None:
    """Print what happened: outcome, sentences, figures with limits, files that were written."""
    first, marks = headline.headline(result), glyphs(console)
    kinds = {FigureVerdict.GOOD: marks.done, FigureVerdict.NOTICE: marks.look}
    mark = kinds.get(first.verdict, marks.failed)
    ran = (
        result.machine,
        result.patient,
        result.protocol,
        result.approach,
        result.compensation,
    )
    what = ", ".join(name for name in ran if name)
    seed = result.drawn_by
    console.print()
    console.print(
        Text(f"{mark} {first.text}", style=HEADLINE_STYLES[first.verdict]),
        Text(f"({what}{'' if seed is None else f', seed {seed}'})", style="dim"),
    )
    print_indented(console, [first.lead], "bold")
    print_indented(console, [first.look] if first.look else [])
    print_indented(console, narrative.sentences(result))
    for notice in notices(result):
        style = ALARM_STYLES.get(notice.priority, "")
        print_indented(console, [ending.alarm(notice)], style)
    print_indented(console, [f"Warning: {warning}" for warning in result.warnings], "yellow")
    console.print()
    console.print(_figure_table(result))
    absent = [f.name.lower() for f in figures.figures(result) if f.verdict is FigureVerdict.ABSENT]
    if absent:
        console.print(Text(f"No value in this run: {', '.join(absent)}", style="dim"))
    print_end(console, files, DISCLAIMER)


def print_indented(console: Console, said: Iterable[str], style: str = "") -> None:
    """Sentences, each in lines of its own."""
    for sentence in said:
        console.print(Padding(Text(sentence, style=style), INDENT))


def print_end(console: Console, files: Iterable[object], disclaimer: str) -> None:
    """The files that were written, and what the result is not."""
    console.print()
    for file in files:
        console.print(Text(f"Written: {file}"), soft_wrap=True)
    console.print(Text(disclaimer, style="dim"))
