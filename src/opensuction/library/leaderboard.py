"""The leaderboard for scripts: models and estimators held against one another on data sets."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from opensuction.evidence.leaderboard import data_set, leaderboard_page
from opensuction.evidence.leaderboard import leaderboard as engine
from opensuction.evidence.leaderboard.data_set import DataSet
from opensuction.evidence.leaderboard.data_set_table import DATA_SETS
from opensuction.evidence.leaderboard.leaderboard import Entry, LeaderboardResult
from opensuction.library.columns import in_python, write_html, write_text
from opensuction.library.run import Name
from opensuction.result.plain import Json, to_json

HEADING = ("data set", "model", "% of range (95 %)", "RRSE")


@dataclass(frozen=True, eq=False, repr=False)
class Leaderboard:
    """Models by their held-out errors; `leaderboard` makes one."""

    result: LeaderboardResult

    @property
    def summary(self) -> Json:
        """The object of ``opensuction leaderboard --json``."""
        return to_json(self.result)

    @property
    def entries(self) -> tuple[Entry, ...]:
        """One for each model and data set, the least error of each data set first."""
        return self.result.entries

    def __getitem__(self, name: str) -> tuple[Entry, ...]:
        """The entries of a data set; raises KeyError where there is none of that name."""
        found = tuple(entry for entry in self.entries if entry.data_set == name)
        if not found:
            raise KeyError(name)
        return found

    @property
    def markdown(self) -> str:
        """The page that the command writes."""
        return leaderboard_page.markdown(self.result)

    def _rows(self) -> list[tuple[str, ...]]:
        """A heading, then a row for each entry."""
        rows: list[tuple[str, ...]] = [HEADING]
        for entry in self.entries:
            error = entry.error
            if error is None:
                rows.append((entry.data_set, entry.model, f"not fitted: {entry.refused}", ""))
                continue
            percent = leaderboard_page.write_interval(
                error.rmse_percent_of_range, error.rmse_percent_of_range_ci95
            )
            rows.append((entry.data_set, entry.model, percent, f"{error.rrse:.3g}"))
        return rows

    def __repr__(self) -> str:
        return write_text(self._rows())

    def _repr_html_(self) -> str:
        return write_html(self._rows())


def leaderboard(
    models: Sequence[Any] = (),
    data: Name | None = None,
    *,
    data_sets: Sequence[str | DataSet] = (),
    show: Callable[[str], None] = lambda _: None,
) -> Leaderboard:
    """Fit models to data sets and measure their errors on what was held out of each.

    models: names of the catalogue and of the grey boxes, ``module:Class``, or estimators with
    scikit-learn's ``fit(X, y)`` and ``predict(X)``; none: every model that has a name. data: folder
    in which the files of the data sets lie; None: only those that are computed can be used.
    data_sets: names, or `DataSet` records of your own; none: all that have a name. show: called
    with a line before each fit.

    Raises InputError, in one line, for an unknown model or data set, a folder that is none, and
    where none of the data sets can be used.
    """
    with in_python():
        chosen = [
            one if isinstance(one, DataSet) else data_set.select((one,), DATA_SETS)[0]
            for one in data_sets or DATA_SETS.values()
        ]
        folder = None if data is None else Path(data)
        return Leaderboard(engine.run(folder, models, chosen, show))
