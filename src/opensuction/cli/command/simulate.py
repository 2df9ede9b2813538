"""``simulate``: lives of a whole machine under a simulated clock, with faults that a seed draws."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli.delivery import CommandResult, OutputChoice, delivering, to_text
from opensuction.cli.entry import Command
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.evidence.lives.life import LifeResult
    from opensuction.evidence.lives.life_fault import Kind
    from opensuction.evidence.lives.lives import LivesResult, PlayedLife

EVERY_LIVES = 25
"""A line of progress after so many."""


class SimulateOptions(NamedTuple):
    """Options of ``simulate``."""

    lives: int = 100
    life_seed: int = 1
    workers: int | None = None
    life_faults: tuple[str, ...] = ()
    play_life: int | None = None
    results: OutputChoice = OutputChoice()


def _compute(options: SimulateOptions, progress: "ProgressTeller", _: Path) -> CommandResult:
    from opensuction.evidence.lives import life_fault

    kinds = life_fault.check_kinds(options.life_faults)
    if options.play_life is not None:
        return _play(options.play_life, kinds)
    return _run(options, kinds, progress)


def _run(
    options: SimulateOptions, kinds: "tuple[Kind, ...]", progress: "ProgressTeller"
) -> CommandResult:
    from opensuction.evidence import worker_pool
    from opensuction.evidence.lives import lives

    seeds = range(options.life_seed, options.life_seed + options.lives)
    workers = options.workers or worker_pool.count_cores()
    done = [0]

    def tell(_: int, found: "LifeResult") -> None:
        done[0] += 1
        for one in found.violations:
            progress.tell(f"seed {found.life.seed} breaks '{one.invariant}': {one.detail}")
        if done[0] % EVERY_LIVES == 0 or done[0] == options.lives:
            progress.tell(f"{done[0]} of {options.lives} lives")

    progress.tell(
        f"{options.lives} lives, seeds {seeds.start} to {seeds.stop - 1}: twin, controller, "
        f"recorder and supervisor under a simulated clock; {workers} "
        f"{'process' if workers == 1 else 'processes'}"
    )
    played = lives.run(seeds, kinds, workers, tell, progress.tell)
    found = lives.to_result(seeds, kinds, played, progress.elapsed_s)
    data = to_json(found)
    return CommandResult(
        data,
        {"simulate.json": to_text(data)},
        lambda console, _: _summarise(console, found),
        is_good=found.ok,
    )


def _play(seed: int, kinds: "tuple[Kind, ...]") -> CommandResult:
    from opensuction.evidence.lives import life, lives

    found = lives.to_played(life.play(life.draw(seed, kinds)))
    data = to_json(found)
    return CommandResult(
        data,
        {"life.json": to_text(data)},
        lambda console, _: _show(console, found),
        is_good=not found.violations,
    )


def _summarise(console: "Console", found: "LivesResult") -> None:
    for one in found.broken:
        console.print(f"seed {one.seed}: {', '.join(one.faults)}", soft_wrap=True)
        for violation in one.violations:
            console.print(f"  breaks '{violation.invariant}': {violation.detail}", soft_wrap=True)
        console.print(f"  fewest faults that do so: {', '.join(one.fewest)}", soft_wrap=True)
        console.print(f"  opensuction simulate --play {one.seed}", soft_wrap=True)
    console.print(
        f"{found.lives} lives, {found.simulated_h:.2f} h of a machine in {found.wall_s:.0f} s; "
        f"{len(found.broken)} broken; trace {found.trace}. In-silico: the machine and its computer "
        "are simulated, the processes are those that run a machine.",
        soft_wrap=True,
    )


def _show(console: "Console", found: "PlayedLife") -> None:
    for event in found.events:
        console.print(f"{event.at_s:8.3f} s  {event.what}", soft_wrap=True, highlight=False)
    for violation in found.violations:
        console.print(f"breaks '{violation.invariant}': {violation.detail}", soft_wrap=True)
    if not found.violations:
        console.print("Nothing is broken in this life, with this version.")
    console.print(f"seed {found.seed}, trace {found.trace}. In-silico.", soft_wrap=True)


COMMAND = Command(
    name="simulate",
    options=SimulateOptions,
    run=delivering("simulate", "Living", _compute),
    sentence="Lives of a whole machine under a simulated clock: its processes killed, frozen or "
    "late, and all that must hold all the same.",
    details="Twin, controller, recorder and supervisor are the processes of opensuction serve, run "
    "in one thread by a scheduler that a seed drives, a step at a time. A life is a cycle of a "
    "neonate with one to five faults between its steps: processes killed or frozen, the host "
    "standing still or busy, datagrams lost, late or twice, the wall clock set, people who stop "
    "the machine or press twice. Judged are the truth of the twin, the records and every "
    "recording. The same seed gives the same life, in the same version.",
    examples="""\b
Examples:
  opensuction simulate                         100 lives: some minutes
  opensuction simulate --lives 1000 --seed 5000
  opensuction simulate --faults kill,freeze
  opensuction simulate --play 4711             one life, event by event
  opensuction simulate --json | jq '.broken[].seed'

\b
Kinds of faults: kill, freeze, standstill, slow, wall-clock, mail, stop,
impatient.""",
    ends="0 everything held in every life, 1 something did not",
)
