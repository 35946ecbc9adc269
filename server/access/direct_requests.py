"""Detection of direct requests from this machine: a server without keys is open to these alone.

A proxy on the same machine connects from a loopback address, too, and brings anybody's requests. What it says of itself
in headers, and how it speaks, gives most proxies away; docs/access.md tells of those that nothing does.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from ipaddress import IPv6Address, ip_address

from starlette.requests import HTTPConnection

__all__ = ["sign_of_proxy"]

# Set by proxies, balancers, CDNs and tunnels, and by nothing that asks directly.
_SET_BY_PROXIES = re.compile(
    r"via|(x-)?forwarded(-.*)?|front-end-https|x-(host|request-start|scheme|varnish)|"
    r"x-(amzn?|appengine|arr|azure|client|cluster|coming|edge|envoy|nginx|original|proxy|proxyuser|real|remote|rewrite|"
    r"true)-.*|"
    r"(akamai|cdn|cf|client|fastly|fly|incap|ngrok|proxy|remote|ssl|tailscale|true-client|wl-proxy)-.*"
)
_HOST = re.compile(r"(?:\[([^\]]*)\]|([^:]*))(?::[0-9]{1,5})?")


def sign_of_proxy(connection: HTTPConnection) -> str | None:
    """Return a sign that a request may come from elsewhere, such as "the header Via"; None if it is this machine's."""
    headers = connection.headers
    if connection.client is None or not _is_loopback(connection.client.host):
        return "an address that is not this machine's"
    named = next((name for name in headers if _SET_BY_PROXIES.fullmatch(name)), None)
    if named is not None:
        return f"the header {named.title()}"
    host = headers.get("Host", "")
    if not _is_here(host):
        return f"the Host {host!r:.100}" if host else "no Host"
    if connection.scope.get("http_version", "1.1") == "1.0":  # the default of nginx
        return "HTTP/1.0"
    options = {option.strip().lower() for option in headers.get("Connection", "").split(",")}
    if "close" in options:  # nginx's default: it keeps no connection
        return "Connection: close"
    if "upgrade" in options and "Upgrade" not in headers:  # the usual nginx setting for WebSockets
        return "Connection: upgrade"
    # Some proxies forward a Host of their own; the page's address reveals them.
    if headers.get("Sec-Fetch-Site") == "same-origin" and not all(map(_is_here, _pages(headers))):
        return "a page that has another address"
    return None


def _pages(headers: Mapping[str, str]) -> list[str]:
    """Return the hosts of the requesting page."""
    return [headers[name].split("/")[2] for name in ("Origin", "Referer") if headers.get(name, "").count("/") >= 2]


def _is_here(host: str) -> bool:
    """Return whether a Host header, with or without a port, names this machine by a loopback name or address."""
    match = _HOST.fullmatch(host)
    name = (match[1] or match[2] or "").lower().removesuffix(".") if match else ""
    return name == "localhost" or name.endswith(".localhost") or _is_loopback(name)


def _is_loopback(address: str) -> bool:
    try:
        number = ip_address(address.partition("%")[0])
    except ValueError:
        return False
    inner = number.ipv4_mapped if isinstance(number, IPv6Address) else None
    return (inner or number).is_loopback
