"""Access rights of each role, in one table."""

import json

import pytest

from opensuction.accounts.rule import right
from opensuction.accounts.rule.right import RIGHTS, Right, Role, rights_of
from opensuction.records.database.schema import ROLES


def test_every_right_is_in_the_table() -> None:
    assert RIGHTS.keys() == set(Right)
    assert tuple(Role) == ROLES
    assert len({one.sentence for one in RIGHTS.values()}) == len(RIGHTS)


def test_everybody_may_stop_and_see_where_the_catheter_is() -> None:
    for role in Role:
        assert {Right.STOP, Right.SEE_BEDSIDE} <= rights_of(role, False)
    assert {Right.STOP, Right.SEE_BEDSIDE, Right.SIGN_IN} == right.ANYBODY


@pytest.mark.parametrize("is_administrator", [True, False])
def test_only_a_clinician_starts(is_administrator: bool) -> None:
    may = {role for role in Role if Right.START in rights_of(role, is_administrator)}
    assert may == {Role.CLINICIAN}


@pytest.mark.parametrize("changing", [Right.CHANGE_LIMITS, Right.CALIBRATE])
def test_only_an_engineer_changes_limits_or_calibration_and_says_why(changing: Right) -> None:
    for is_administrator in (True, False):
        may = {role for role in Role if changing in rights_of(role, is_administrator)}
        assert may == {Role.ENGINEER}
    assert RIGHTS[changing].needs_reason


def test_only_an_administrator_manages_accounts() -> None:
    managing = {Right.MANAGE_ACCOUNTS, Right.MANAGE_TOKENS}
    for role in Role:
        assert not managing & rights_of(role, False)
        assert managing <= rights_of(role, True)


def test_an_observer_changes_nothing_on_the_machine() -> None:
    harmless = right.READ_ONLY | right.ANYBODY | {Right.CHANGE_OWN_PASSWORD}
    assert rights_of(Role.OBSERVER, False) <= harmless


def test_a_program_may_have_the_history() -> None:
    assert Right.SEE_HISTORY in right.READ_ONLY


def test_who_must_change_the_password_may_do_nothing_else_but_stop() -> None:
    assert {Right.CHANGE_OWN_PASSWORD} == right.MUST_CHANGE - right.ANYBODY


def test_a_page_gets_the_same_table() -> None:
    listed = {one["right"]: one for one in json.loads(json.dumps(right.list_plain()))}
    assert list(listed) == [str(one) for one in RIGHTS]
    for role in Role:
        for is_administrator in (True, False):
            may = {
                name
                for name, one in listed.items()
                if one["by_anybody"]
                or role in one["roles"]
                or (is_administrator and one["by_administrator"])
            }
            assert may == rights_of(role, is_administrator)
    assert listed["calibrate"]["needs_reason"] is True
