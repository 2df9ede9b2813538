"""Accounts are made, changed and ended by who may; somebody is always left who can."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.rule import sign_in_rule
from opensuction.accounts.rule.right import Right, Role
from opensuction.accounts.session import Session, require
from opensuction.accounts.site import (
    NotAllowedError,
    NotSignedInError,
    PasswordOverError,
    WrongPasswordError,
)
from opensuction.kernel.errors import InputError
from opensuction.records.records import Records
from tests.accounts.example import HERE, PASSWORDS, THERE, Clock, begin, employ, enter
from tests.records.conftest import on_both, seldom_on_both


def test_the_first_start_makes_an_administrator_who_must_change_the_password(
    accounts: Accounts, clock: Clock
) -> None:
    made = accounts.first_start()
    assert made is not None
    assert (made.account, made.expires_at) == ("admin", clock.at + sign_in_rule.ONE_TIME)
    signed_in = accounts.sign_in("admin", made.one_time_password, HERE)
    assert signed_in.session.must_change_password
    require(signed_in.session, Right.STOP)
    with pytest.raises(NotAllowedError, match="change the one-time password first"):
        require(signed_in.session, Right.MANAGE_ACCOUNTS)
    with pytest.raises(NotAllowedError, match="admin may not: Manage accounts"):
        accounts.add(signed_in.session, "anna", "clinician")
    session = accounts.change_password(
        signed_in.session_token, made.one_time_password, PASSWORDS["admin"]
    )
    assert not session.must_change_password
    accounts.add(session, "anna", "clinician")
    with pytest.raises(WrongPasswordError):
        accounts.sign_in("admin", made.one_time_password, HERE)


def test_each_start_makes_another_password_until_the_first_is_changed(accounts: Accounts) -> None:
    first, second = accounts.first_start(), accounts.first_start()
    assert first is not None
    assert second is not None
    with pytest.raises(WrongPasswordError):
        accounts.sign_in("admin", first.one_time_password, HERE)
    enter(accounts, "admin", second.one_time_password)
    assert accounts.first_start() is None


@on_both
def test_two_programs_that_start_at_once_make_one_administrator(accounts: Accounts) -> None:
    with ThreadPoolExecutor(4) as threads:
        made = [one for one in threads.map(lambda _: accounts.first_start(), range(4)) if one]
    assert [one.name for one in accounts.list_accounts()] == ["admin"]
    works = []
    for one in made:
        try:
            works.append(accounts.sign_in("admin", one.one_time_password, HERE))
        except WrongPasswordError:
            continue
    assert len(works) == 1


def test_a_one_time_password_holds_for_a_day(accounts: Accounts, clock: Clock) -> None:
    admin = begin(accounts)
    made = accounts.add(admin, "anna", "clinician")
    clock.go_on(hours=24)
    with pytest.raises(WrongPasswordError):
        accounts.sign_in("anna", made.one_time_password, HERE)
    again = accounts.reset_password(None, "anna")
    accounts.sign_in("anna", again.one_time_password, HERE)


def test_a_one_time_password_signs_in_once(accounts: Accounts, clock: Clock) -> None:
    admin = begin(accounts)
    made = accounts.add(admin, "anna", "clinician")
    first = accounts.sign_in("anna", made.one_time_password, HERE)
    clock.go_on(days=-1)
    for origin, device in ((HERE, first.device_token), (THERE, None)):
        with pytest.raises(PasswordOverError, match="signs in once") as refused:
            accounts.sign_in("anna", made.one_time_password, origin, device)
        assert "opensuction users reset-password" in str(refused.value)
    with pytest.raises(WrongPasswordError, match="name or password is wrong"):
        accounts.sign_in("anna", "a guess at it", HERE)
    clock.go_on(days=1)
    # Whoever is signed in by it still chooses a password, and one who left needs another one.
    accounts.change_password(first.session_token, made.one_time_password, PASSWORDS["anna"])
    accounts.sign_in("anna", PASSWORDS["anna"], HERE, first.device_token)
    again = accounts.reset_password(None, "anna")
    with pytest.raises(WrongPasswordError):
        accounts.sign_in("anna", made.one_time_password, HERE)
    assert accounts.sign_in("anna", again.one_time_password, HERE).session.must_change_password


@on_both
def test_only_one_of_two_at_once_signs_in_by_a_one_time_password(accounts: Accounts) -> None:
    made = accounts.add(begin(accounts), "anna", "clinician")

    def enter_once(_: int) -> bool:
        try:
            accounts.sign_in("anna", made.one_time_password, HERE)
        except PasswordOverError:
            return False
        return True

    with ThreadPoolExecutor(4) as threads:
        assert sum(threads.map(enter_once, range(4))) == 1


@on_both
def test_accounts_are_listed_as_they_are(accounts: Accounts, clock: Clock) -> None:
    admin = begin(accounts)
    employ(accounts, admin, "anna")
    accounts.add(admin, "bert", "engineer", True)
    accounts.deactivate(admin, "anna", "left the ward")
    listed = {one.name: one for one in accounts.list_accounts()}
    assert list(listed) == ["admin", "anna", "bert"]
    assert listed["admin"].is_administrator
    assert listed["admin"].role == Role.OBSERVER
    assert not listed["admin"].has_one_time_password
    assert (listed["anna"].is_active, listed["anna"].password_set_at) == (False, None)
    assert (listed["bert"].role, listed["bert"].is_administrator) == (Role.ENGINEER, True)
    assert listed["bert"].has_one_time_password
    assert listed["bert"].password_set_at == clock.at


def test_a_role_holds_from_the_next_request_on(accounts: Accounts) -> None:
    admin = begin(accounts)
    token = employ(accounts, admin, "cora").session_token
    accounts.change_role(admin, "cora", "clinician", False, "passed her training")
    require(accounts.find_session(token), Right.START)
    accounts.change_role(admin, "cora", "observer", False, "back to school")
    with pytest.raises(NotAllowedError):
        require(accounts.find_session(token), Right.START)


def test_who_is_deactivated_is_out_at_once_and_may_come_back(accounts: Accounts) -> None:
    admin = begin(accounts)
    signed_in = employ(accounts, admin, "anna")
    accounts.deactivate(admin, "anna", "left the ward")
    accounts.deactivate(admin, "anna", "twice changes nothing")
    with pytest.raises(NotSignedInError):
        accounts.find_session(signed_in.session_token)
    with pytest.raises(WrongPasswordError):
        accounts.sign_in("anna", PASSWORDS["anna"], HERE, signed_in.device_token)
    with pytest.raises(InputError, match="there is an account 'anna' already"):
        accounts.add(admin, "anna", "observer")
    made = accounts.reset_password(admin, "anna")
    assert accounts.sign_in("anna", made.one_time_password, HERE).session.role == Role.CLINICIAN
    with pytest.raises(WrongPasswordError):
        accounts.sign_in("anna", PASSWORDS["anna"], HERE)


def test_a_reset_ends_sessions_and_waits(accounts: Accounts) -> None:
    admin = begin(accounts)
    token = employ(accounts, admin, "anna").session_token
    for _ in range(9):
        with pytest.raises(InputError):
            accounts.sign_in("anna", "a guess", THERE)
    made = accounts.reset_password(admin, "anna")
    with pytest.raises(NotSignedInError):
        accounts.find_session(token)
    accounts.sign_in("anna", made.one_time_password, HERE)


def test_one_administrator_is_always_left(accounts: Accounts) -> None:
    admin = begin(accounts)
    last = "'admin' is the last administrator: make another one first"
    with pytest.raises(InputError, match=last):
        accounts.deactivate(admin, "admin", "a mistake")
    with pytest.raises(InputError, match=last):
        accounts.change_role(None, "admin", "engineer", False, "a mistake")
    accounts.change_role(admin, "admin", "engineer", True, "knows the machine")
    accounts.add(admin, "bert", "engineer", True)
    accounts.deactivate(admin, "bert", "left")
    with pytest.raises(InputError, match=last):
        accounts.deactivate(None, "admin", "the other one cannot sign in")
    accounts.reset_password(admin, "bert")
    accounts.deactivate(admin, "admin", "bert does it")
    assert [one.is_active for one in accounts.list_accounts()] == [False, True]


def test_the_first_account_of_a_site_is_an_administrator(accounts: Accounts) -> None:
    with pytest.raises(InputError, match="the first account must be one"):
        accounts.add(None, "anna", "clinician")
    made = accounts.add(None, "eva", "engineer", True)
    accounts.add(None, "anna", "clinician")
    assert accounts.first_start() is None
    assert accounts.sign_in("eva", made.one_time_password, HERE)


@on_both
def test_two_administrators_cannot_end_each_other_at_once(accounts: Accounts) -> None:
    admin = begin(accounts)
    accounts.add(admin, "bert", "engineer", True)

    def end(name: str) -> str:
        try:
            accounts.deactivate(None, name, "a quarrel")
        except InputError as refused:
            return str(refused)
        return ""

    with ThreadPoolExecutor(2) as threads:
        said = sorted(threads.map(end, ["admin", "bert"]))
    assert said[0] == ""
    assert "is the last administrator" in said[1]


def calls(accounts: Accounts, by: Session) -> list[Callable[[], object]]:
    return [
        lambda: accounts.add(by, "dora", "clinician"),
        lambda: accounts.change_role(by, "anna", "engineer", True, "wants to"),
        lambda: accounts.deactivate(by, "bert", "a quarrel"),
        lambda: accounts.reset_password(by, "bert"),
    ]


def test_only_an_administrator_manages_accounts(accounts: Accounts, records: Records) -> None:
    admin = begin(accounts)
    employ(accounts, admin, "bert")
    token = employ(accounts, admin, "anna").session_token
    anna = accounts.find_session(token)
    forged = anna._replace(is_administrator=True, rights=frozenset(Right))
    before = records.head()
    for session in (anna, forged):
        for call in calls(accounts, session):
            with pytest.raises(NotAllowedError, match="anna may not: Manage accounts"):
                call()
    assert records.head() == before


def test_rights_that_were_taken_or_a_session_that_ended_count_no_more(accounts: Accounts) -> None:
    admin = begin(accounts)
    employ(accounts, admin, "anna")
    token = employ(accounts, admin, "bert").session_token
    accounts.change_role(admin, "bert", "engineer", True, "helps out")
    bert = accounts.find_session(token)
    accounts.add(bert, "eva", "observer")
    accounts.change_role(admin, "bert", "engineer", False, "no more")
    for call in calls(accounts, bert):
        with pytest.raises(NotAllowedError):
            call()
    accounts.change_role(admin, "bert", "engineer", True, "once more")
    accounts.sign_out(token)
    for call in calls(accounts, bert):
        with pytest.raises(NotAllowedError):
            call()


BAD: dict[str, tuple[Callable[[Accounts], object], str]] = {
    "no such account": (lambda a: a.deactivate(None, "ana", "left"), "did you mean 'anna'"),
    "no such role": (lambda a: a.add(None, "dora", "clinican"), "did you mean 'clinician'"),
    "a name with spaces": (lambda a: a.add(None, "dora d", "clinician"), "the name 'dora d' is"),
    "a name in use": (lambda a: a.add(None, "anna", "clinician"), "there is an account 'anna'"),
    "no reason": (lambda a: a.deactivate(None, "anna", " "), "say why"),
    "half a letter": (lambda a: a.deactivate(None, "anna", "\ud800"), "characters that no text"),
    "a line break": (lambda a: a.deactivate(None, "anna", "left\nadmin: all"), "invisible char"),
    "a bell": (lambda a: a.change_role(None, "anna", "engineer", True, "x\x07"), "invisible char"),
    "turned round": (lambda a: a.deactivate(None, "anna", "left \u202edraw"), "invisible char"),
    "spaces around": (lambda a: a.deactivate(None, "anna", " left"), "has spaces around it"),
    "a long reason": (
        lambda a: a.change_role(None, "anna", "engineer", False, "x" * 4000),
        "characters; 0 to 4000",
    ),
    "a name that is none": (lambda a: a.reset_password(None, "\ud800" * 90), "unknown account"),
}


@seldom_on_both
@pytest.mark.parametrize("kind", BAD)
def test_what_cannot_be_is_one_line_and_changes_nothing(
    accounts: Accounts, records: Records, kind: str
) -> None:
    employ(accounts, begin(accounts), "anna")
    before = records.head()
    call, words = BAD[kind]
    with pytest.raises(InputError, match=words) as refused:
        call(accounts)
    assert len(str(refused.value).splitlines()) == 1
    assert records.head() == before
