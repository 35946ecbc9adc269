"""The client of a request, as limits count clients."""

from __future__ import annotations

import contextlib
from ipaddress import ip_network

from starlette.requests import HTTPConnection

from server.access.visitors import Visitor

__all__ = ["client_of"]


def client_of(connection: HTTPConnection) -> str:
    """Return the client: its key, or else its address, or for IPv6 its /64 network, as one client has all of it."""
    visitor: Visitor | None = getattr(connection.state, "visitor", None)
    if visitor is not None and visitor.key is not None:
        return f"key {visitor.key.id}"
    address = connection.client.host if connection.client else ""
    with contextlib.suppress(ValueError):
        return f"address {ip_network((address, 64 if ':' in address else 32), strict=False)}"
    return f"address {address}"
