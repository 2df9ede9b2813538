"""Refusals of the accounts: one plain line each, with nothing in it that helps somebody guess."""

import math

from opensuction.kernel.errors import InputError

WRONG = "name or password is wrong"
"""Whichever it is, and where the account was deactivated."""
OVER = (
    "this one-time password is over, for it signs in once, within 24 hours: an administrator makes "
    "another one, on the page or by 'opensuction users reset-password NAME'"
)
"""Said only to who knows it."""


class RefusedError(InputError):
    """A person may not do this, or not now."""


class WrongPasswordError(RefusedError):
    """Signing in failed."""

    def __init__(self, why: str = WRONG) -> None:
        super().__init__(why)


class PasswordOverError(WrongPasswordError):
    """The one-time password is the right one, and has signed in already, or its time is over."""

    def __init__(self) -> None:
        super().__init__(OVER)


class WaitError(RefusedError):
    """Too many sign-ins failed; nothing was looked at."""

    def __init__(self, wait_s: float) -> None:
        self.wait_s = math.ceil(wait_s)
        super().__init__(
            f"too many sign-ins failed: try again in {self.wait_s} s; nobody needs to sign in to "
            "stop the machine"
        )


class BusyError(RefusedError):
    """Too many passwords are being looked at, or there is no memory for it."""


class NotSignedInError(RefusedError):
    """The session is unknown or has ended, or the token is."""


class NotAllowedError(RefusedError):
    """Signed in, but without the right."""
