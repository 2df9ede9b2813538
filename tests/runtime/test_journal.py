"""From rows to entries: once each, with the same keys whoever reads them again."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.controller.loop_tick import AT_REST
from opensuction.ipc.ring import ProcessEvent
from opensuction.kernel.vocabulary import CYCLE, RESTING, Phase
from opensuction.procedure.cycle.transition import Event as Transition
from opensuction.records.entry import Action, Alarm, CycleEnd, Outcome
from opensuction.runtime.journal import Begun, ControllerRun, Entry, Journal, in_words
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.safety.condition import Condition

RUN = ControllerRun("20261123T120000-0123abcd", 1_763_900_000_000_000_000)
COMPLETED = (Phase.PARKED, *(one for one in CYCLE if one != Phase.BACKING_OFF), Phase.PARKED)
ABORTED = (Phase.PARKED, Phase.CHECKING, Phase.INSERTING, Phase.ABORTING, Phase.HALTED)
RECOVERED = (Phase.ABORTING, Phase.HALTED)


def rows_of(phases: Sequence[Phase], each: int = 3) -> np.ndarray:
    """Rows in which each phase lasts some ticks."""
    rows = np.zeros((each * len(phases), len(ROW_COLUMNS)))
    put = {name: rows[:, i] for i, name in enumerate(ROW_COLUMNS)}
    put["inputs.tick"][:] = np.arange(len(rows))
    put["loop.time_s"][:] = 100.0 + 1e-3 * np.arange(len(rows))
    put["outputs.phase"][:] = np.repeat([int(one) for one in phases], each)
    put["outputs.cause"][:] = -1.0
    left = AT_REST
    for at, phase in enumerate(put["outputs.phase"]):
        left = AT_REST if phase in RESTING else (float(at) if left == AT_REST else left)
        put["loop.left_rest"][at] = left
    return rows


def started(who: str) -> ProcessEvent:
    fields = {"kind": "request", "ask": "start", "who": who, "verdict": "pressed", "time_ns": 5}
    return ProcessEvent(7, fields)


def follow(
    rows: np.ndarray, happened: Sequence[ProcessEvent] = (), cuts: Sequence[int] = ()
) -> list[Entry]:
    journal = Journal(RUN, None)
    entries: list[Entry] = []
    pieces = np.split(rows, sorted(cuts))
    for piece in pieces:
        entries.extend(journal.follow(piece, happened))
        happened = ()
    return entries


def kinds(entries: Sequence[Entry]) -> list[str]:
    return [type(one.what).__name__ for one in entries]


def test_a_cycle_has_a_beginning_an_end_and_whoever_asked_for_it() -> None:
    entries = follow(rows_of(COMPLETED), [started("nurse")])
    assert kinds(entries) == ["Action", "Begun", "CycleEnd"]
    assert entries[1].what == Begun("nurse", f"{RUN.name}-000000003.mcap")
    assert entries[2].what == CycleEnd(Outcome.COMPLETED, inside_at_end=False)
    assert (entries[2].at - entries[1].at).total_seconds() == pytest.approx(0.021, abs=1e-5)


def test_why_it_was_aborted_is_said() -> None:
    rows = rows_of(ABORTED)
    aborting = rows[:, ROW_COLUMNS.index("outputs.phase")] == Phase.ABORTING
    rows[aborting, ROW_COLUMNS.index("outputs.cause")] = Transition.TRIPPED
    trips = 1 << Condition.CATHETER_JAMMED
    rows[np.flatnonzero(aborting)[0] - 1, ROW_COLUMNS.index("outputs.verdict.trips")] = trips
    rows[aborting, ROW_COLUMNS.index("outputs.signals.present")] = trips
    entries = follow(rows)
    assert kinds(entries) == ["Begun", "Alarm", "CycleEnd"]
    assert isinstance(entries[1].what, Alarm)
    assert (entries[1].what.condition, entries[1].what.priority) == ("CATHETER_JAMMED", "high")
    assert entries[2].what == CycleEnd(Outcome.ABORTED, "tripped, catheter-jammed")


def test_a_controller_that_writes_no_more_leaves_a_cycle_that_was_broken_off() -> None:
    journal = Journal(RUN, None)
    rows = rows_of((Phase.PARKED, Phase.CHECKING, Phase.INSERTING))
    rows[:, ROW_COLUMNS.index("inputs.readings.head_mm")] = 12.25
    list(journal.follow(rows, ()))
    assert journal.is_in_cycle
    (entry,) = journal.end()
    assert entry.what == CycleEnd(
        Outcome.INTERRUPTED, "the controller died while inserting, the head at 12.2 mm"
    )
    assert list(journal.end()) == []


def test_a_way_out_after_a_start_is_no_cycle() -> None:
    (entry,) = follow(rows_of(RECOVERED))
    assert isinstance(entry.what, Action)
    assert (entry.what.what, entry.what.done_by) == ("drawn-out", "opensuction")


@given(cuts=st.lists(st.integers(0, 30), max_size=6), phases=st.sampled_from((COMPLETED, ABORTED)))
def test_in_whatever_pieces_rows_come_the_entries_are_the_same(
    cuts: list[int], phases: tuple[Phase, ...]
) -> None:
    rows = rows_of(phases)
    assert follow(rows, cuts=cuts) == follow(rows)


@given(at=st.integers(1, 26))
def test_a_reader_that_goes_on_anywhere_says_what_is_missing_and_nothing_else(at: int) -> None:
    rows = rows_of(COMPLETED)
    whole = follow(rows)
    first = Journal(RUN, None)
    said = list(first.follow(rows[:at], ()))
    goes_on = rows[at - 1, ROW_COLUMNS.index("loop.left_rest")] if first.is_in_cycle else AT_REST
    again = Journal(RUN, rows[at - 1], goes_on)
    assert [*said, *again.follow(rows[at:], ())] == whole
    assert all(a.key != b.key for a, b in pairwise(whole))


@given(st.text())
def test_whatever_somebody_calls_himself_is_a_name(text: str) -> None:
    name = in_words(text)
    assert 1 <= len(name) <= 64
    assert name.isprintable()
    assert name == name.strip()


def test_a_cycle_in_which_rows_are_missing_has_its_own_end() -> None:
    """The recorder came back later than the ring goes: the cycle that goes on is the same one."""
    rows = rows_of(COMPLETED)
    at = 4 * 3
    goes_on = rows[at, ROW_COLUMNS.index("loop.left_rest")]
    (end,) = list(Journal(RUN, None, goes_on).follow(rows[at:], ()))
    assert end.what == CycleEnd(Outcome.COMPLETED, inside_at_end=False)
    assert end.key == follow(rows)[-1].key


@pytest.mark.parametrize("phase", CYCLE)
def test_a_cycle_that_nobody_saw_begin_is_put_on_record_as_soon_as_it_is_seen(phase: Phase) -> None:
    """Its rows were overwritten before anybody read them: all that is known is which it is."""
    rows = rows_of((Phase.PARKED, Phase.CHECKING, phase, Phase.PARKED))[6:]
    begun = Journal(RUN, None, 3.0).find_begun(rows[0])
    assert begun is not None
    assert begun.what == Begun("unknown", "20261123T120000-0123abcd-000000003.mcap")
    late = Journal(RUN, rows_of((Phase.PARKED,))[-1])
    seen, ended = late.follow(rows, ())
    assert seen.what == begun.what
    assert seen.key == begun.key
    assert ended.what == CycleEnd(Outcome.COMPLETED, inside_at_end=False)


@pytest.mark.parametrize("phase", [one for one in Phase if one not in CYCLE])
def test_what_is_no_cycle_is_not_put_on_record_as_one(phase: Phase) -> None:
    rows = rows_of((phase,))
    assert Journal(RUN, None).find_begun(rows[0]) is None
    assert Journal(RUN, None).find_begun(None) is None


def test_rows_that_are_missing_are_on_record() -> None:
    rows = rows_of((Phase.PARKED,))
    entry = Journal(RUN, None).miss(rows[2], 4711)
    assert entry.what == Action(
        "opensuction", "rows-missed", "4711 ticks: what happened in them is not on record"
    )
    assert entry.key == "20261123T120000-0123abcd-2-missed"


def stopped(number: int, who: str, after_s: float) -> ProcessEvent:
    fields = {"kind": "request", "ask": "abort", "who": who, "verdict": "pressed"}
    return ProcessEvent(number, {**fields, "time_ns": int(after_s * 1e9)})


def test_whoever_may_stop_without_a_name_does_not_fill_the_records_by_doing_so_for_ever() -> None:
    here, there = "anybody (10.0.0.7)", "anybody (10.0.0.8)"
    happened = [
        *(stopped(number, here, number / 20.0) for number in range(400)),
        stopped(400, there, 20.0),
    ]
    acts = [
        (one.what.done_by, one.at)
        for one in follow(rows_of([Phase.PARKED]), happened)
        if isinstance(one.what, Action)
    ]
    assert [who for who, _ in acts] == [here, here, there]


def test_each_stop_of_somebody_who_signed_in_is_put_on_record() -> None:
    happened = [stopped(number, "anna", number / 20.0) for number in range(30)]
    acts = [
        one for one in follow(rows_of([Phase.PARKED]), happened) if isinstance(one.what, Action)
    ]
    assert len(acts) == 30
