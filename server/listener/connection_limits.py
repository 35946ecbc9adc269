"""Limits on open connections and idle times, and eviction of the connection that has waited longest."""

from __future__ import annotations

import asyncio
import logging
import resource
import sys
from collections import Counter, defaultdict, deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, Self

from uvicorn.server import ServerState

__all__ = ["ConnectionLimits", "OpenConnections", "open_file_limit", "raise_open_file_limit"]

log = logging.getLogger("hgs.server")

MOST_CONNECTIONS = 8192
MOST_SPARE_FILES = 2048
MOST_TOGETHER = 32  # connections per batch: a millisecond or two that blocks everything else
ENDED_TOGETHER = 8


@dataclass(frozen=True)
class ConnectionLimits:
    """Limits of one server; the defaults are those of docs/rest.md."""

    total: int
    per_address: int
    batch: int  # connections accepted before the first of them is served
    head_seconds: float = 10.0  # limit on a request's headers, counted from the connection's start or their first byte
    body_seconds: float = 20.0  # limit on the rest of a request, or on 64 KiB of it
    idle_seconds: int = 15  # longest pause between two requests
    stall_seconds: float = 30.0  # longest time that a client may read nothing of its response

    @classmethod
    def for_files(cls, files: int, per_address: int | None = None) -> Self:
        """Return the limits of a process that may open `files` files, with some reserved for the store and the
        database.

        Without `per_address`, an address may have a quarter of all connections.
        """
        spare = min(files // 4, MOST_SPARE_FILES)
        total = min(files - spare, MOST_CONNECTIONS)
        return cls(total, per_address or max(total // 4, 1), batch=min(max(spare // 2, 1), MOST_TOGETHER))


def open_file_limit() -> int:
    """Return how many files this process may open."""
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return files if files != resource.RLIM_INFINITY else sys.maxsize


def raise_open_file_limit() -> None:
    """Let this process and its children open as many files as the system allows."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


class Connection(Protocol):
    """A connection as `OpenConnections` tracks it."""

    @property
    def address(self) -> str:
        """The client's address, without its port."""
        ...

    def drop(self) -> None:
        """Close the connection at once, without an answer."""


class OpenConnections(ServerState):
    """Uvicorn's server state, with a count of each address's open connections.

    When all places are taken, the connection that has waited longest for a request is closed: active clients are
    served, however many idle connections others hold.
    """

    def __init__(self, limits: ConnectionLimits) -> None:
        super().__init__()
        self.limits = limits
        self._places: set[Connection] = set()
        self._of_address: Counter[str] = Counter()
        # Connections waiting for a request, the longest first: all, and by address.
        self._waiting: dict[Connection, None] = {}
        self._waiting_of: defaultdict[str, dict[Connection, None]] = defaultdict(dict)
        self._ends: deque[Callable[[], None]] = deque()

    def admit(self, connection: Connection) -> bool:
        """Give a new connection a place; return whether there was one."""
        limits, address = self.limits, connection.address
        if self._of_address[address] >= limits.per_address:
            full = f"{address} has {limits.per_address} connections; --connections-per-address allows more"
            waiting = self._waiting_of[address]
        elif len(self._places) >= limits.total:
            full, waiting = f"{limits.total} connections are open, which is the limit", self._waiting
        else:
            full, waiting = "", {}
        if full and not waiting:
            log.warning("connection refused, all places are in use: %s", full)
            return False
        if full:
            log.warning("closed the connection that waited longest: %s", full)
            last = next(iter(waiting))
            self.release(last)
            last.drop()
        self._places.add(connection)
        self._of_address[address] += 1
        return True

    def waits(self, connection: Connection) -> None:
        """Record that the connection waits for its client's request."""
        if connection in self._places:
            self._waiting[connection] = self._waiting_of[connection.address][connection] = None

    def works(self, connection: Connection) -> None:
        """Record that the connection is in use."""
        if connection in self._waiting:
            del self._waiting[connection], self._waiting_of[connection.address][connection]

    def in_turn(self, end: Callable[[], None]) -> None:
        """Call `end` soon, a few at a time, so that thousands of simultaneous time-outs block nothing."""
        self._ends.append(end)
        if len(self._ends) == 1:
            asyncio.get_running_loop().call_soon(self._end_some)

    def _end_some(self) -> None:
        loop = asyncio.get_running_loop()
        for _ in range(min(ENDED_TOGETHER, len(self._ends))):
            loop.call_soon(self._ends.popleft())
        if self._ends:
            loop.call_soon(self._end_some)

    def release(self, connection: Connection) -> None:
        """Release the place of a connection that has ended, if it still has one."""
        if connection not in self._places:
            return
        self.works(connection)
        self._places.remove(connection)
        self._of_address[connection.address] -= 1
        if not self._of_address[connection.address]:  # empty entries would be kept for ever
            del self._of_address[connection.address], self._waiting_of[connection.address]
