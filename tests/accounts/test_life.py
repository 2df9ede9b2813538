"""Any life of a site against a plain model: who gets in, who waits, whose session holds."""

from collections.abc import Callable
from datetime import datetime
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

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.directory import NewPassword
from opensuction.accounts.rule import sign_in_rule
from opensuction.accounts.rule.right import MUST_CHANGE, Role, rights_of
from opensuction.accounts.rule.sign_in_rule import ACCOUNT, DEVICE, ORIGIN, BackOff
from opensuction.accounts.site import (
    NotSignedInError,
    PasswordOverError,
    WaitError,
    WrongPasswordError,
)
from opensuction.kernel.errors import InputError
from opensuction.records.account_rows import Attempt, Bearer
from opensuction.records.records import Records
from tests.accounts.example import CHEAP, HERE, THERE, Clock
from tests.records.conftest import SELDOM_ON_BOTH

NAMES = st.sampled_from(["admin", "anna", "bert", "ghost"])
STAFF = st.sampled_from(["admin", "anna", "bert"])
ORIGINS = st.sampled_from([HERE, THERE])
PICKS = st.integers(0, 100)
STEPS_S = st.sampled_from([1, 31, 61, 300, 901, 1700, 1801, 40_000, 86_400, 8_000_000])
BACK_S = st.sampled_from([2, 200, 4000, 10_000_000])
RULES: dict[str, BackOff] = {"account": ACCOUNT, "origin": ORIGIN, "device": DEVICE}


