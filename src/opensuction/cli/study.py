"""Options of the commands that show something by many runs on the twin."""

import typer

from opensuction.cli import interruption, option

REPRODUCE_EXAMPLES = """\b
Examples:
  opensuction reproduce                              report.html and reproduce.json under runs/
  opensuction reproduce --out paper                  in a folder of your own
  opensuction reproduce --json | jq .table1          Table I, the paper's numbers and ours

\b
Exit status: 0 every claim holds or is explained, 1 one differs, 2 bad input, 130 interrupted."""


def reproduce(
    out: option.StudyOut = None,
    force: option.Force = False,
    as_json: option.AsJson = False,
) -> None:
    """The paper's figures 5 to 11 and tables I and II on the twin, each number beside its own.

    Every claim has a tolerance and a verdict, and says whether the twin was calibrated to it or
    predicts it.
    """
    from opensuction.cli import reproduce as command

    interruption.carry_out(
        lambda: command.run(command.Options(out=out, force=force, as_json=as_json))
    )


BENCHMARK_EXAMPLES = """\b
Examples:
  opensuction benchmark                              report.html and benchmark.json under runs/
  opensuction benchmark --seeds 1                    a quick look
  opensuction benchmark --json | jq '.results[] | select(.plant == "bench")'

\b
Exit status: 0 done, 2 bad input, 130 interrupted."""


def benchmark(
    seeds: option.Seeds = 5,
    out: option.StudyOut = None,
    force: option.Force = False,
    as_json: option.AsJson = False,
) -> None:
    """Every compensator on every plant with fixed seeds: error, peak and head speed of each pair.

    Plants are the twins (bench, bedside, conduits laid otherwise) and the hysteresis models; each
    is identified by the same excitation before it is compensated.
    """
    from opensuction.cli import benchmark as command

    options = command.Options(seeds=seeds, out=out, force=force, as_json=as_json)
    interruption.carry_out(lambda: command.run(options))


def register(app: typer.Typer) -> None:
    """Add these commands to the ``opensuction`` command."""
    app.command(epilog=REPRODUCE_EXAMPLES)(reproduce)
    app.command(epilog=BENCHMARK_EXAMPLES)(benchmark)
