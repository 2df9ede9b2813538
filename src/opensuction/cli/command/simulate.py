"""``simulate``: lives of a whole machine under a simulated clock, with faults that a seed draws."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import delivery, entry
from opensuction.cli.delivery import CommandResult, OutputChoice, to_text
from opensuction.cli.entry import Command
from opensuction.cli.interruption import Stopped
from opensuction.kernel.errors import InputError
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from collections.abc import Callable

    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.evidence.lives.life_fault import Kind
    from opensuction.evidence.lives.life_record import Life, LifeResult
    from opensuction.evidence.lives.lives import Campaign, LivesResult, PlayedLife

EVERY_LIVES = 25
"""A line of progress after so many, and after the first."""
LIVES, SEED = 100, 1
"""Defaults: how many, and the seed of the first."""
FILE, PAGE = "simulate.json", "report.html"


class SimulateOptions(NamedTuple):
    """Options of ``simulate``; None: the default."""

    lives: int | None = None
    life_seed: int | None = None
    workers: int | None = None
    life_faults: tuple[str, ...] = ()
    life_cycles: int | None = None
    play_life: str | None = None
    results: OutputChoice = OutputChoice()


def _carry_out(options: SimulateOptions) -> int:
    """Play lives, or one; returns the exit status."""
    from opensuction.evidence.lives import life, life_fault, lives

    kinds = life_fault.check_kinds(options.life_faults)
    if options.play_life is None:
        return _run(options, kinds)
    _refuse_what_is_of_a_campaign(options)
    given, seed = options.play_life, lives.read_id(options.play_life)
    return delivery.deliver(
        options.results,
        f"life-{seed}",
        lambda *_: _play(given, life.draw(seed, kinds, options.life_cycles or 1), kinds),
        f"Living {lives.make_id(seed)}",
    )


def _refuse_what_is_of_a_campaign(options: SimulateOptions) -> None:
    """Raises InputError for options that one life has no use for."""
    given = (
        ("--lives", options.lives),
        ("--seed", options.life_seed),
        ("--workers", options.workers),
    )
    if many := [name for name, value in given if value is not None]:
        raise InputError(f"--play plays one life, by its own seed: leave out {', '.join(many)}")


def _play(given: str, drawn: "Life", kinds: "tuple[Kind, ...]") -> CommandResult:
    """Play one life, and show it. given: what a person named it by."""
    from opensuction.evidence.lives import life, life_page, lives, simulated_machine
    from opensuction.report import sheet

    with simulated_machine.room() as room:
        watched = life.watch(drawn, room)
        fewest = lives.shrink(watched.result, room) if watched.result.violations else ()
    found = lives.to_played(watched.result, kinds, fewest, tuple(watched.recordings))
    data = to_json(found)
    html = sheet.render(life_page.page(found, watched.result, watched.course))
    return CommandResult(
        data,
        {"life.json": to_text(data), PAGE: html, **watched.recordings},
        lambda console, folder: _show(console, given, found, folder),
        is_good=not found.violations,
    )


def _run(options: SimulateOptions, kinds: "tuple[Kind, ...]") -> int:
    """Run a campaign; what ends it early leaves what is finished."""
    from opensuction.cli.progress import ProgressTeller
    from opensuction.evidence import worker_pool
    from opensuction.evidence.lives import lives

    first = SEED if options.life_seed is None else options.life_seed
    seeds = range(first, first + (options.lives or LIVES))
    workers = options.workers or worker_pool.count_cores()
    campaign = lives.Campaign(seeds, kinds, workers, options.life_cycles or 1)
    progress, out = ProgressTeller(), options.results
    finished: dict[int, LifeResult] = {}
    fewest = {}
    ending: BaseException | None = None
    with (
        delivery.reserve(out.out, "simulate") as folder,
        delivery.stage(folder, out.force) as staging,
    ):
        try:
            # In this thread, so that a signal ends the processes before the rest is written.
            lives.run(campaign, _teller(campaign, finished, progress), progress.tell)
            fewest = lives.shrink_all(list(finished.values()), campaign.workers, progress.tell)
        except (Stopped, InputError, worker_pool.WorkerLostError) as early:
            if not finished:
                raise
            ending = early
        played = [finished[number] for number in sorted(finished)]
        found = lives.to_result(campaign, played, fewest, progress.elapsed_s)
        data = to_json(found)
        delivery.write(staging, {FILE: to_text(data)})
    if ending is not None:
        _end_early(ending, found, folder, out.as_json)
    delivery.show(out.as_json, data, lambda console: _summarise(console, found))
    return entry.DONE if found.ok else entry.FAILED


def _end_early(ending: BaseException, found: "LivesResult", folder: Path, as_json: bool) -> None:
    """Raise again what ended a campaign, and say what is kept of it."""
    if not as_json:  # of a campaign without an end stdout has no object
        delivery.show(as_json, {}, lambda console: _summarise(console, found))
    kept = f"{found.lives} of {found.asked} lives are finished, and in {folder / FILE}"
    if isinstance(ending, InputError):
        raise InputError(f"{ending}; {kept}") from None
    ending.__notes__ = [kept]
    raise ending


def _teller(
    campaign: "Campaign", finished: "dict[int, LifeResult]", progress: "ProgressTeller"
) -> "Callable[[int, LifeResult], None]":
    """Function that keeps each life that is finished, and tells of it."""
    from opensuction.evidence.lives import lives

    seeds, workers = campaign.seeds, campaign.workers
    progress.tell(
        f"{len(seeds)} lives, seeds {seeds.start} to {seeds.stop - 1}: twin, controller, "
        f"recorder and supervisor under a simulated clock; {workers} "
        f"{'process' if workers == 1 else 'processes'}"
    )

    def tell(number: int, found: "LifeResult") -> None:
        finished[number] = found
        for one in found.violations:
            progress.tell(
                f"life {lives.make_id(found.life.seed)} breaks '{one.invariant}': {one.detail}"
            )
        if len(finished) % EVERY_LIVES == 0 or len(finished) in (1, len(seeds)):
            progress.tell(f"{len(finished)} of {len(seeds)} lives")

    return tell


def _summarise(console: "Console", found: "LivesResult") -> None:
    for one in found.broken:
        console.print(f"life {one.id}: {', '.join(one.faults)}", soft_wrap=True)
        for violation in one.violations:
            console.print(f"  breaks '{violation.invariant}': {violation.detail}", soft_wrap=True)
        if one.fewest:
            console.print(f"  fewest faults that do so: {', '.join(one.fewest)}", soft_wrap=True)
        console.print(f"  {one.play}", soft_wrap=True)
    if not found.complete:
        console.print(f"Ended early, after {found.lives} of {found.asked} lives.", soft_wrap=True)
    console.print(
        f"{found.lives} lives, {found.simulated_h:.2f} h of a machine in {found.wall_s:.0f} s; "
        f"{len(found.broken)} broken; trace {found.trace}. In-silico: the machine and its computer "
        "are simulated, the processes are those that run a machine.",
        soft_wrap=True,
    )


def _show(console: "Console", given: str, found: "PlayedLife", folder: Path) -> None:
    for event in found.events:
        console.print(f"{event.at_s:8.3f} s  {event.what}", soft_wrap=True, highlight=False)
    for violation in found.violations:
        console.print(f"breaks '{violation.invariant}': {violation.detail}", soft_wrap=True)
    if found.fewest:
        console.print(f"fewest faults that do so: {', '.join(found.fewest)}", soft_wrap=True)
    if not found.violations and given == found.id:
        console.print(f"Life {given} no longer breaks anything.", soft_wrap=True)
    elif not found.violations:
        console.print("Nothing is broken in this life, with this version.")
    console.print(f"life {found.id}, trace {found.trace}. In-silico.", soft_wrap=True)
    console.print(f"Timeline: {folder / PAGE}", soft_wrap=True)
    for name in found.recordings:
        console.print(f"Recording: {folder / name}", soft_wrap=True)


COMMAND = Command(
    name="simulate",
    options=SimulateOptions,
    run=_carry_out,
    sentence="Lives of a whole machine under a simulated clock: its processes killed, frozen or "
    "late, and all that must hold all the same.",
    details="Twin, controller, recorder and supervisor are the processes of opensuction serve, run "
    "in one thread by a scheduler that a seed drives, a step at a time. A life is a cycle of a "
    "neonate with one to five faults between its steps: processes killed or frozen, the host "
    "standing still or busy, datagrams lost, late or twice, the wall clock set, a disk that is "
    "full, slow or fails, a database that is away, people who stop "
    "the machine or press twice. Judged are the truth of the twin, the records and every "
    "recording. The same seed gives the same life, in the same version alone: a life that broke "
    "something is named by both, 4711@VERSION. --play shows one life, and writes a timeline "
    "(report.html) and the recordings of its recorder, which replay, report and export take. "
    "Ctrl-C keeps the lives that are finished.",
    examples="""\b
Examples:
  opensuction simulate                         100 lives: some minutes
  opensuction simulate --lives 1000 --seed 5000
  opensuction simulate --faults kill,freeze
  opensuction simulate --cycles 3              three cycles a life
  opensuction simulate --play 4711             one life, event by event
  opensuction simulate --play 4711 --out runs/4711   and its timeline there
  opensuction simulate --json | jq '.broken[].play'

\b
Kinds of faults: kill, kill-writing, freeze, standstill, slow, wall-clock,
mail, disk-full, disk-failing, disk-slow, database, power, stop, impatient.""",
    ends="0 everything held in every life, 1 something did not, or process after process died",
)
