"""Fits and comparisons from arrays: the workbench of ``identify`` and ``compare`` for scripts."""

import time as clock
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property
from html import escape

from opensuction.identification.workbench import MODELS, FittedModel
from opensuction.library.columns import Given, Values, in_python, load, write_html, write_text
from opensuction.library.fit import Fit, Fitted
from opensuction.result.identification_result import ComparisonResult, IdentificationResult
from opensuction.result.plain import Json, to_json
from opensuction.session.identification import identification_run, identification_summary
from opensuction.session.identification.identification_run import LoadedRecording
from opensuction.settings.validation import choose


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Every model fitted to the same recording; `compare` makes one."""

    fits: tuple[Fit, ...]
    """The recommended one first, the others by their error for the purpose."""
    purpose: str
    result: ComparisonResult

    @cached_property
    def summary(self) -> Json:
        """The object of ``opensuction compare --json``."""
        return to_json(self.result)

    @property
    def recommended(self) -> Fit:
        """The model to take for the purpose."""
        return self.fits[0]

    @property
    def reasons(self) -> tuple[str, ...]:
        """Reasons for the recommendation, a sentence each."""
        return self.result.models[0].reasons

    def __getitem__(self, model: str) -> Fit:
        """The fit of a model by its name; raises KeyError where there is none."""
        for fit in self.fits:
            if fit.model == model:
                return fit
        raise KeyError(model)

    def __iter__(self) -> Iterator[Fit]:
        return iter(self.fits)

    def __len__(self) -> int:
        return len(self.fits)

    def _rows(self) -> list[list[str]]:
        """A heading, then a row for each model."""
        # It brings what prints in a terminal, a tenth of a first fit.
        from opensuction.report.identification import identification_words

        measures = identification_words.measures(self.result)
        rows = [["model", *measures, "inverse", ""]]
        for place, (fit, model) in enumerate(zip(self.fits, self.result.models, strict=True)):
            errors = identification_words.errors(model)
            inverse = "continuous" if fit.is_invertible else "with gaps"
            shown = [identification_words.percent(errors[measure]) for measure in measures]
            rows.append([fit.model, *shown, inverse, "" if place else "recommended"])
        return rows

    def __repr__(self) -> str:
        return write_text(self._rows())

    def _repr_html_(self) -> str:
        said = "".join(f"<p>{escape(reason)}</p>" for reason in self.reasons)
        return write_html(self._rows()) + said


def identify(  # noqa: PLR0913 - what the command takes, each by its name
    x: Values,
    y: Values,
    model: str = "modified-dahl",
    *,
    method: str | None = None,
    time: Values = None,
    holdout: float = 0.0,
    negate_output: bool = False,
    names: Sequence[str] | None = None,
    units: tuple[str, str] | None = None,
) -> Fit:
    """Fit a model of hysteresis to a recording, as ``opensuction identify`` does.

    x: what drives: shape (n,), of several inputs (n, inputs), a column or columns of a data frame
    (anything that `numpy.asarray` takes). y: what follows, shape (n,). model, method: as the
    command names them; method None: the model's own. time: when the samples were taken, in s;
    None: evenly. holdout: share of the recording, from its end, that is predicted instead of
    fitted. negate_output: for an output that falls as the input rises. names: of every input and
    of the output; None: as the data frame calls them. units: of input and output; None: those in
    their names (``head_mm``).

    Raises InputError, in one line, for what cannot be identified.
    """
    given = Given(time, holdout, negate_output, names, units)
    with in_python():
        began_s = clock.perf_counter()
        choose(model, MODELS, "model")
        loaded = load(x, y, given, model, method)
        found = identification_run.fit(loaded)
    now, seconds = datetime.now(tz=UTC), clock.perf_counter() - began_s
    result = identification_summary.summarise_fit(loaded, found[0], now, seconds, timed=False)
    return _to_fit(loaded, found[0], now, result)


def compare(
    x: Values,
    y: Values,
    purpose: str = "predict",
    *,
    time: Values = None,
    holdout: float = 0.0,
    negate_output: bool = False,
    names: Sequence[str] | None = None,
    units: tuple[str, str] | None = None,
) -> Comparison:
    """Fit every model to a recording and recommend one, as ``opensuction compare`` does.

    purpose: what the recommended one is for: ``predict``, ``compensate`` or ``transfer``. The
    other arguments are those of `identify`. Raises InputError, in one line, for what cannot be
    identified and a purpose that the recording cannot serve.
    """
    given = Given(time, holdout, negate_output, names, units)
    with in_python():
        began_s = clock.perf_counter()
        identification_run.check_purpose(purpose)
        loaded = load(x, y, given, None, None)
        found = identification_run.fit(loaded, purpose=purpose)
    now, seconds = datetime.now(tz=UTC), clock.perf_counter() - began_s
    result = identification_summary.summarise_comparison(loaded, found, now, seconds, timed=False)
    fits = tuple(
        _to_fit(loaded, fitted, now, IdentificationResult(own, result.provenance))
        for fitted, own in zip(found, result.models, strict=True)
    )
    return Comparison(fits, purpose, result)


def _to_fit(
    loaded: LoadedRecording, fitted: FittedModel, now: datetime, result: IdentificationResult
) -> Fit:
    return Fit(
        identified=identification_summary.make_parameter_file(loaded, fitted, now),
        result=result,
        recording=Fitted(loaded.pair.driven, loaded.pair.answer, fitted.fitted),
    )
