"""Recommendation of one of several identified models for a purpose, with the reason in words.

Models are ordered by their effective number of parameters; the simplest that is not surely worse
than the best is taken (`fold.choose_simplest`), and never one that predicts the left-out blocks
worse than the modified Dahl model. Where the input turns so seldom that no branch is seen twice,
one piece of a stroke says nothing of the next stroke: then only that model is taken, or one that
contains it. Held-out samples are not used.
Source: [Breiman-1984] sec. 3.4.3 for the rule of one standard error.

Choice of the model that drives a machine, by comparison of all candidates on one recording.

Strokes are left out in turn and predicted from the others. The calibration's own plays, whose
curvature goes on beyond the recorded depths, stay unless another model surely predicts better, and
by a fifth of the squared error: a head that is driven goes further than a recording did.
Source: [Breiman-1984] sec. 3.4.3 for one standard error; [Racine-2000] for blocks.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import LinearForm, VectorForm
from opensuction.identification import record
from opensuction.identification.estimator import nonlinear, superposition
from opensuction.identification.estimator import prandtl_ishlinskii as play_estimator
from opensuction.identification.judgement import candidate
from opensuction.identification.judgement.candidate import judge_vector
from opensuction.identification.judgement.diagnosis import FEWEST_REVERSALS, count_times
from opensuction.identification.record import LEAST_TURNS, Folds, Scores
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
    folds, found, refused = record.cut(head_mm), {}, {}
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
        and record.is_surely_worse(mine, each.scores.blocks)
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
    return names[min(near, record.choose_simplest(blocks))]


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
    drives = candidate.judge(model, sums.record, head[None])
    if drives.lines is None:
        raise InputError(drives.why_not)
    return DriveCandidate(sums.scores, sums.freedom, drives.lines)


def _fit_plays(head: Array, tip: Array, folds: Folds) -> DriveCandidate:
    """The plays that a calibration finds, with the curvature as one more parameter."""
    model = play_estimator.fit(head, tip).model
    freedom = np.count_nonzero(model.weights) + (model.slope > 0.0) + 2
    return DriveCandidate(play_estimator.score(head, tip, folds), float(freedom), None)


PURPOSES = {
    "predict": "to know what the output does along motions like the recorded ones",
    "compensate": "to drive a machine: only what a compensator takes",
    "transfer": "to predict another speed or another time: one part of the recording from the "
    "other alone",
}
"""What a model may be for."""

SAFE = "modified-dahl"
"""No model is recommended that does worse than this one."""


NEAR = ("bouc-wen", "residual-readout")
"""Models that are `SAFE` wherever nothing speaks for more: they contain it."""

BOTH_WAYS = {"residual-readout": 0.9}
"""[design] Share of the range that strokes of either direction must have passed for one of them to
be taken after few reversals: it reads out every place on each way."""


class Aim(NamedTuple):
    """Purpose of a model."""

    purpose: str = "predict"
    """Of `PURPOSES`."""


class Rated(NamedTuple):
    """Rating of a model for a recommendation."""

    model: str
    scores: Scores
    freedom: float
    """Effective number of parameters."""
    well_posed: bool
    undriven: str = ""
    """Why no compensator takes it; empty where one does."""


class Recommendation(NamedTuple):
    """A model, and why."""

    model: str
    reasons: tuple[str, ...]
    errors: dict[str, float]
    """Of every model, for the purpose: root mean square of what was left out, in units of the
    output."""


def check_purpose(purpose: str, folds: Folds) -> None:
    """Refuse a purpose that is not known, or for which the recording holds too little.

    Raises InputError.
    """
    if purpose not in PURPOSES:
        raise InputError(f"purpose '{purpose}' is not known: one of {', '.join(PURPOSES)}")
    if purpose == "transfer" and min(folds.reversals) < LEAST_TURNS:
        parts = "slow and fast part" if folds.by_speed else "first and second half"
        raise InputError(
            f"purpose 'transfer': {parts} of what is fitted hold {folds.reversals[0]} and "
            f"{folds.reversals[1]} reversals, at least {LEAST_TURNS} each are needed; record more "
            "cycles, hold out less, or take purpose 'predict'"
        )


def recommend(rated: Sequence[Rated], aim: Aim, folds: Folds) -> Recommendation:
    """The model to take.

    rated: at least one. aim: as `check_purpose` allows it. Raises InputError for `compensate` where
    none of them can be driven.
    """
    purpose = aim.purpose
    squares = {
        each.model: each.scores.parts if purpose == "transfer" else each.scores.blocks
        for each in rated
    }
    errors = {
        each.model: math.sqrt(float(squares[each.model].sum()) / each.scores.samples)
        for each in rated
    }
    usable = [each for each in rated if purpose != "compensate" or not each.undriven]
    if not usable:
        raise InputError(
            "purpose 'compensate': no compensator takes any model that this recording identifies "
            f"({', '.join(errors)}); take purpose 'predict', or record larger strokes"
        )
    few = _choose_after_few(usable, errors, purpose, folds)
    if few is not None:
        return few._replace(
            reasons=(*few.reasons, *_name_left_out(few.model, rated, usable, squares))
        )
    ordered = sorted(usable, key=lambda each: each.freedom)
    place = record.choose_simplest([squares[each.model] for each in ordered])
    chosen = ordered[place].model
    reasons = [_reason(chosen, [each.model for each in ordered], errors, purpose, folds)]
    if SAFE in (each.model for each in usable) and errors[chosen] > errors[SAFE]:
        reasons = [
            f"For {purpose}: {SAFE}. {chosen} is simpler, but does worse on what was left out."
        ]
        chosen = SAFE
    reasons += _name_left_out(chosen, rated, usable, squares)
    return Recommendation(chosen, tuple(reasons), errors)


def _choose_after_few(
    usable: Sequence[Rated], errors: dict[str, float], purpose: str, folds: Folds
) -> Recommendation | None:
    """The model to take where the input turned too seldom for strokes to be compared, else None."""
    names = [each.model for each in usable]
    turns = sum(folds.reversals)
    if turns >= FEWEST_REVERSALS or SAFE not in names:
        return None
    seldom = (
        f"what is fitted turns {count_times(turns)}, {FEWEST_REVERSALS} times are needed to see a "
        "stroke again"
    )
    near = [name for name in NEAR if name in names and folds.both_ways >= BOTH_WAYS.get(name, 0.0)]
    chosen = min([SAFE, *near], key=lambda name: errors[name])
    reason = f"For {purpose}: {chosen}, for {seldom}: of others, what was left out tells little."
    if chosen != SAFE:
        reason = (
            f"For {purpose}: {chosen}, for {seldom}, and it stays near {SAFE} where no more is "
            "seen."
        )
    return Recommendation(chosen, (reason,), errors)


def _reason(
    chosen: str, ordered: list[str], errors: dict[str, float], purpose: str, folds: Folds
) -> str:
    """Reason why it was chosen among those that can be used, simplest first."""
    asked = {
        "transfer": "one half predicted from the other",
    }.get(purpose, "strokes left out and predicted")
    if purpose == "transfer" and folds.by_speed:
        asked = "slow strokes predicted from fast ones and back"
    best = min(ordered, key=lambda model: errors[model])
    if len(ordered) == 1:
        return f"For {purpose}: {chosen}, the only one that can be used for it."
    if chosen == best:
        return f"For {purpose}: {chosen} does best ({asked}); every simpler model is surely worse."
    if errors[chosen] <= errors[best]:
        return f"For {purpose}: {chosen} does as well as any ({asked})."
    return (
        f"For {purpose}: {chosen} ({asked}). {best} has a smaller error in all, but not surely: "
        f"block by block {chosen} is within one standard error of the best, and "
        f"{_compare_size(chosen, best, ordered)}."
    )


def _compare_size(chosen: str, best: str, ordered: list[str]) -> str:
    if ordered.index(chosen) < ordered.index(best):
        return "it is simpler"
    return "better where most samples are"


def _name_left_out(
    chosen: str, rated: Sequence[Rated], usable: Sequence[Rated], squares: dict[str, Array]
) -> list[str]:
    """Models that do surely better but cannot be used."""
    names = [each.model for each in usable]
    better = [
        each
        for each in rated
        if each.model not in names and record.is_surely_worse(squares[chosen], squares[each.model])
    ]
    return [
        f"{each.model} predicts surely better, but drives no head: {each.undriven}."
        for each in better
    ]
