"""Choice of the model that drives a machine, by comparison of all candidates on one recording.

Strokes are left out in turn and predicted from the others. The calibration's own plays, whose
curvature goes on beyond the recorded depths, stay unless another model surely predicts better, and
by a fifth of the squared error: a head that is driven goes further than a recording did.
Source: [Breiman-1984] sec. 3.4.3 for one standard error; [Racine-2000] for blocks.
"""

from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import LinearForm, VectorForm
from opensuction.identification import fold
from opensuction.identification.estimator import nonlinear, superposition
from opensuction.identification.estimator import prandtl_ishlinskii as play_estimator
from opensuction.identification.fold import Folds, Scores
from opensuction.identification.judgement import driven
from opensuction.identification.judgement.candidate import judge_vector
from opensuction.identification.single_thread import single_threaded
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

PLAYS = "plays"
"""The calibration's plays with their curvature, which `preview` drives by."""
DAHL = "modified-dahl"
WORTH = 0.8
"""[design] Squared error over that of the plays, below which another model takes their place. On
the twin Prandtl-Ishlinskii models without curvature came to .9 of it and drove .01 mm worse."""
LITTLE = 0.95
"""[design] Squared error over that of a simpler model, above which the simpler one drives, however
sure the difference is. Eighty lines came to .98 of one play's on the published Bouc-Wen conduit,
most of it the laser's noise, and drove three times worse: noise in the lines bends every way."""
ON_LINES = tuple(
    name for name, model in CATALOGUE.items() if model.lines is not None and not model.undriven
)
"""Models that drive as plays with lines over them."""


class DriveCandidate(NamedTuple):
    """A model that drives, and how it predicts."""

    scores: Scores
    freedom: float
    """Effective number of parameters."""
    lines: PlayLines | None
    """None where it drives in a form of its own."""


class DriveChoice(NamedTuple):
    """A model to drive by, and why."""

    model: str
    """`PLAYS`, `DAHL` or of `ON_LINES`."""
    reason: str
    """In a sentence."""
    errors_mm: dict[str, float]
    """Root mean square error of the strokes left out, of every model that drives."""
    refused: dict[str, str]
    """Why a model does not."""
    lines_model: str | None
    """Of `ON_LINES` the one to drive by; None where none drives."""
    lines: PlayLines | None
    """Its lines."""


@single_threaded
def choose(head_mm: Array, tip_mm: Array, only_lines: bool = False) -> DriveChoice:
    """The model to drive by.

    head_mm, tip_mm: of one recording that begins after a long retract, shape (n,). only_lines: of
    those with lines alone. Raises InputError where none drives, or the recording is none.
    """
    folds, found, refused = fold.cut(head_mm), {}, {}
    for name in ON_LINES if only_lines else (PLAYS, DAHL, *ON_LINES):
        try:
            found[name] = _fit(name, head_mm, tip_mm, folds)
        except InputError as problem:
            refused[name] = str(problem)
    if not found:
        raise InputError(
            "no model drives a head by this recording: "
            + "; ".join(f"{name}: {why}" for name, why in refused.items())
        )
    lines_model = _simplest({name: each for name, each in found.items() if each.lines is not None})
    model, reason = _choose(found)
    return DriveChoice(
        model=model,
        reason=reason,
        errors_mm={name: each.scores.rmse for name, each in found.items()},
        refused=refused,
        lines_model=lines_model,
        lines=None if lines_model is None else found[lines_model].lines,
    )


def _choose(found: dict[str, DriveCandidate]) -> tuple[str, str]:
    """The model and why. found: at least one."""
    words = ", ".join(f"{name} {each.scores.rmse:.3f} mm" for name, each in found.items())
    asked = f"Strokes left out and predicted: {words}."
    if PLAYS not in found:
        chosen = _simplest(found)
        assert chosen is not None
        return chosen, f"{asked} {chosen} is the simplest that is not surely worse than the best."
    mine = found[PLAYS].scores.blocks
    better = {
        name: each
        for name, each in found.items()
        if name != PLAYS
        and fold.is_surely_worse(mine, each.scores.blocks)
        and float(each.scores.blocks.sum()) < WORTH * float(mine.sum())
    }
    chosen = _simplest(better)
    if chosen is None:
        return PLAYS, f"{asked} No other model is surely and much better than the plays."
    return chosen, f"{asked} {chosen} is surely and much better than the plays."


def _simplest(found: dict[str, DriveCandidate]) -> str | None:
    """The simplest that is not surely worse than the best of them, or little; None of none."""
    names = sorted(found, key=lambda name: found[name].freedom)
    if not names:
        return None
    blocks = [found[name].scores.blocks for name in names]
    least = min(float(each.sum()) for each in blocks)
    near = next(i for i, each in enumerate(blocks) if least >= LITTLE * float(each.sum()))
    return names[min(near, fold.choose_simplest(blocks))]


def _fit(name: str, head: Array, tip: Array, folds: Folds) -> DriveCandidate:
    """One model. Raises InputError where it cannot be fitted, or cannot drive."""
    if name == PLAYS:
        return _fit_plays(head, tip, folds)
    model = CATALOGUE[name]
    if isinstance(model.form, VectorForm):
        vector = nonlinear.FITS[name](head, tip, ("head_mm", "tip_mm"))
        judged = judge_vector(model, model.form, vector, (head, tip), folds)
        return DriveCandidate(judged.scores, judged.freedom, None)
    assert isinstance(model.form, LinearForm)
    sums = superposition.fit(model, head, tip, folds, rising=True)
    drives = driven.judge(model, sums.record, head[None])
    if drives.lines is None:
        raise InputError(drives.why_not)
    return DriveCandidate(sums.scores, sums.freedom, drives.lines)


def _fit_plays(head: Array, tip: Array, folds: Folds) -> DriveCandidate:
    """The plays that a calibration finds, with the curvature as one more parameter."""
    model = play_estimator.fit(head, tip).model
    freedom = np.count_nonzero(model.weights) + (model.slope > 0.0) + 2
    return DriveCandidate(play_estimator.score(head, tip, folds), float(freedom), None)
