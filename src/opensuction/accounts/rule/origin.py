"""Network address of a request, in the form that is counted and put on record."""

import ipaddress

from opensuction.settings.wording import one_line

LONGEST = 45
"""Characters of an address."""
NETWORK_V6 = 64
"""Bits of an IPv6 address that one customer has at least: the rest is his to choose."""


def normalise(origin: str) -> str:
    """An address as it is counted: of IPv6 its network; of anything else what it says.

    >>> normalise("::ffff:10.0.0.7"), normalise("2001:db8::1:2"), normalise("command line")
    ('10.0.0.7', '2001:db8::/64', 'command line')
    """
    try:
        address = ipaddress.ip_address(origin.partition("%")[0])
    except ValueError:
        return one_line(origin)[:LONGEST] or "nowhere"
    if isinstance(address, ipaddress.IPv4Address):
        return str(address)
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    if address.is_loopback:
        return str(address)
    return str(ipaddress.ip_network((address, NETWORK_V6), strict=False))
