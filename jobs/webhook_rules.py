"""Where the ends of jobs may be announced: to hosts that the operator names, by HTTPS, at public addresses."""

from __future__ import annotations

import base64
import binascii
import os
import socket
from collections.abc import Mapping
from dataclasses import dataclass, field
from ipaddress import ip_address
from typing import Self
from urllib.parse import SplitResult, urlsplit

from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import is_storable

__all__ = ["WebhookRules"]

_LONGEST = 2000  # characters of a URL
_SHORTEST_SECRET = 24  # bytes


@dataclass(frozen=True)
class WebhookRules:
    """The operator's settings; without hosts there are no webhooks."""

    hosts: frozenset[str] = frozenset()  # in lower case; a name with a leading dot stands for all below it
    secret: bytes = field(default=b"", repr=False)
    private: bool = False  # hosts at private addresses are allowed, and plain HTTP

    @classmethod
    def configured(cls, environment: Mapping[str, str] = os.environ) -> Self:
        """Read `HGS_WEBHOOK_HOSTS`, `HGS_WEBHOOK_SECRET` and `HGS_WEBHOOK_PRIVATE`.

        Raises:
            InputError: there are hosts and no secret, or one that is too short.
        """
        hosts = frozenset(environment.get("HGS_WEBHOOK_HOSTS", "").lower().replace(",", " ").split())
        secret = _secret(environment.get("HGS_WEBHOOK_SECRET", ""))
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
            raise InputError("webhook", f"{url[:200]!a} is no URL ({error})") from error
        host = (parts.hostname or "").lower()
        plain = is_storable(url) and url.isascii() and url.isprintable() and " " not in url
        if len(url) > _LONGEST or not plain or not host or port == 0 or parts.username is not None or parts.fragment:
            cure = f"give one of at most {_LONGEST} characters as https://HOST/PATH, without a user and a fragment"
            raise InputError("webhook", f"{url[:200]!a} is no URL for webhooks", cure)
        if parts.scheme not in (("https", "http") if self.private else ("https",)):
            raise InputError("webhook", f"{parts.scheme}:// is not allowed", "use https://")
        if not any(host == one or (one.startswith(".") and host.endswith(one)) for one in self.hosts):
            cure = "the operator allows hosts by HGS_WEBHOOK_HOSTS"
            raise InputError("webhook", f"{host[:200]} is not a host that may be told", cure)
        return parts

    def addresses(self, parts: SplitResult) -> list[str]:
        """Return the addresses of the host, as it is now.

        Raises:
            OSError: the name cannot be looked up, or one of the addresses is not allowed.
        """
        port = parts.port or (443 if parts.scheme == "https" else 80)
        found = socket.getaddrinfo(parts.hostname, port, type=socket.SOCK_STREAM)
        addresses = list(dict.fromkeys(str(entry[4][0]) for entry in found))
        for address in addresses:
            if not self.private and not _is_public(address):
                raise PermissionError(f"{parts.hostname} is at {address}, which is not a public address")
        return addresses


def _is_public(address: str) -> bool:
    number = ip_address(address.partition("%")[0])
    inner = getattr(number, "ipv4_mapped", None) or getattr(number, "sixtofour", None) or number
    return number.is_global and inner.is_global and not number.is_multicast


def _secret(text: str) -> bytes:
    """Return the bytes of a secret; those of `whsec_…` are in base 64, as the Standard Webhooks have it."""
    if not text.startswith("whsec_"):
        return text.encode()
    try:
        return base64.b64decode(text.removeprefix("whsec_"), validate=True)
    except binascii.Error as error:
        raise InputError("HGS_WEBHOOK_SECRET", f"whsec_ is not followed by base 64 ({error})") from error
