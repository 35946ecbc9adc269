"""Addresses of the public internet: any other address of a name lies inside somebody's network.

The registries of special addresses are IANA's (RFC 6890 and its updates). Python's `is_global` follows them, each
version as they were then, and knows nothing of the IPv4 addresses inside of IPv6 ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from ipaddress import IPv4Address, IPv4Network, IPv6Address, IPv6Network, ip_address

__all__ = ["is_public"]

_RELAYS = IPv4Network("192.88.99.0/24")  # 6to4 relays, gone since RFC 7526
_PROTOCOLS = IPv4Network("192.0.0.0/24")  # IETF protocol assignments
_UNICAST = IPv6Network("2000::/3")  # all that is given to networks of the internet
_SPECIAL = (IPv6Network("2001::/23"), IPv6Network("2001:db8::/32"), IPv6Network("3fff::/20"))
_MAPPED = IPv6Network("::ffff:0:0/96")
_TRANSLATED = IPv6Network("64:ff9b::/96")  # NAT64, RFC 6052: how a host without IPv4 reaches those that have only that
_SIX_TO_FOUR = IPv6Network("2002::/16")  # RFC 3056
_ISATAP = (0x0000_5EFE, 0x0200_5EFE)  # above the IPv4 address in an interface's identifier, RFC 5214


def is_public(address: str) -> bool:
    """Return whether an address, and every IPv4 address that it leads to, is of the public internet."""
    number = ip_address(address.partition("%")[0])
    if isinstance(number, IPv4Address):
        return _is_public_v4(number)
    outside = number in _UNICAST and number.is_global and not any(number in special for special in _SPECIAL)
    return (outside or number in _MAPPED or number in _TRANSLATED) and all(map(_is_public_v4, _inside(number)))


def _is_public_v4(number: IPv4Address) -> bool:
    special = number.is_multicast or number.is_reserved or number in _RELAYS or number in _PROTOCOLS
    return number.is_global and not special


def _inside(number: IPv6Address) -> Iterator[IPv4Address]:
    """Yield the IPv4 addresses that translators and tunnels derive from this one."""
    bits = int(number)
    if number in _SIX_TO_FOUR:
        yield IPv4Address(bits >> 80 & 0xFFFF_FFFF)
    if number in _MAPPED or number in _TRANSLATED or bits >> 32 & 0xFFFF_FFFF in _ISATAP:
        yield IPv4Address(bits & 0xFFFF_FFFF)