class Life(RuleBasedStateMachine):
    """Accounts, and what they must do."""

    new_url: Callable[[], str]

    @initialize()
    def open(self) -> None:
        self.clock = Clock()
        self.url = self.new_url()
        self.records = Records.open(self.url, clock=self.clock)
        self.accounts = Accounts(self.records.database, self.clock, CHEAP)
        self.states: dict[str, tuple[Role, bool, bool]] = {"admin": (Role.OBSERVER, True, True)}
        self.passwords: dict[str, tuple[str, datetime | None]] = {}
        self.used: set[str] = set()
        """Whose one-time password has signed in."""
        self.sessions: dict[str, Bearer] = {}
        self.over: list[str] = []
        self.devices: dict[str, datetime] = {}
        self.knows: dict[tuple[str, str], datetime] = {}
        self.failed: dict[tuple[str, ...], Attempt] = {}
        made = self.accounts.first_start()
        assert made is not None
        self.give(made)
        for name, role in (("anna", Role.CLINICIAN), ("bert", Role.ENGINEER)):
            self.give(self.accounts.add(None, name, role))
            self.states[name] = (role, False, True)
        for name in ("admin", "anna"):
            self.sign_in(name, True, HERE, 1)
            self.change_password(len(self.sessions) - 1, True)

    def give(self, made: NewPassword) -> None:
        """What a new one-time password ends."""
        self.used.discard(made.account)
        self.passwords[made.account] = (made.one_time_password, made.expires_at)
        self.end(made.account)
        self.failed.pop(("account", made.account), None)

    def end(self, account: str, but: str = "") -> None:
        for token, bearer in list(self.sessions.items()):
            if bearer.account == account and token != but:
                del self.sessions[token]
                self.over.append(token)
        if not but:
            self.knows = {key: at for key, at in self.knows.items() if key[1] != account}

    def forget_old(self) -> None:
        now = self.clock.at
        for token, bearer in list(self.sessions.items()):
            if bearer.expires_at <= now:
                del self.sessions[token]
                self.over.append(token)
        self.devices = {one: at for one, at in self.devices.items() if at > now}
        self.knows = {one: at for one, at in self.knows.items() if at > now}
        oldest = now - sign_in_rule.MEMORY
        self.failed = {key: one for key, one in self.failed.items() if one.last_at >= oldest}

    def wait_s(self, lanes: list[tuple[str, ...]]) -> float:
        """How long to wait; failures of the future are of now."""
        for lane in lanes:
            if lane in self.failed and self.failed[lane].last_at > self.clock.at:
                self.failed[lane] = self.failed[lane]._replace(last_at=self.clock.at)
        return max(
            sign_in_rule.wait_s(RULES[lane[0]], self.failed.get(lane), self.clock.at)
            for lane in lanes
        )

    def charge(self, lanes: list[tuple[str, ...]]) -> None:
        for lane in lanes:
            before = self.failed.get(lane, Attempt(0, self.clock.at))
            is_forgotten = self.clock.at - before.last_at >= sign_in_rule.MEMORY
            self.failed[lane] = Attempt(1 if is_forgotten else before.failures + 1, self.clock.at)

    def forgive(self, lanes: list[tuple[str, ...]]) -> None:
        for lane in lanes:
            attempt = self.failed.pop(lane)
            if lane[0] == "origin" and attempt.failures > 1:
                self.failed[lane] = attempt._replace(failures=attempt.failures - 1)

    @rule(name=STAFF, origin=ORIGINS, device=PICKS)
    def enter(self, name: str, origin: str, device: int) -> None:
        self.sign_in(name, True, origin, device)

    @rule(name=NAMES, origin=ORIGINS, device=PICKS, times=st.integers(1, 9))
    def guess(self, name: str, origin: str, device: int, times: int) -> None:
        for _ in range(times):
            self.sign_in(name, False, origin, device)

    @rule(origin=ORIGINS)
    def try_many_names(self, origin: str) -> None:
        for number in range(ORIGIN.free - 2):
            self.sign_in(f"name{number}", False, origin, 0)

    def sign_in(self, name: str, is_right: bool, origin: str, device: int) -> None:
        self.forget_old()
        every = ["made up", None, *self.devices]
        shown = every[device % len(every)]
        lanes: list[tuple[str, ...]] = [("account", name), ("origin", origin)]
        if shown is not None and (shown, name) in self.knows:
            lanes = [("device", shown, name)]
        password, expires_at = self.passwords.get(name, ("", None))
        tried = password if is_right else "a guess"

        def call() -> Any:
            return self.accounts.sign_in(name, tried, origin, shown)

        before = self.records.head()
        wait_s = self.wait_s(lanes)
        if wait_s > 0.0:
            with pytest.raises(WaitError) as refused:
                call()
            assert wait_s <= refused.value.wait_s < wait_s + 1.0
            assert self.records.head() == before
            return
        self.charge(lanes)
        is_active = self.states.get(name, (None, False, False))[2]
        in_time = expires_at is None or (self.clock.at < expires_at and name not in self.used)
        if not (is_right and is_active and in_time):
            is_over = is_right and is_active
            with pytest.raises(PasswordOverError if is_over else WrongPasswordError):
                call()
            assert self.records.head().sequence > before.sequence
            return
        given = call()
        self.forgive(lanes)
        if expires_at is not None:
            self.used.add(name)
        assert (given.device_token == shown) == (shown in self.devices)
        now = self.clock.at
        self.devices[given.device_token] = now + sign_in_rule.KNOWN_DEVICE
        self.knows[given.device_token, name] = now + sign_in_rule.KNOWN_DEVICE
        bearer = Bearer("", "session", name, None, now, now, now + sign_in_rule.ABSOLUTE)
        self.sessions[given.session_token] = bearer

    def find(self, token: str) -> bool:
        """Whether a session holds; it goes on if so."""
        bearer = self.sessions.get(token)
        if bearer is None or sign_in_rule.has_ended(bearer, self.clock.at):
            with pytest.raises(NotSignedInError):
                self.accounts.find_session(token)
            return False
        session = self.accounts.find_session(token)
        name = str(bearer.account)
        role, is_administrator, _ = self.states[name]
        is_one_time = self.passwords[name][1] is not None
        rights = rights_of(role, is_administrator)
        assert (session.account, session.role) == (name, role)
        assert session.is_administrator == is_administrator
        assert session.must_change_password == is_one_time
        assert session.rights == (rights & MUST_CHANGE if is_one_time else rights)
        if abs(self.clock.at - bearer.seen_at) >= sign_in_rule.GRAIN:
            self.sessions[token] = bearer._replace(seen_at=self.clock.at)
        return True

    @rule(pick=PICKS, seconds=STEPS_S)
    def use_later(self, pick: int, seconds: int) -> None:
        self.clock.go_on(seconds=seconds)
        every = [*self.sessions, *self.over]
        self.find(every[pick % len(every)])

    @rule(pick=PICKS)
    def work_through_a_shift(self, pick: int) -> None:
        """Used every 20 minutes a session holds to its absolute end, and no longer."""
        if self.sessions:
            token = list(self.sessions)[pick % len(self.sessions)]
            while self.find(token):
                self.clock.go_on(minutes=20)

    @rule(pick=PICKS)
    def sign_out(self, pick: int) -> None:
        if self.sessions:
            token = list(self.sessions)[pick % len(self.sessions)]
            self.accounts.sign_out(token)
            del self.sessions[token]
            self.over.append(token)

    @rule(pick=PICKS, times=st.integers(1, 9))
    def guess_from_a_session(self, pick: int, times: int) -> None:
        for _ in range(times):
            self.change_password(pick, False)

    @rule(pick=PICKS)
    def take_another_password(self, pick: int) -> None:
        self.change_password(pick, True)

    def change_password(self, pick: int, is_right: bool) -> None:
        if not self.sessions:
            return
        token = list(self.sessions)[pick % len(self.sessions)]
        if not self.find(token):
            return
        name = str(self.sessions[token].account)
        present = self.passwords[name][0]
        wanted = f"velvet tractor {uuid4().hex}"
        lanes: list[tuple[str, ...]] = [("device", token, "")]
        wait_s = self.wait_s(lanes)

        def call() -> Any:
            return self.accounts.change_password(token, present if is_right else "no", wanted)

        if wait_s > 0.0:
            with pytest.raises(WaitError):
                call()
            return
        self.charge(lanes)
        if not is_right:
            with pytest.raises(WrongPasswordError):
                call()
            return
        call()
        self.forgive(lanes)
        self.passwords[name] = (wanted, None)
        self.end(name, but=token)

    @rule(name=STAFF, role=st.sampled_from(Role), is_administrator=st.booleans())
    def change(self, name: str, role: Role, is_administrator: bool) -> None:
        _, _, is_active = self.states[name]
        if self.is_last(name) and not is_administrator:
            with pytest.raises(InputError, match="last administrator"):
                self.accounts.change_role(None, name, role, is_administrator, "why not")
            return
        self.accounts.change_role(None, name, role, is_administrator, "why not")
        self.states[name] = (role, is_administrator, is_active)

    def is_last(self, name: str) -> bool:
        left = [one for one, (_, may, active) in self.states.items() if may and active]
        return left == [name]

    @rule(name=STAFF)
    def deactivate(self, name: str) -> None:
        if self.is_last(name):
            with pytest.raises(InputError, match="last administrator"):
                self.accounts.deactivate(None, name, "left")
            return
        self.accounts.deactivate(None, name, "left")
        if self.states[name][2]:
            self.states[name] = (*self.states[name][:2], False)
            self.passwords.pop(name)
            self.end(name)

    @rule(name=STAFF)
    def reset(self, name: str) -> None:
        self.give(self.accounts.reset_password(None, name))
        self.states[name] = (*self.states[name][:2], True)

    @rule(seconds=BACK_S)
    def set_back(self, seconds: int) -> None:
        self.clock.go_on(seconds=-seconds)

    @rule()
    def start_again(self) -> None:
        self.records.close()
        self.records = Records.open(self.url, clock=self.clock)
        self.accounts = Accounts(self.records.database, self.clock, CHEAP)
        assert self.accounts.first_start() is None

    @invariant()
    def lists_what_is(self) -> None:
        listed = {
            one.name: (one.role, one.is_administrator, one.is_active)
            for one in self.accounts.list_accounts()
        }
        assert listed == self.states
        assert any(may and active for _, may, active in listed.values())

    def teardown(self) -> None:
        if hasattr(self, "records"):
            for token in [*self.sessions, *self.over]:
                self.find(token)
            assert self.records.audit().broken is None
            self.records.close()


@pytest.mark.parametrize("kind", SELDOM_ON_BOTH)
def test_any_life_is_as_the_model_says(kind: str, request: pytest.FixtureRequest) -> None:
    if kind == "sqlite":
        folder = request.getfixturevalue("tmp_path")
        Life.new_url = staticmethod(lambda: str(folder / f"{uuid4().hex}.db"))
    else:
        Life.new_url = staticmethod(request.getfixturevalue("new_postgresql_url"))
    lives = max(6, settings().max_examples // 20)  # more in the long run
    run_state_machine_as_test(Life, settings=settings(max_examples=lives, stateful_step_count=40))
