"""Tokens for other programs: what they may read, and for how long."""

from datetime import timedelta

import pytest

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import require
from opensuction.accounts.site import NotAllowedError, NotSignedInError
from opensuction.kernel.errors import InputError
from opensuction.records.records import Records
from tests.accounts.example import Clock, begin, employ
from tests.records.conftest import seldom_on_both

WEEK = timedelta(days=7)


def test_a_token_reads_what_it_was_given_for_until_it_is_over(
    accounts: Accounts, clock: Clock
) -> None:
    made = accounts.issue_token(begin(accounts), "ward display", ["see-bedside"], WEEK)
    assert made.token.startswith("opensuction_")
    found = accounts.find_token(made.token)
    assert found == made.access
    assert (found.label, found.rights) == ("ward display", frozenset({Right.SEE_BEDSIDE}))
    assert accounts.list_tokens() == [found]
    clock.go_on(days=7, seconds=-1)
    accounts.find_token(made.token)
    clock.go_on(seconds=1)
    with pytest.raises(NotSignedInError, match="unknown, revoked or over"):
        accounts.find_token(made.token)
    assert accounts.list_tokens() == []


def test_a_program_may_read_what_it_was_given_for_and_stop_like_anybody(
    accounts: Accounts,
) -> None:
    access = accounts.issue_token(begin(accounts), "display", ["see-history"], WEEK).access
    require(access, Right.SEE_HISTORY)
    require(access, Right.STOP)
    for wanted in (Right.SEE_SIGNALS, Right.START, Right.CHANGE_OWN_PASSWORD):
        with pytest.raises(NotAllowedError, match="the token 'display' may not"):
            require(access, wanted)


def test_a_clock_that_was_wrong_for_a_moment_ends_no_token(
    accounts: Accounts, clock: Clock
) -> None:
    admin = begin(accounts)
    made = accounts.issue_token(admin, "ward display", ["see-bedside"], WEEK)
    clock.go_on(days=4000)
    made_late = accounts.reset_password(None, "admin")
    accounts.sign_in("admin", made_late.one_time_password, "10.0.0.1")
    clock.go_on(days=-4000)
    assert accounts.find_token(made.token) == made.access


def test_a_token_is_revoked(accounts: Accounts) -> None:
    admin = begin(accounts)
    first, second = (
        accounts.issue_token(admin, label, ["see-history", "see-audit"], WEEK)
        for label in ("billing", "archive")
    )
    assert [one.label for one in accounts.list_tokens()] == ["archive", "billing"]
    accounts.revoke_token(admin, first.access.id)
    with pytest.raises(NotSignedInError):
        accounts.find_token(first.token)
    accounts.find_token(second.token)
    with pytest.raises(InputError, match=r"no token '.+' holds"):
        accounts.revoke_token(admin, first.access.id)
    with pytest.raises(InputError, match="characters that no text has"):
        accounts.revoke_token(admin, "\ud800")


@seldom_on_both
@pytest.mark.parametrize("scope", [str(right) for right in Right if not right.startswith("see-")])
def test_no_token_changes_anything(accounts: Accounts, scope: str) -> None:
    with pytest.raises(InputError, match=f"unknown scope '{scope}'"):
        accounts.issue_token(None, "ward display", ["see-bedside", scope], WEEK)
    assert accounts.list_tokens() == []


@seldom_on_both
@pytest.mark.parametrize(
    ("label", "scope", "life", "words"),
    [
        ("", ["see-bedside"], WEEK, "the label has 0 characters"),
        ("display", [], WEEK, "say what it may read: see-audit, see-bedside"),
        ("display", ["see-histry"], WEEK, "did you mean 'see-history'"),
        ("display", ["see-bedside"], timedelta(days=367), "366 days at most"),
        ("display", ["see-bedside"], timedelta(0), "a minute at least"),
    ],
)
def test_a_token_that_cannot_be_is_one_line(
    accounts: Accounts,
    records: Records,
    label: str,
    scope: list[str],
    life: timedelta,
    words: str,
) -> None:
    before = records.head()
    with pytest.raises(InputError, match=words) as refused:
        accounts.issue_token(None, label, scope, life)
    assert len(str(refused.value).splitlines()) == 1
    assert records.head() == before


def test_only_an_administrator_manages_tokens(accounts: Accounts) -> None:
    admin = begin(accounts)
    made = accounts.issue_token(admin, "ward display", ["see-bedside"], WEEK)
    bert = accounts.find_session(employ(accounts, admin, "bert").session_token)
    with pytest.raises(NotAllowedError, match="bert may not: Manage tokens"):
        accounts.issue_token(bert, "another", ["see-bedside"], WEEK)
    with pytest.raises(NotAllowedError, match="bert may not: Manage tokens"):
        accounts.revoke_token(bert, made.access.id)
    accounts.find_token(made.token)
