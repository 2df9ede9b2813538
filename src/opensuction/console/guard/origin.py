"""Check that a request comes from the console's own page, by headers that browsers add themselves.

A page of another origin can make a browser send requests, cookies included; it cannot make it
misstate their origin. Source: [OWASP-CSRF], [Fetch-Metadata].
"""

from collections.abc import Mapping
from ipaddress import ip_address

SAFE = frozenset({"GET", "HEAD", "OPTIONS"})
NAMES_HERE = ("127.0.0.1", "localhost", "[::1]")
USUAL_PORTS = {"http": 80, "https": 443}
SAME = frozenset({"same-origin", "none"})


def is_loopback(host: str) -> bool:
    """True for an address of this computer alone.

    >>> is_loopback("127.0.0.1"), is_loopback("localhost"), is_loopback("0.0.0.0")
    (True, True, False)
    """
    if host == "localhost":
        return True
    try:
        return ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def hosts_of(host: str, port: int, has_tls: bool) -> frozenset[str] | None:
    """Values that the Host header may have; None: any.

    Without this a page of any name that is made to mean this computer is of the same origin (DNS
    rebinding). To be reached from elsewhere takes a certificate, which such a name does not have:
    there the browser refuses it.
    """
    if not is_loopback(host):
        return None
    scheme = "https" if has_tls else "http"
    names = {*NAMES_HERE, f"[{host}]" if ":" in host else host}
    found = {f"{name}:{port}" for name in names}
    return frozenset(found | names if USUAL_PORTS[scheme] == port else found)


def refuse_host(hosts: frozenset[str] | None, said: str | None) -> str:
    """Reason to refuse a Host header; empty where it is allowed."""
    if said is None:
        return "the request does not say which host it means"
    if hosts is not None and said.lower() not in hosts:
        return "the request means another host than this one"
    return ""


def refuse_origin(headers: Mapping[str, str], scheme: str, needs_origin: bool) -> str:
    """Reason to refuse a request for its origin; empty where it is allowed.

    needs_origin: it changes something, or opens a socket.
    """
    site = headers.get("sec-fetch-site")
    if site is not None and site not in SAME:
        return "the request comes from a page of another origin"
    origin = headers.get("origin")
    if origin is None:
        return "the request does not say from where it comes" if needs_origin else ""
    if origin.lower() != f"{scheme}://{headers.get('host', '')}".lower():
        return "the request comes from a page of another origin"
    return ""
