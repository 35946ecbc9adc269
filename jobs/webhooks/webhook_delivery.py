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
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from urllib.parse import SplitResult

from hgs_core.base.errors import InputError
from jobs.home.passing_faults import one_line
from jobs.process.lasting_thread import lasting_thread
from jobs.records.announcements import Announcement, WebhookTable
from jobs.webhooks.webhook_rules import WebhookRules

__all__ = ["WebhookDelivery", "signature"]

TIMEOUT = 10.0  # seconds without a byte
LONGEST = 30.0  # seconds that one delivery may take, whatever comes: less than its lease
POLL = 2.0  # seconds between two looks for what is due
GONE = 410

log = logging.getLogger(__name__)


class WebhookDelivery:
    """The delivery of due announcements, by any number of processes at once."""

    def __init__(self, table: WebhookTable, rules: WebhookRules) -> None:
        self._table = table
        self._rules = rules

    def start(self) -> None:
        """Send from a thread of its own, as long as the process lives."""
        lasting_thread("webhooks", self._run).start()

    def deliver_due(self) -> int:
        """Try everything that is due once; return how many arrived."""
        arrived = 0
        while (one := self._table.take()) is not None:
            try:
                status = self._send(one)
            except (InputError, OSError, http.client.HTTPException) as error:  # InputError: no longer allowed
                self._table.failed(one, one_line(str(error) or type(error).__name__))
            except Exception as error:  # nobody behind waits for it, and it is given up like any other
                log.warning("the end of job %s cannot be told: %r", one.job_id, error)
                self._table.failed(one, one_line(f"cannot be sent: {error}"))
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
        with _connection(parts, self._rules.addresses(parts), time.monotonic() + LONGEST) as connection:
            path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
            connection.request("POST", path, body, headers)
            return connection.getresponse().status  # a redirection is an answer like any other: nobody follows it


def signature(secret: bytes, message: str, now: int, body: bytes) -> str:
    """Return the header `webhook-signature` of a body that is sent at `now`."""
    digest = hmac.digest(secret, f"{message}.{now}.".encode() + body, hashlib.sha256)
    return f"v1,{base64.b64encode(digest).decode()}"


@contextmanager
def _connection(parts: SplitResult, addresses: list[str], end: float) -> Iterator[http.client.HTTPConnection]:
    """Connect to one of the addresses, as a second look-up of the name could give others; until `end` at most.

    Every byte begins the time of the socket anew: a receiver that sends one now and then could hold us for ever.
    """
    host = str(parts.hostname)
    secure = parts.scheme == "https"
    kind = http.client.HTTPSConnection if secure else http.client.HTTPConnection
    with closing(kind(host, parts.port, timeout=TIMEOUT)) as connection:
        plain = _connected(addresses, connection.port, end)
        with plain.dup() as same:  # TLS takes `plain` over
            cut = threading.Timer(end - time.monotonic(), _shut, (same,))
            cut.daemon = True
            cut.start()
            try:
                context = ssl.create_default_context()
                connection.sock = context.wrap_socket(plain, server_hostname=host) if secure else plain
                yield connection
            finally:
                cut.cancel()
                cut.join()
                plain.close()


def _connected(addresses: list[str], port: int, end: float) -> socket.socket:
    error: OSError | None = None
    for address in addresses:
        try:
            return socket.create_connection((address, port), timeout=max(0.1, min(TIMEOUT, end - time.monotonic())))
        except OSError as failed:
            error = failed
        if time.monotonic() >= end:
            break
    raise error or OSError("the name has no address")


def _shut(connection: socket.socket) -> None:
    with suppress(OSError):  # it has ended by itself
        connection.shutdown(socket.SHUT_RDWR)
