"""Allowed host names: protection against DNS rebinding, where a foreign page resolves its own name to this server."""

from __future__ import annotations

import os
import re
import socket
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from ipaddress import ip_address
from typing import Self

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Receive, Scope, Send

from hgs_core.base.errors import InputError
from server.http.problems import ProblemError, problem_response

__all__ = ["AllowedHosts", "HostCheck"]

SETTING = "HGS_ALLOW_HOSTS"
EVERYWHERE = ("0.0.0.0", "::")

_NAME = r"[a-z0-9_-]{1,63}(?:\.[a-z0-9_-]{1,63})*"
_HOST = re.compile(rf"(?:({_NAME})\.?|\[([0-9a-f:.]+)\])(?::[0-9]{{1,5}})?", re.IGNORECASE)


@dataclass(frozen=True)
class AllowedHosts:
    """Host names in lower case. IP addresses are always allowed, since no foreign name can resolve through them."""

    names: frozenset[str] = frozenset({"localhost"})

    @classmethod
    def configured(
        cls, bound: str = "localhost", given: Iterable[str] = (), environment: Mapping[str, str] = os.environ
    ) -> Self:
        """Return localhost, the bound name, the `given` names and those of `HGS_ALLOW_HOSTS`.

        A server bound to all addresses answers to the machine's own name too.

        Raises:
            InputError: a name is none, such as one with a port.
        """
        names = {"localhost", bound.lower(), *map(_checked, given)}
        if bound in EVERYWHERE:
            names.add(socket.gethostname().lower())
        names.update(_checked(name) for name in environment.get(SETTING, "").replace(",", " ").split())
        return cls(frozenset(names))

    def allows(self, host: str | None) -> bool:
        """Return whether this Host header names this server; requests without one do not come from a page."""
        if host is None:
            return True
        match = _HOST.fullmatch(host)
        if match is None:
            return False
        name = (match[1] or match[2]).lower()
        return name in self.names or _is_address(name)


def _checked(name: str) -> str:
    try:
        ascii_name = name.lower().encode("idna").decode()  # the form browsers send
    except UnicodeError:
        ascii_name = ""
    if not re.fullmatch(_NAME, ascii_name):
        cure = "give names without scheme and port, such as hgs.example.org"
        raise InputError(f"--allow-host or {SETTING}", f"{name!r} is not a host name", cure)
    return ascii_name


def _is_address(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True


class HostCheck:
    """ASGI middleware that rejects requests and WebSockets for other hosts before anything else."""

    def __init__(self, app: ASGIApp, hosts: AllowedHosts) -> None:
        self._app = app
        self._hosts = hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer 421, or pass the request on."""
        if scope["type"] in ("http", "websocket"):
            connection = HTTPConnection(scope)
            host = connection.headers.get("Host")
            if not self._hosts.allows(host):
                detail = (
                    f"Host {host!r:.100} is not a name of this server; if it is, start the server with "
                    f"--allow-host NAME, or with {SETTING}=NAME in its environment"
                )
                response = problem_response(connection, ProblemError(421, "host-not-allowed", detail))
                await response(scope, receive, send)
                return
        await self._app(scope, receive, send)
