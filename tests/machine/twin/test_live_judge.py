"""The judge of a machine that runs, against the judge of a simulated run, and beside processes."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from opensuction.ipc.ring import RingWriter
from opensuction.kernel.codegen import plain_row, row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import MESSAGE_COLUMNS
from opensuction.kernel.record import Array
from opensuction.machine import port
from opensuction.machine.twin.live_judge import LiveJudge, Verdict
from opensuction.machine.twin.twin_process import BEGUN, SHOWN
from opensuction.oracle.harm import ADVANCE, AIRWAY_TIME, CONTACT_TIME, LEFT_INSIDE
from opensuction.safety.condition import Condition
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import injection, run_judgement
from opensuction.simulation.injection.run_judgement import Judgement
from opensuction.simulation.machine_side import SHOWN_COLUMNS, MachineSide
from opensuction.simulation.trace import Columns
from tests.simulation.test_machine_side import call_of, side_of

SLOTS = 5000
RINGS = {"version": "1", "most": "{}"}


@cache
def prepared() -> Prepared:
    choice = CycleChoice(RigChoice(patient="neonate", seed=3), compensation="exact-inverse")
    return cycle_run.prepare(resolution.resolve(choice))


@cache
def played(*faults: str) -> tuple[Columns, Judgement]:
    """A simulated cycle, and what its judge says."""
    made = prepared()
    asked = [resolution.parse(one) for one in faults]
    # Where the catheter is left inside it stays there for longer than it may.
    after_s = 30.0 if any("lost" in one for one in faults) else 5.0
    run = injection.run(made.loop, made.start, asked, after_s=after_s)
    cap_mm = made.loop.controller.limits.cap_mm
    return run.columns, run_judgement.judge(made.rig.machine, cap_mm, run.columns, run.faults)


def rows_of(columns: Columns) -> Array:
    """The ring's rows of a simulated run."""
    zeros = np.zeros(columns["time_s"].size)
    table = np.stack([columns.get(name, zeros) for name in SHOWN_COLUMNS], axis=1)
    table[:, SHOWN_COLUMNS.index("tick")] = np.arange(len(table))
    return table


def begun(folder: Path) -> RingWriter:
    """A twin that somebody else plays."""
    np.savez(folder / BEGUN, side=plain_row.pack(MachineSide, side_of(prepared().loop)))
    return RingWriter(folder / SHOWN, SHOWN_COLUMNS, SLOTS, RINGS)


def seen(folder: Path, columns: Columns, piece: int) -> Verdict:
    """What somebody says who looks after so many ticks."""
    table = rows_of(columns)
    with begun(folder) as ring:
        witness = LiveJudge(port.open_truth(folder), prepared().loop.controller.limits.cap_mm)
        for first in range(0, len(table), piece):
            for values in table[first : first + piece]:
                ring.write(values)
            witness.look()
        return witness.verdict()


@pytest.mark.parametrize(
    "faults",
    [
        (),
        ("controller-stopped@inserting+1",),
        ("cough@suctioning+0.5=150",),
        ("motor-lost@suctioning+0.5",),
        ("power-lost-without-reserve@suctioning",),
    ],
    ids=str,
)
@pytest.mark.parametrize("piece", [17, 3000])
def test_it_says_what_the_judge_of_the_same_simulated_run_says(
    tmp_path: Path, faults: tuple[str, ...], piece: int
) -> None:
    columns, judged = played(*faults)
    found = seen(tmp_path, columns, piece)
    assert found.missed_ticks == 0
    assert found.harm == judged.harm
    assert found.told == judged.told
    assert found.inside_at_end == judged.borne.inside_at_end
    assert found.end_mm == judged.borne.end_mm
    tip = columns["truth.tip_mm"]
    inside = np.flatnonzero(tip > judged.borne.outside_mm)
    assert found.last_inside_s == columns["time_s"][inside[-1]]
    stay = found.runs[0].borne
    assert stay.in_airway_s == pytest.approx(judged.borne.in_airway_s, abs=1e-6)
    for name in ("deepest_mm", "force_peak_n", "vacuum_peak_mmhg", "advance_mm", "suction_s"):
        assert getattr(stay, name) == pytest.approx(getattr(judged.borne, name), abs=1e-9)


