"""Signing in and out as people do it, and as those do who should not."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta

import argon2
import pytest

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.rule import sign_in_rule
from opensuction.accounts.rule.right import Right
from opensuction.accounts.rule.sign_in_rule import ACCOUNT, ORIGIN
from opensuction.accounts.session import require
from opensuction.accounts.site import (
    BusyError,
    Cost,
    NotAllowedError,
    NotSignedInError,
    PasswordHasher,
    RefusedError,
    WaitError,
    WrongPasswordError,
)
from opensuction.kernel.errors import InputError
from opensuction.records.records import Records
from tests.accounts.example import CHEAP, HERE, PASSWORDS, THERE, Clock, begin, employ
from tests.records.conftest import on_both, seldom_on_both

NO_NAMES = ("", "?", "\0", "\ud800", "' OR 1=1 --", "x" * 5000)
"""What no account is called."""


def wrong(accounts: Accounts, name: str = "anna", origin: str = THERE) -> RefusedError:
    """What is said of a wrong password."""
    with pytest.raises(RefusedError) as refused:
        accounts.sign_in(name, "not her password", origin)
    return refused.value


@on_both
def test_who_signs_in_may_what_the_role_may(accounts: Accounts, clock: Clock) -> None:
    employ(accounts, begin(accounts), "anna")
    signed_in = accounts.sign_in(" Anna ", PASSWORDS["anna"], HERE)
    session = accounts.find_session(signed_in.session_token)
    assert session == signed_in.session
    assert (session.account, session.role, session.is_administrator) == ("anna", "clinician", False)
    assert session.ends_at == clock.at + sign_in_rule.IDLE
    require(session, Right.START)
    require(session, Right.STOP)
    with pytest.raises(NotAllowedError, match="anna may not: Change limits"):
        require(session, Right.CHANGE_LIMITS, "the child grew")


def test_nobody_must_sign_in_to_stop(accounts: Accounts) -> None:
    assert accounts.first_start() is not None
    require(None, Right.STOP)
    with pytest.raises(NotSignedInError, match="sign in first"):
        require(None, Right.START)


def test_a_right_that_needs_a_reason_is_refused_without(accounts: Accounts) -> None:
    session = accounts.find_session(employ(accounts, begin(accounts), "bert").session_token)
    for reason in (None, "", "  "):
        with pytest.raises(InputError, match="say why"):
            require(session, Right.CHANGE_LIMITS, reason)
    require(session, Right.CHANGE_LIMITS, "the child grew")


def test_one_line_says_no_more_than_that_it_was_wrong(accounts: Accounts) -> None:
    admin = begin(accounts)
    employ(accounts, admin, "anna")
    employ(accounts, admin, "cora")
    accounts.deactivate(admin, "cora", "left the ward")
    said = {str(wrong(accounts, name)) for name in ("anna", "nobody.here", *NO_NAMES)}
    with pytest.raises(WrongPasswordError) as refused:
        accounts.sign_in("cora", PASSWORDS["cora"], THERE)
    assert said == {str(refused.value)} == {"name or password is wrong"}


def test_a_name_that_nobody_has_waits_as_long_as_any(accounts: Accounts, clock: Clock) -> None:
    employ(accounts, begin(accounts), "anna")
    waits: dict[str, list[int]] = {}
    for name, origin in (("anna", "10.0.0.1"), ("nobody.here", "10.0.0.2")):
        for _ in range(9):
            said = wrong(accounts, name, origin)
            waits.setdefault(name, []).append(getattr(said, "wait_s", 0))
            clock.go_on(seconds=1)
    assert waits["anna"] == waits["nobody.here"]
    assert waits["anna"][:6] == [0, 0, 0, 0, 0, 29]


def test_a_session_ends_when_it_is_not_used_and_after_a_shift(
    accounts: Accounts, clock: Clock
) -> None:
    token = employ(accounts, begin(accounts), "anna").session_token
    clock.go_on(minutes=29)
    accounts.find_session(token)
    clock.go_on(minutes=29)
    accounts.find_session(token)
    clock.go_on(minutes=30)
    with pytest.raises(NotSignedInError, match="the session is over"):
        accounts.find_session(token)
    token = accounts.sign_in("anna", PASSWORDS["anna"], HERE).session_token
    for _ in range(12 * 3 - 1):
        clock.go_on(minutes=20)
        session = accounts.find_session(token)
    assert session.ends_at == clock.at + timedelta(minutes=20)
    clock.go_on(minutes=20)
    with pytest.raises(NotSignedInError, match="the session is over"):
        accounts.find_session(token)


@on_both
def test_a_session_outlives_the_console(accounts: Accounts, records: Records, url: str) -> None:
    token = employ(accounts, begin(accounts), "anna").session_token
    with Records.open(url) as again:
        other = Accounts(again.database, records._clock, CHEAP)
        assert other.find_session(token).account == "anna"


def test_who_signs_out_is_out_and_nobody_else(accounts: Accounts) -> None:
    admin = begin(accounts)
    first = employ(accounts, admin, "anna")
    second = accounts.sign_in("anna", PASSWORDS["anna"], HERE)
    accounts.sign_out(first.session_token)
    accounts.sign_out(first.session_token)
    accounts.sign_out("never given")
    with pytest.raises(NotSignedInError):
        accounts.find_session(first.session_token)
    accounts.find_session(second.session_token)


@seldom_on_both
@pytest.mark.parametrize("shown", [None, "", "0" * 64, "\ud800", "x" * 10_000])
def test_a_change_needs_what_only_its_page_has(accounts: Accounts, shown: str | None) -> None:
    admin = begin(accounts)
    anna, bert = employ(accounts, admin, "anna"), employ(accounts, admin, "bert")
    accounts.find_session_for_change(anna.session_token, anna.csrf_token)
    for wrong_one in (shown, bert.csrf_token):
        with pytest.raises(NotAllowedError, match="does not come from the page"):
            accounts.find_session_for_change(anna.session_token, wrong_one)


@seldom_on_both
@pytest.mark.parametrize("token", ["", "0" * 64, "\ud800", "x" * 100_000])
def test_a_token_that_was_never_given_is_refused(accounts: Accounts, token: str) -> None:
    begin(accounts)
    with pytest.raises(NotSignedInError):
        accounts.find_session(token)
    with pytest.raises(NotSignedInError):
        accounts.find_token(token)


def test_no_token_stands_for_another_kind(accounts: Accounts) -> None:
    admin = begin(accounts)
    anna = employ(accounts, admin, "anna")
    made = accounts.issue_token(admin, "display", ["see-history"], timedelta(days=1))
    for token in (made.token, anna.device_token, anna.csrf_token):
        with pytest.raises(NotSignedInError):
            accounts.find_session(token)
    for token in (anna.session_token, anna.device_token):
        with pytest.raises(NotSignedInError):
            accounts.find_token(token)


def test_a_guesser_waits_and_the_guessed_does_not(accounts: Accounts, clock: Clock) -> None:
    """From a browser where she has signed in she always gets in, whatever others try."""
    device = employ(accounts, begin(accounts), "anna").device_token
    for _ in range(300):
        wrong(accounts)
        clock.go_on(seconds=10)
    with pytest.raises(WaitError) as refused:
        accounts.sign_in("anna", PASSWORDS["anna"], THERE)
    assert 0 < refused.value.wait_s <= ACCOUNT.longest_s
    signed_in = accounts.sign_in("anna", PASSWORDS["anna"], THERE, device)
    assert signed_in.device_token == device
    assert isinstance(wrong(accounts), WaitError), "which helps the guesser nothing"


@seldom_on_both
def test_a_wait_ends_whoever_goes_on_trying(accounts: Accounts, clock: Clock) -> None:
    employ(accounts, begin(accounts), "anna")
    for _ in range(40):
        wrong(accounts)
    for _ in range(int(ACCOUNT.longest_s)):
        clock.go_on(seconds=1)
        with pytest.raises(RefusedError):
            accounts.sign_in("anna", "not her password", THERE)
    waited_s = 0
    while True:
        try:
            accounts.sign_in("anna", PASSWORDS["anna"], HERE)
        except WaitError as refused:
            waited_s += refused.wait_s
            clock.go_on(seconds=refused.wait_s)
        else:
            break
    assert waited_s <= ACCOUNT.longest_s


def test_an_address_that_tries_many_names_waits_and_others_do_not(accounts: Accounts) -> None:
    employ(accounts, begin(accounts), "anna")
    for number in range(ORIGIN.free):
        assert isinstance(wrong(accounts, f"name{number}"), WrongPasswordError)
    said = wrong(accounts, "another")
    assert isinstance(said, WaitError)
    assert said.wait_s <= ORIGIN.longest_s
    assert accounts.sign_in("anna", PASSWORDS["anna"], HERE)


def test_a_valid_account_does_not_clear_the_count_of_its_address(accounts: Accounts) -> None:
    employ(accounts, begin(accounts), "cora")
    for number in range(ORIGIN.free):
        assert isinstance(wrong(accounts, f"name{number}"), WrongPasswordError)
        if number < ORIGIN.free - 1:
            accounts.sign_in("cora", PASSWORDS["cora"], THERE)
    assert isinstance(wrong(accounts, "another"), WaitError)


def test_a_browser_is_shared_by_several_people(accounts: Accounts) -> None:
    admin = begin(accounts)
    device = employ(accounts, admin, "anna").device_token
    employ(accounts, admin, "bert")
    assert accounts.sign_in("bert", PASSWORDS["bert"], HERE, device).device_token == device
    for name in ("anna", "bert"):
        for _ in range(40):
            wrong(accounts, name)
        accounts.sign_in(name, PASSWORDS[name], THERE, device)
    employ(accounts, admin, "cora")
    for _ in range(40):
        wrong(accounts, "cora")
    with pytest.raises(WaitError):
        accounts.sign_in("cora", PASSWORDS["cora"], THERE, device)


def test_a_device_that_a_browser_made_up_is_replaced(accounts: Accounts) -> None:
    employ(accounts, begin(accounts), "anna")
    for made_up in ("", "mine", "\ud800"):
        given = accounts.sign_in("anna", PASSWORDS["anna"], HERE, made_up).device_token
        assert given != made_up
        assert len(given) > 40


def test_a_clock_set_back_keeps_nobody_out(accounts: Accounts, clock: Clock) -> None:
    employ(accounts, begin(accounts), "anna")
    clock.go_on(days=300)
    for _ in range(5 + 6):
        wrong(accounts)
        clock.go_on(seconds=60)
    clock.go_on(days=-300)
    with pytest.raises(WaitError) as refused:
        accounts.sign_in("anna", PASSWORDS["anna"], HERE)
    clock.go_on(seconds=refused.value.wait_s)
    accounts.sign_in("anna", PASSWORDS["anna"], HERE)


@on_both
def test_many_guesses_at_once_gain_nothing(accounts: Accounts) -> None:
    employ(accounts, begin(accounts), "anna")
    with ThreadPoolExecutor(8) as threads:
        said = list(threads.map(lambda _: type(wrong(accounts)), range(40)))
    assert said.count(WrongPasswordError) == ACCOUNT.free
    assert said.count(WaitError) == 40 - ACCOUNT.free


def test_a_failure_of_the_hash_counts_for_nobody(
    accounts: Accounts, monkeypatch: pytest.MonkeyPatch
) -> None:
    employ(accounts, begin(accounts), "anna")

    def fail(*_: object) -> bool:
        raise MemoryError

    monkeypatch.setattr(argon2.PasswordHasher, "verify", fail)
    for _ in range(3 * ORIGIN.free):
        with pytest.raises(BusyError):
            accounts.sign_in("anna", PASSWORDS["anna"], HERE)
    monkeypatch.undo()
    accounts.sign_in("anna", PASSWORDS["anna"], HERE)


def test_a_hash_of_another_cost_is_made_anew(
    accounts: Accounts, records: Records, clock: Clock
) -> None:
    employ(accounts, begin(accounts), "anna")
    dearer = PasswordHasher(Cost(1, 16, 1))
    newer = Accounts(records.database, clock, dearer)
    newer.sign_in("anna", PASSWORDS["anna"], HERE)
    with newer._site.reading() as rows:
        credential = rows.find_credential("anna")
    assert credential is not None
    assert not dearer.is_outdated(credential.password_hash)
    assert not credential.is_one_time
    newer.sign_in("anna", PASSWORDS["anna"], HERE)


CHANGES: dict[str, tuple[Callable[[str], tuple[str, str]], type[InputError], str]] = {
    "wrong": (lambda _: ("no", "lamps under seven rivers"), WrongPasswordError, "is wrong"),
    "short": (lambda known: (known, "short"), InputError, "15 to 128"),
    "common": (lambda known: (known, "Password1234567"), InputError, "tried first"),
    "the name": (lambda known: (known, "anna walks home at 5"), InputError, "holds 'anna'"),
    "the same": (lambda known: (known, known), InputError, "is the present one"),
}


@seldom_on_both
@pytest.mark.parametrize("kind", CHANGES)
def test_a_password_that_is_not_taken_changes_nothing(accounts: Accounts, kind: str) -> None:
    token = employ(accounts, begin(accounts), "anna").session_token
    make, error, words = CHANGES[kind]
    with pytest.raises(error, match=words):
        accounts.change_password(token, *make(PASSWORDS["anna"]))
    accounts.find_session(token)
    accounts.sign_in("anna", PASSWORDS["anna"], HERE)


def test_a_changed_password_ends_all_other_sessions(accounts: Accounts) -> None:
    first = employ(accounts, begin(accounts), "anna").session_token
    second = accounts.sign_in("anna", PASSWORDS["anna"], HERE).session_token
    accounts.change_password(first, PASSWORDS["anna"], "lamps under seven rivers")
    accounts.find_session(first)
    with pytest.raises(NotSignedInError):
        accounts.find_session(second)
    with pytest.raises(WrongPasswordError):
        accounts.sign_in("anna", PASSWORDS["anna"], HERE)
    accounts.sign_in("anna", "lamps under seven rivers", HERE)


def test_a_session_that_was_left_open_is_no_way_to_guess_the_password(accounts: Accounts) -> None:
    token = employ(accounts, begin(accounts), "anna").session_token
    for _ in range(ACCOUNT.free):
        with pytest.raises(WrongPasswordError):
            accounts.change_password(token, "a guess", "lamps under seven rivers")
    with pytest.raises(WaitError):
        accounts.change_password(token, PASSWORDS["anna"], "lamps under seven rivers")
    accounts.find_session(token)
