"""Where the ends of jobs may be announced: to hosts that the operator names, by HTTPS, at public addresses."""

from __future__ import annotations

import base64
import binascii
import os
import re
import socket
from collections.abc import Mapping
from dataclasses import dataclass, field
from ipaddress import ip_address
from typing import Self
from urllib.parse import SplitResult, urlsplit

from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import is_storable
from jobs.webhooks.public_addresses import is_public

__all__ = ["WebhookRules"]

_LONGEST = 2000  # characters of a URL
_SHORTEST_SECRET = 24  # bytes
_DEFAULT_PORTS = {"https": 443, "http": 80}
_LONGEST_NAME = 253  # characters of a host's name, as DNS has it
_LABEL = "[a-z0-9_](?:[a-z0-9_-]{0,61}[a-z0-9_])?"
_NAME = re.compile(rf"{_LABEL}(?:\.{_LABEL})*")


@dataclass(frozen=True)
class WebhookRules:
    """The operator's settings; without hosts there are no webhooks."""

    hosts: frozenset[str] = frozenset()  # lower case, perhaps with a port; a leading dot stands for all subdomains
    secret: bytes = field(default=b"", repr=False)
    private: bool = False  # hosts at private addresses are allowed, and plain HTTP

    @classmethod
    def configured(cls, environment: Mapping[str, str] = os.environ) -> Self:
        """Read `HGS_WEBHOOK_HOSTS`, `HGS_WEBHOOK_SECRET` and `HGS_WEBHOOK_PRIVATE`.

        Raises:
            InputError: a host is neither a name nor an address; or there are hosts and no secret, or a short one.
        """
        hosts = frozenset(environment.get("HGS_WEBHOOK_HOSTS", "").lower().replace(",", " ").split())
        secret = _secret(environment.get("HGS_WEBHOOK_SECRET", ""))
        for host in hosts:
            _host_and_port(host)
        if hosts and len(secret) < _SHORTEST_SECRET:
            cure = f"give {_SHORTEST_SECRET} bytes or more, as from: openssl rand -base64 32"
            raise InputError("HGS_WEBHOOK_SECRET", f"has {len(secret)} bytes", cure)
        return cls(hosts, secret, environment.get("HGS_WEBHOOK_PRIVATE", "") == "1")

    def checked(self, url: str) -> SplitResult:
        """Return the parts of a URL that a job may announce its end to.

        Raises:
            InputError: the URL is malformed, or its scheme or host is not allowed.
        """
        try:
            parts = urlsplit(url)
            port = parts.port
        except ValueError as error:
            raise InputError.of_field("webhook", f"{url[:200]!a} is no URL ({error})") from error
        host = (parts.hostname or "").lower()
        plain = is_storable(url) and url.isascii() and url.isprintable() and " " not in url
        if len(url) > _LONGEST or not plain or not host or port == 0 or parts.username is not None or parts.fragment:
            cure = f"give one of at most {_LONGEST} characters as https://HOST/PATH, without a user and a fragment"
            raise InputError.of_field("webhook", f"{url[:200]!a} is no URL for webhooks", cure)
        if parts.scheme not in (("https", "http") if self.private else ("https",)):
            raise InputError.of_field("webhook", f"{parts.scheme}:// is not allowed", "use https://")
        if not _is_host(host):
            cure = "its host is a name with labels of 1 to 63 letters, digits and hyphens, or an address"
            raise InputError.of_field("webhook", f"{host[:300]!a} is no host", cure)
        if not any(_fits(host, port or _DEFAULT_PORTS[parts.scheme], one) for one in self.hosts):
            cure = "the operator allows hosts by HGS_WEBHOOK_HOSTS"
            raise InputError.of_field("webhook", f"{parts.netloc[:200]} is not a host that may be told", cure)
        return parts

    def addresses(self, parts: SplitResult) -> list[str]:
        """Return the addresses of the host, as it is now.

        Raises:
            OSError: the name cannot be looked up, or one of the addresses is not allowed.
            UnicodeError: the name is none.
        """
        port = parts.port or _DEFAULT_PORTS[parts.scheme]
        found = socket.getaddrinfo(parts.hostname, port, type=socket.SOCK_STREAM)
        addresses = list(dict.fromkeys(str(entry[4][0]) for entry in found))
        for address in addresses:
            if not self.private and not is_public(address):
                raise PermissionError(f"{parts.hostname} is at {address}, which is not a public address")
        return addresses


def _fits(host: str, port: int, allowed: str) -> bool:
    """Return whether a host and a port are those of a setting; one without a port stands for all of them."""
    name, only = _host_and_port(allowed)
    return (host == name or (name.startswith(".") and host.endswith(name))) and only in (None, port)


def _is_host(host: str) -> bool:
    """Return whether it is an address, or a name that can be looked up."""
    try:
        return "%" not in host and bool(ip_address(host))
    except ValueError:
        return len(host) <= _LONGEST_NAME and _NAME.fullmatch(host) is not None


def _host_and_port(text: str) -> tuple[str, int | None]:
    """Return the host of a setting, with its leading dot, and the port behind it, if any.

    Raises:
        InputError: it is neither a name nor an address.
    """
    try:
        parts = urlsplit(f"//{text}") if text.count(":") < 2 or text.startswith("[") else None  # ::1 is an address
        host, port = (parts.hostname or "", parts.port) if parts else (text, None)
    except ValueError:
        host, port = "", None
    if not _is_host(host.removeprefix(".")) or port == 0 or (parts and (parts.path or parts.username is not None)):
        cure = "give names, separated by commas, as in hooks.example.org,.corp.example or hooks.example.org:8443"
        raise InputError("HGS_WEBHOOK_HOSTS", f"{text[:200]!a} is no host", cure)
    return host, port


def _secret(text: str) -> bytes:
    """Return the bytes of a secret; those of `whsec_…` are in base 64, as the Standard Webhooks have it."""
    if not text.startswith("whsec_"):
        return text.encode()
    try:
        return base64.b64decode(text.removeprefix("whsec_"), validate=True)
    except binascii.Error as error:
        raise InputError("HGS_WEBHOOK_SECRET", f"whsec_ is not followed by base 64 ({error})") from error
