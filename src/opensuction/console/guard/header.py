"""Headers of every answer: what a browser may do with it. Source: [OWASP-Headers]."""

from collections.abc import Iterable

CSP = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "connect-src 'self'",
        "img-src 'self' data:",
        "font-src 'self'",
        "media-src 'self'",
        "worker-src 'self'",
        "frame-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
"""Only what lies here, nothing inline. A route whose page needs another one says so itself."""
SECURITY = {
    "content-security-policy": CSP,
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-embedder-policy": "require-corp",
    "permissions-policy": "camera=(), microphone=(), geolocation=(), payment=(), usb=()",
    "x-permitted-cross-domain-policies": "none",
}
TLS = {"strict-transport-security": "max-age=31536000"}
NO_STORE, NO_CACHE = "no-store", "no-cache"

Raw = list[tuple[bytes, bytes]]


def complete(given: Iterable[tuple[bytes, bytes]], is_interface: bool, has_tls: bool) -> Raw:
    """The headers of an answer with those that are missing; what a route has set stays.

    is_interface: what it says holds now and for this person, and is kept nowhere.
    """
    found = list(given)
    names = {name.lower() for name, _ in found}
    wanted = {**SECURITY, "cache-control": NO_STORE if is_interface else NO_CACHE}
    if has_tls:
        wanted |= TLS
    for name, value in wanted.items():
        if name.encode() not in names:
            found.append((name.encode(), value.encode()))
    return found
