"""Secrets of sessions, programs and known browsers. Only their hashes are stored.

Somebody who reads the database therefore cannot sign in with it.
"""

import hashlib
import hmac
import secrets

BYTES = 32
ONE_TIME_LETTERS = "abcdefghjkmnpqrstuvwxyz23456789"
"""None is taken for another when it is copied by hand."""
GROUPS, GROUP = 4, 5
"""Of a one-time password: 20 of 31 letters are 99 bits."""
LONGEST = 256
"""Characters that are looked at."""


def make() -> str:
    """A secret of 256 bits, in letters that a header may carry."""
    return secrets.token_urlsafe(BYTES)


def make_one_time_password() -> str:
    """A password to be copied by hand."""
    groups = (
        "".join(secrets.choice(ONE_TIME_LETTERS) for _ in range(GROUP)) for _ in range(GROUPS)
    )
    return "-".join(groups)


def digest(*parts: str) -> str:
    """SHA-256 of a secret, kept in its place. 256 random bits need no salt and no slow hash."""
    whole = hashlib.sha256()
    for part in parts:
        content = _to_bytes(part)
        whole.update(len(content).to_bytes(4) + content)
    return whole.hexdigest()


def csrf_token(session_token: str) -> str:
    """Token that a page sends with each change: it takes the session's secret to make it."""
    return hmac.new(_to_bytes(session_token), b"opensuction csrf", hashlib.sha256).hexdigest()


def is_csrf_token(session_token: str, shown: str) -> bool:
    """True for the CSRF token that `csrf_token` makes of a session's secret."""
    return hmac.compare_digest(_to_bytes(csrf_token(session_token)), _to_bytes(shown))


def _to_bytes(text: str) -> bytes:
    return text[:LONGEST].encode("utf-8", "surrogatepass")
