"""People, and a clock that stands until it is told."""

from datetime import datetime, timedelta

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.session import Session
from opensuction.accounts.sign_in import SignedIn
from opensuction.accounts.site import Cost, PasswordHasher
from tests.records.example import NOON

CHEAP = PasswordHasher(Cost(passes=1, memory_kib=8, lanes=1))
HERE = "127.0.0.1"
THERE = "203.0.113.9"
PASSWORDS = {
    "admin": "purple kettle orbits 7 lamps",
    "anna": "velvet tractor hums quietly",
    "bert": "nine walnuts under ice",
    "cora": "glacier postman likes rye",
}
ROLES = {"anna": "clinician", "bert": "engineer", "cora": "observer"}


class Clock:
    """A clock that stands until it is told."""

    def __init__(self) -> None:
        self.at = NOON

    def __call__(self) -> datetime:
        return self.at

    def go_on(self, **by: float) -> None:
        self.at += timedelta(**by)


def enter(accounts: Accounts, name: str, one_time_password: str) -> SignedIn:
    """Sign in for the first time, with a password of one's own from then on."""
    signed_in = accounts.sign_in(name, one_time_password, HERE)
    accounts.change_password(signed_in.session_token, one_time_password, PASSWORDS[name])
    return signed_in


def begin(accounts: Accounts) -> Session:
    """The administrator of a new site, signed in."""
    made = accounts.first_start()
    assert made is not None
    return accounts.find_session(enter(accounts, "admin", made.one_time_password).session_token)


def employ(accounts: Accounts, admin: Session, name: str) -> SignedIn:
    """Somebody of that role, signed in."""
    return enter(accounts, name, accounts.add(admin, name, ROLES[name]).one_time_password)
