"""``leaderboard``: models on recordings of other laboratories, by their held-out errors."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli.delivery import CommandResult, OutputChoice, delivering, to_text
from opensuction.cli.entry import Command
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.evidence.leaderboard.leaderboard import LeaderboardResult

PAGE, RESULT = "leaderboard.md", "leaderboard.json"


class LeaderboardOptions(NamedTuple):
    """Options of ``leaderboard``."""

    data_folder: Path | None = None
    contenders: tuple[str, ...] = ()
    data_sets: tuple[str, ...] = ()
    results: OutputChoice = OutputChoice()


def _compute(options: LeaderboardOptions, progress: "ProgressTeller", _: Path) -> CommandResult:
    from opensuction.evidence.leaderboard import data_set, leaderboard, leaderboard_page
    from opensuction.evidence.leaderboard.data_set_table import DATA_SETS

    chosen = data_set.select(options.data_sets, DATA_SETS)
    found = leaderboard.run(options.data_folder, options.contenders, chosen, progress.show)
    data = to_json(found)
    files = {PAGE: leaderboard_page.markdown(found), RESULT: to_text(data)}
    return CommandResult(data, files, lambda console, folder: _summarise(console, found, folder))


def _summarise(console: "Console", found: "LeaderboardResult", folder: Path) -> None:
    from rich.table import Table

    from opensuction.evidence.leaderboard import leaderboard_page

    for one in found.data_sets:
        if one.state not in leaderboard_page.USED:
            console.print(f"{one.name}: {one.state}: {one.note}", soft_wrap=True)
            continue
        table = Table(box=None, pad_edge=False, header_style="bold")
        table.add_column(one.name, no_wrap=True)
        table.add_column("held out, % of range (95 %)", justify="right", no_wrap=True)
        table.add_column("RRSE", justify="right", no_wrap=True)
        own = [entry for entry in found.entries if entry.data_set == one.name]
        for entry in own:
            if entry.error is not None:
                percent = leaderboard_page.write_interval(
                    entry.error.rmse_percent_of_range, entry.error.rmse_percent_of_range_ci95
                )
                table.add_row(entry.model, percent, f"{entry.error.rrse:.3g}")
        below = leaderboard_page.list_refusals(own)
        console.print(table)
        below += [f"published: {other.rrse:.3g} by {other.by}" for other in one.published]
        for line in below:
            console.print(line, soft_wrap=True)
        console.print("")
    console.print(
        "Free run over the held-out part, from the inputs alone; the best of each first. "
        "Published: the RRSE that others told of, for the same samples.",
        soft_wrap=True,
    )
    console.print(f"Table: {folder / PAGE}", soft_wrap=True)


COMMAND = Command(
    name="leaderboard",
    options=LeaderboardOptions,
    run=delivering("leaderboard", "Fitting", _compute),
    sentence="Hysteresis models on recordings of other laboratories, by their error on what was "
    "held out.",
    details="Each model is fitted to the first part of each data set and simulated over the rest "
    "from the inputs alone: what was measured there is never fed to it. Every error has a 95 % "
    "interval. Writes leaderboard.md and leaderboard.json. All models on all data sets take some "
    "minutes.",
    examples="""\b
Examples:
  opensuction leaderboard --data recordings
  opensuction leaderboard --data recordings --data-set mr-damper \\
      --model maxwell-slip --model straight-line
  opensuction leaderboard --data recordings \\
      --model sklearn.ensemble:ExtraTreesRegressor --model mine:BEST
  opensuction leaderboard --data recordings --json | jq '.entries[] |
      select(.place == 1) | [.data_set, .model, .error.rrse]'

\b
Nothing is fetched: --data names the folder in which the files lie, or in a
folder of it, as their owners published them; bouc-wen-benchmark is computed
and needs none. A file is known by its sha256; one that is not there, or is
another one, is listed as such. Where each is published, what is fitted and
what is held out: leaderboard.md, and docs/reference/leaderboard.md.

\b
Models:
  NAME            of the catalogue (modified-dahl, maxwell-slip, ...),
                  modified-bouc-wen (a damper that a voltage drives),
                  bouc-wen-oscillator (a mass) or straight-line; a model of
                  one input takes the first
  MODULE:CLASS    an estimator with scikit-learn's fit(X, y) and predict(X),
                  made without arguments; MODULE:OBJECT one that is made
                  already. Modules of the current folder are found. X has a
                  row for each sample, in the order of time; predict gets all
                  rows at once and no outputs.

The interval is a bootstrap over the strokes of the held-out part: it says nothing of another
recording.""",
    ends="0 done",
)
