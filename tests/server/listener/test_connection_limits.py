from __future__ import annotations

import asyncio
import subprocess
import sys
from dataclasses import dataclass

import pytest

from server.listener.connection_limits import ENDED_TOGETHER, ConnectionLimits, OpenConnections
from tests.conftest import REPOSITORY


@dataclass(eq=False)
class Connection:
    """A connection that notes whether it was dropped."""

    address: str = "a"
    dropped: bool = False

    def drop(self) -> None:
        self.dropped = True


def account(total: int = 100, per_address: int = 100) -> OpenConnections:
    return OpenConnections(ConnectionLimits(total, per_address, batch=1))


def waiting(open_: OpenConnections, address: str = "a") -> Connection:
    """Return a connection that was admitted and waits for its client's request."""
    connection = Connection(address)
    assert open_.admit(connection)
    open_.waits(connection)
    return connection


@pytest.mark.parametrize(("files", "total", "each"), [(256, 192, 48), (1024, 768, 192), (1 << 20, 8192, 2048)])
def test_some_files_are_left_for_the_store_and_the_database(files: int, total: int, each: int) -> None:
    limits = ConnectionLimits.for_files(files)
    assert (limits.total, limits.per_address) == (total, each)
    assert limits.total + limits.batch < files
    assert ConnectionLimits.for_files(files, 7).per_address == 7


def test_the_one_that_waits_the_longest_makes_room() -> None:
    open_ = account(total=2)
    first, second = waiting(open_), waiting(open_)
    open_.works(first)
    open_.waits(first)  # it has answered one request, and waits for less long than the other
    assert open_.admit(Connection("b"))
    assert (first.dropped, second.dropped) == (False, True)


def test_connections_in_use_make_no_room() -> None:
    open_ = account(total=2)
    busy = [waiting(open_), waiting(open_)]
    for connection in busy:
        open_.works(connection)
    assert not open_.admit(Connection("b"))
    assert not any(connection.dropped for connection in busy)


def test_an_address_that_has_its_share_makes_room_of_its_own() -> None:
    open_ = account(per_address=2)
    other = waiting(open_, "b")
    own = [waiting(open_), waiting(open_)]
    assert open_.admit(Connection())
    assert (own[0].dropped, own[1].dropped, other.dropped) == (True, False, False)


def test_an_address_that_uses_its_share_is_refused_while_others_wait() -> None:
    open_ = account(per_address=1)
    waiting(open_, "b")
    assert open_.admit(Connection())
    assert not open_.admit(Connection())
    assert open_.admit(Connection("c"))


def test_the_place_of_a_connection_that_has_ended_is_free_once() -> None:
    open_ = account(total=2)
    ended, stays = Connection(), Connection()
    assert open_.admit(ended)
    assert open_.admit(stays)
    for _ in range(2):  # whoever ends it may tell so twice
        open_.release(ended)
    assert open_.admit(Connection())
    assert not open_.admit(Connection())


def test_a_connection_that_has_ended_makes_no_room() -> None:
    open_ = account(total=1)
    ended = waiting(open_)
    open_.release(ended)
    assert open_.admit(Connection())
    assert not open_.admit(Connection())
    assert not ended.dropped


def test_a_connection_that_was_refused_takes_no_place_by_waiting() -> None:
    open_ = account(total=1)
    assert open_.admit(Connection())
    refused = Connection()
    assert not open_.admit(refused)
    open_.waits(refused)
    assert not open_.admit(Connection())
    assert not refused.dropped


RAISE = """
import resource
from server.listener.connection_limits import open_file_limit, raise_open_file_limit

resource.setrlimit(resource.RLIMIT_NOFILE, (64, 128))
print(open_file_limit())
raise_open_file_limit()
print(open_file_limit())
"""


def test_a_process_may_open_as_many_files_as_the_system_allows() -> None:
    told = subprocess.run([sys.executable, "-c", RAISE], capture_output=True, text=True, check=True, cwd=REPOSITORY)
    assert told.stdout.split() == ["64", "128"]


def test_those_that_time_out_together_end_a_few_at_a_time() -> None:
    async def scenario() -> None:
        open_, ended = account(), 0

        def end() -> None:
            nonlocal ended
            ended += 1

        for _ in range(10 * ENDED_TOGETHER):
            open_.in_turn(end)
        while ended < 10 * ENDED_TOGETHER:
            before = ended
            await asyncio.sleep(0)  # others are served
            assert ended - before <= ENDED_TOGETHER
        open_.in_turn(end)
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        assert ended == 10 * ENDED_TOGETHER + 1

    asyncio.run(scenario())


def test_few_connections_are_accepted_at_once() -> None:
    assert ConnectionLimits.for_files(1 << 20).batch <= 64