def test_two_cycles_are_two_runs_and_what_the_second_did_is_found(tmp_path: Path) -> None:
    healthy, _ = played()
    broken, judged = played("motor-lost@suctioning+0.5")
    found = seen(
        tmp_path, {name: np.concatenate((healthy[name], broken[name])) for name in healthy}, 900
    )
    stays = [one for one in found.runs if one.borne.in_airway_s > 0.0]
    assert [bool(one.harm) for one in stays] == [False, True]
    assert [one.name for one in found.harm] == [one.name for one in judged.harm]
    for mine, other in zip(found.harm, judged.harm, strict=True):
        assert mine.worst == pytest.approx(other.worst, abs=1e-6)


def test_the_harms_of_those_runs_are_what_was_done(tmp_path: Path) -> None:
    """So that equal is not both of nothing."""
    assert played()[1].harm == ()
    assert {one.name for one in played("cough@suctioning+0.5=150")[1].harm} == {ADVANCE}
    left = played("motor-lost@suctioning+0.5")[1]
    assert {one.name for one in left.harm} >= {LEFT_INSIDE, AIRWAY_TIME}
    columns, _ = played("controller-stopped@inserting+1")
    found = seen(tmp_path, columns, 1000)
    drives = [one for one in found.told if one.by == "drives"]
    assert Condition.WATCHDOG_FIRED in [one.condition for one in drives]
    assert Condition.WATCHDOG_FIRED in found.showing
    assert found.told_since(drives[-1].at_s) == found.told[found.told.index(drives[-1]) :]


def test_it_finds_the_carina_that_was_moved_under_a_cycle_which_goes_on(tmp_path: Path) -> None:
    """The twin that is played is another one than the one it began with."""
    columns, _ = played()
    call, zeros = call_of(prepared().loop, prepared().start), np.zeros(columns["time_s"].size)
    call.side_row[row.columns(MachineSide).index("machine.airway.carina_mm")] -= 30.0
    commands = np.stack([columns.get(name, zeros) for name in MESSAGE_COLUMNS], axis=1)
    with begun(tmp_path) as ring:
        witness = LiveJudge(port.open_truth(tmp_path), prepared().loop.controller.limits.cap_mm)
        for tick, sent in enumerate(commands):
            call.step(sent, new=True)
            ring.write(call.shown_row)
            if tick % 1000 == 0:
                witness.look()
        found = {one.name for one in witness.verdict().harm}
    assert CONTACT_TIME in found  # a catheter this thin buckles before it presses too much


def test_what_nobody_saw_is_counted(tmp_path: Path) -> None:
    columns, _ = played()
    found = seen(tmp_path, columns, SLOTS + 2000)
    assert found.missed_ticks >= 2000 * (columns["time_s"].size // (SLOTS + 2000))


def test_where_nothing_plays_that_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no ring at"):
        LiveJudge(port.open_truth(tmp_path), 30.0)
    with RingWriter(tmp_path / SHOWN, SHOWN_COLUMNS, 10, RINGS):
        with pytest.raises(InputError, match="no machine to judge"):
            LiveJudge(port.open_truth(tmp_path), 30.0)
        np.savez(tmp_path / BEGUN, side=plain_row.pack(MachineSide, side_of(prepared().loop)))
        with pytest.raises(InputError, match="has not played a tick"):
            LiveJudge(port.open_truth(tmp_path), 30.0).verdict()
    with (
        RingWriter(tmp_path / SHOWN, ("a", "b"), 10, RINGS),
        pytest.raises(InputError, match="another version"),
    ):
        LiveJudge(port.open_truth(tmp_path), 30.0)
