"""Several inputs: what each adds to the output, and whether a column that was left out belongs in.

A column explains what a model leaves where a small fit to it and its plays predicts the residuals
of blocks that it has not seen.
"""

from collections.abc import Mapping

import numpy as np

from opensuction.hysteresis import play
from opensuction.identification import fold
from opensuction.identification.estimator import linear
from opensuction.identification.estimator.linear import Design
from opensuction.identification.fold import Folds
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

WIDTHS = (0.02, 0.08, 0.32)
"""[design] Plays of a column that is tried, as shares of its range."""

PENALTY = 1e-3
"""[design] Ridge of that fit, as a share of each column's variance."""

EXPLAINED = 0.25
"""[design] Least share of the residuals' power that is worth a warning."""

MOST_COLUMNS = 20
"""[design] Columns of a file that are tried: more are seldom measured."""


def measure_shares(parts: Mapping[str, Array], range_: float) -> dict[str, float]:
    """Share of each input, root mean square about its mean, in percent of the output's range.

    parts: what it adds to the output, by its name; shape (n,).
    """
    return {name: 100.0 * float(part.std()) / range_ for name, part in parts.items()}


def explain(rest: Array, column: Array, folds: Folds) -> float:
    """Share of the residuals' power that a column predicts on blocks not seen; 0 if not surely any.

    rest: residuals, shape (n,); column: likewise.
    """
    range_ = float(np.ptp(column))
    if not (range_ > 0.0 and np.isfinite(column).all()):
        return 0.0
    scaled = (column - column.min()) / range_
    plays = [play.simulate(width, scaled, float(scaled[0])) for width in WIDTHS]
    try:
        design = Design(np.array([scaled, *plays]), PENALTY, 0)
        found = linear.fit([design], rest, linear.solve_free, folds)
    except InputError:
        return 0.0
    about = rest - rest.mean()
    before = np.array([float(about[cut] @ about[cut]) for cut in folds.cuts])
    after = found.scores.blocks
    if not fold.is_surely_worse(before, after):
        return 0.0
    return 1.0 - float(after.sum()) / float(before.sum())


def find_missing(rest: Array, columns: Mapping[str, Array], folds: Folds) -> list[str]:
    """A sentence where another column explains what is left; the one that explains most.

    columns: the others of the file by their names, each of shape (n,).
    """
    tried = list(columns.items())[:MOST_COLUMNS]
    shares = {name: explain(rest, column, folds) for name, column in tried}
    best = max(shares, key=lambda name: shares[name], default=None)
    if best is None or shares[best] < EXPLAINED:
        return []
    return [
        f"Another input: column '{best}' explains {shares[best]:.0%} of what the model leaves; if "
        f"it drives too, add --input {best}."
    ]
