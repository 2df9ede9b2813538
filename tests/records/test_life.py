"""Whole lives of a database, against a plain model: any requests, in any order, twice, reopened."""

from collections.abc import Callable
from datetime import datetime, timedelta
from typing import Any
from uuid import uuid4

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)

from opensuction.kernel.errors import InputError
from opensuction.records.entry import Action, CycleEnd, Outcome
from opensuction.records.records import Records
from tests.records.conftest import SELDOM_ON_BOTH
from tests.records.example import CLOGGED, MACHINE, NOON, start

MACHINES = st.sampled_from(["M-1", "M-2"])
CATHETERS = st.sampled_from(["C-1", "C-2", "C-3"])
KEYS = st.one_of(st.none(), st.sampled_from(["a", "b", "c", "d"]))
ENDS = st.builds(
    CycleEnd, st.sampled_from(Outcome), st.text("abc", max_size=3), st.sampled_from([True, None])
)
HOURS = st.integers(0, 30)
PICKS = st.integers(0, 100)


class Life(RuleBasedStateMachine):
    """Records, and what they must say."""

    new_url: Callable[[], str]

    @initialize()
    def open(self) -> None:
        self.url = self.new_url()
        self.records = Records.open(self.url)
        self.running: dict[str, str] = {}
        self.ends: dict[str, CycleEnd | None] = {}
        self.used: dict[str, list[datetime]] = {}
        self.begun: dict[str, list[datetime]] = {}
        self.catheter_of: dict[str, str] = {}
        self.machine_of: dict[str, str] = {}
        self.cycles: dict[str, list[str]] = {}
        self.alarms: dict[str, list[tuple[str, str | None]]] = {}
        self.actions: list[tuple[str, str | None]] = []
        self.said: dict[str, tuple[Any, str | None]] = {}
        self.heads = [self.records.head()]

    def ask(self, key: str | None, said: Any, call: Callable[[], str | None]) -> str | None:
        """What a request gives; a key that was used gives what it gave, or refuses another."""
        before = self.records.head()
        if key is not None and key in self.said:
            known, result = self.said[key]
            if known != said:
                with pytest.raises(InputError, match="that of another request"):
                    call()
            else:
                assert call() == result
            assert self.records.head() == before
            return None
        result = call()
        assert self.records.head().sequence > before.sequence
        if key is not None:
            self.said[key] = (said, result)
        return result or ""

    @rule(machine=MACHINES, catheter=CATHETERS, key=KEYS, hours=HOURS)
    def begin(self, machine: str, catheter: str, key: str | None, hours: int) -> None:
        asked, at = start(machine=machine, catheter=catheter), NOON + timedelta(hours=hours)
        if machine in self.running and key not in self.said:
            before = self.records.head()
            with pytest.raises(InputError, match="has not ended"):
                self.records.begin_cycle(asked, key, at)
            assert self.records.head() == before
            return
        cycle = self.ask(key, asked, lambda: self.records.begin_cycle(asked, key, at))
        if cycle is not None:
            self.running[machine], self.ends[cycle] = cycle, None
            self.used.setdefault(catheter, []).append(at)
            self.begun.setdefault(catheter, []).append(at)
            self.catheter_of[cycle], self.machine_of[cycle] = catheter, machine
            self.cycles.setdefault(machine, []).append(cycle)

    @rule(pick=PICKS, end=ENDS, key=KEYS, hours=HOURS)
    def end(self, pick: int, end: CycleEnd, key: str | None, hours: int) -> None:
        if not self.ends:
            return
        cycle = sorted(self.ends)[pick % len(self.ends)]
        at = NOON + timedelta(hours=hours)
        if self.ends[cycle] is not None and key not in self.said:
            with pytest.raises(InputError, match="has ended already"):
                self.records.end_cycle(cycle, end, key, at)
            return
        done = self.ask(key, (cycle, end), lambda: self.records.end_cycle(cycle, end, key, at))
        if done is not None:
            self.ends[cycle] = end
            self.used[self.catheter_of[cycle]].append(at)
            self.running = {name: one for name, one in self.running.items() if one != cycle}

    def alarm(self, serial: str, cycle: str | None, key: str | None) -> None:
        machine = MACHINE._replace(serial=serial)
        said = (serial, cycle)
        name = self.ask(key, said, lambda: self.records.add_alarm(machine, CLOGGED, cycle, key))
        if name is not None:
            self.alarms.setdefault(serial, []).append((name, cycle))

    @rule(pick=PICKS, key=KEYS)
    def alarm_in_a_cycle(self, pick: int, key: str | None) -> None:
        if self.ends:
            cycle = sorted(self.ends)[pick % len(self.ends)]
            self.alarm(self.machine_of[cycle], cycle, key)

    @rule(serial=MACHINES, key=KEYS)
    def alarm_at_rest(self, serial: str, key: str | None) -> None:
        self.alarm(serial, None, key)

    @rule(pick=PICKS, what=st.sampled_from(["reset", "assess"]), key=KEYS)
    def act(self, pick: int, what: str, key: str | None) -> None:
        cycle = sorted(self.ends)[pick % len(self.ends)] if self.ends and pick % 2 else None
        action = Action("nurse-7", what, cycle_id=cycle)
        name = self.ask(key, action, lambda: self.records.act(action, key))
        if name is not None:
            self.actions.append((name, cycle and self.machine_of[cycle]))

    @rule()
    def reopen(self) -> None:
        self.records.close()
        self.records = Records.open(self.url)

    @rule()
    def audit(self) -> None:
        self.heads.append(self.records.head())
        for head in self.heads:
            assert self.records.audit(head.hash).broken is None

    @invariant()
    def says_what_is(self) -> None:
        unfinished = {one.machine: one.id for one in self.records.unfinished_cycles()}
        assert unfinished == self.running
        for catheter, times in self.used.items():
            age_s = (max(NOON, *times) - min(self.begun[catheter])).total_seconds()
            assert self.records.catheter_age_s(catheter, NOON) == age_s

    @invariant()
    def lists_what_was_stored(self) -> None:
        history = self.records.history
        for machine in ("M-1", "M-2"):
            past = history.list_cycles(machine)
            assert [one.id for one in past] == self.cycles.get(machine, [])[::-1]
            assert [one.outcome for one in past] == [
                end and end.outcome for end in (self.ends[one.id] for one in past)
            ]
            alarms = [(one.id, one.cycle_id) for one in history.list_alarms(machine)]
            assert alarms == self.alarms.get(machine, [])[::-1]
            acts = [one.id for one in history.list_actions(machine)]
            assert acts == [name for name, serial in self.actions if serial == machine][::-1]
        assert [(one.id, one.machine) for one in history.list_actions()] == self.actions[::-1]

    def teardown(self) -> None:
        if hasattr(self, "records"):
            for cycle, end in self.ends.items():
                assert self.records.find_end(cycle) == end
            assert self.records.audit().broken is None
            self.records.close()


@pytest.mark.parametrize("kind", SELDOM_ON_BOTH)
def test_any_life_is_as_the_model_says(kind: str, request: pytest.FixtureRequest) -> None:
    if kind == "sqlite":
        folder = request.getfixturevalue("tmp_path")
        Life.new_url = staticmethod(lambda: str(folder / f"{uuid4().hex}.db"))
    else:
        make = request.getfixturevalue("new_postgresql_url")
        Life.new_url = staticmethod(make)
    lives = max(4, settings().max_examples // 50)  # more in the long run
    run_state_machine_as_test(Life, settings=settings(max_examples=lives, stateful_step_count=20))
