"""Why something is refused: each one plain line, with nothing in it that helps somebody guess."""

import math

from opensuction.kernel.errors import InputError

WRONG = "name or password is wrong"
"""Whichever it is, and where the account was deactivated or the password's time is over."""


class RefusedError(InputError):
    """A person may not do this, or not now."""


class WrongPasswordError(RefusedError):
    """Signing in failed."""

    def __init__(self) -> None:
        super().__init__(WRONG)


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
