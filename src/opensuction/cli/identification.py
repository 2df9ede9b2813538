"""The ``identify`` and ``compare`` commands: a recording in, parameters and a report out."""

import json
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rich.console import Console

from opensuction.cli import output_folder
from opensuction.cli.cycle import interruptible

if TYPE_CHECKING:
    from opensuction.identification.workbench import FittedModel
    from opensuction.session.identification.identification_run import LoadedRecording

Json = dict[str, Any]


class Options(NamedTuple):
    """Options of both commands as a person gave them."""

    file: Path
    input: str
    output: str
    time: str | None
    negate_output: bool
    input_unit: str | None
    output_unit: str | None
    model: str | None
    """None: every model is compared."""
    method: str | None
    holdout: float
    from_s: float | None
    to_s: float | None
    out: Path | None
    force: bool
    as_json: bool


def run(options: Options) -> int:
    """Carry a command out; returns the exit status. Raises InputError for bad input."""
    console = Console(stderr=options.as_json, highlight=False)
    what = "compare" if options.model is None else "identify"
    folder = output_folder.chosen(options.out, what)
    with output_folder.whole(folder, options.force) as staging:
        console.print(_first_line(options), soft_wrap=True, markup=False)
        data, files = _identify_and_write(options, console, staging, folder)
    if options.as_json:
        print(json.dumps(data))  # noqa: T201 - the one object of --json
    else:
        from opensuction.report.identification import identification_terminal

        identification_terminal.print_summary(console, data, [folder / name for name in files])
    return 0


def _first_line(options: Options) -> str:
    what = "every model" if options.model is None else options.model
    sign = "-" if options.negate_output else ""
    return f"Identifying {what} on {options.file}: {options.input} to {sign}{options.output}"


def _identify_and_write(
    options: Options, console: Console, staging: Path, folder: Path
) -> tuple[Json, list[str]]:
    """The JSON object, and the names of the files that were written."""
    # Heavy imports, after the first line is out.
    from opensuction.kernel import compiled
    from opensuction.recording.pair import TimeSpan
    from opensuction.report.identification import identification_page, identification_series
    from opensuction.session.identification import identification_run, identification_summary
    from opensuction.settings import identification_file

    choice = identification_run.IdentificationChoice(
        file=options.file,
        input=options.input,
        output=options.output,
        time=options.time,
        negate_output=options.negate_output,
        input_unit=options.input_unit,
        output_unit=options.output_unit,
        model=options.model,
        method=options.method,
        holdout_ratio=options.holdout,
        span=TimeSpan(options.from_s, options.to_s),
    )
    loaded = interruptible(lambda: identification_run.load(choice))
    if compiled.is_cold():
        console.print("Compiling the estimators: once for this version, about a minute")
    began_s = time.perf_counter()
    results = _fitted(loaded, console)
    seconds = time.perf_counter() - began_s
    now = datetime.now(tz=UTC)
    compared = options.model is None
    if compared:
        data = identification_summary.summarise_comparison(loaded, results, now, seconds)
    else:
        data = identification_summary.summarise(loaded, results[0], now, seconds)
    files = []
    for entry, result in zip(data["models"] if compared else [data], results, strict=True):
        name = f"{result.model}.toml" if compared else "identification.toml"
        content = identification_file.to_toml(
            identification_summary.make_parameter_file(loaded, result, now)
        )
        (staging / name).write_text(content, encoding="utf-8")
        entry["parameter_file"] = str(folder / name)
        files.append(name)
    pair = loaded.pair
    curves = identification_series.Curves(
        time_s=pair.time_s,
        driven=pair.driven,
        answer=pair.answer,
        fitted={result.model: result.fitted for result in results},
        autocorrelation={result.model: result.autocorrelation for result in results},
        fitted_samples=results[0].fitted_samples,
    )
    html = identification_page.render(data, curves)
    (staging / "report.html").write_text(html, encoding="utf-8")
    name = "comparison.json" if compared else "identification.json"
    (staging / name).write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    return data, ["report.html", name, *files]


def _fitted(loaded: "LoadedRecording", console: Console) -> "list[FittedModel]":
    """One result, or those of every model."""
    from opensuction.session.identification import identification_run

    with console.status("Identifying") as status:  # turns on a terminal, silent elsewhere

        def tell(model: str, done: int, models: int) -> None:
            line = f"Identifying {model} ({done + 1} of {models})"
            if console.is_terminal:
                status.update(line)
            else:
                console.print(line, soft_wrap=True, markup=False)

        if loaded.choice.model is None:
            return interruptible(lambda: identification_run.compare(loaded, tell))
        return [interruptible(lambda: identification_run.identify(loaded))]
