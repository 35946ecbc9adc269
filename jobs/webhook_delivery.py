"""Tells the ends of jobs to the URLs that asked for it, signed as the Standard Webhooks have it."""

from __future__ import annotations

import base64
import hashlib
import hmac
import http.client
import logging
import socket
import ssl
import threading
import time
from urllib.parse import SplitResult

from hgs_core.base.errors import InputError
from jobs.transient_faults import one_line
from jobs.webhook_rules import WebhookRules
from jobs.webhook_table import Announcement, WebhookTable

__all__ = ["WebhookDelivery", "signature"]

TIMEOUT = 10.0  # seconds for each of: the connection, the answer
POLL = 2.0  # seconds between two looks for what is due
GONE = 410

log = logging.getLogger(__name__)


class WebhookDelivery:
    """Sends what is due; any number of processes may do so at once."""

    def __init__(self, table: WebhookTable, rules: WebhookRules) -> None:
        self._table = table
        self._rules = rules

    def start(self) -> None:
        """Send from a thread of its own, as long as the process lives."""
        threading.Thread(target=self._run, daemon=True, name="webhooks").start()

    def deliver_due(self) -> int:
        """Try everything that is due once; return how many arrived."""
        arrived = 0
        while (one := self._table.take()) is not None:
            try:
                status = self._send(one)
            except InputError as error:  # no longer allowed
                self._table.failed(one, one_line(error))
            except (OSError, http.client.HTTPException) as error:
                self._table.failed(one, one_line(str(error) or type(error).__name__))
            else:
                if 200 <= status < 300:
                    self._table.delivered(one)
                    arrived += 1
                else:
                    self._table.failed(one, f"the receiver answered {status}", for_good=status == GONE)
        return arrived

    def _run(self) -> None:
        while True:
            try:
                self.deliver_due()
            except Exception as error:
                log.warning("webhooks will be looked after again in %g s: %s", POLL, one_line(error))
            time.sleep(POLL)

    def _send(self, one: Announcement) -> int:
        parts = self._rules.checked(one.url)
        body = one.body.encode()
        message, now = f"{one.job_id}.{one.attempt}", int(time.time())
        headers = {
            "Content-Type": "application/json",
            "User-Agent": "HGS",
            "webhook-id": message,
            "webhook-timestamp": str(now),
            "webhook-signature": signature(self._rules.secret, message, now, body),
        }
        connection = _connection(parts, self._rules.addresses(parts))
        try:
            path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
            connection.request("POST", path, body, headers)
            return connection.getresponse().status  # a redirection is an answer like any other: nobody follows it
        finally:
            connection.close()


def signature(secret: bytes, message: str, now: int, body: bytes) -> str:
    """Return the header `webhook-signature` of a body that is sent at `now`."""
    digest = hmac.digest(secret, f"{message}.{now}.".encode() + body, hashlib.sha256)
    return f"v1,{base64.b64encode(digest).decode()}"


def _connection(parts: SplitResult, addresses: list[str]) -> http.client.HTTPConnection:
    """Return a connection to one of the addresses: a second look-up of the name could give others."""
    host = str(parts.hostname)
    if parts.scheme == "https":
        connection: http.client.HTTPConnection = http.client.HTTPSConnection(host, parts.port, timeout=TIMEOUT)
        plain = _connected(addresses, connection.port)
        connection.sock = ssl.create_default_context().wrap_socket(plain, server_hostname=host)
    else:
        connection = http.client.HTTPConnection(host, parts.port, timeout=TIMEOUT)
        connection.sock = _connected(addresses, connection.port)
    return connection


def _connected(addresses: list[str], port: int) -> socket.socket:
    error: OSError | None = None
    for address in addresses:
        try:
            return socket.create_connection((address, port), timeout=TIMEOUT)
        except OSError as failed:
            error = failed
    raise error or OSError("the name has no address")
