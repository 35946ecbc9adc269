from __future__ import annotations

import asyncio

from server.bench.shaped_line import LONGEST_BURST, LineClock, ShapedLine


async def _echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while data := await reader.read(1000):
        writer.write(data * 100)
        await writer.drain()
    writer.close()


def test_answers_come_through_once_the_line_lets_them() -> None:
    async def scenario() -> None:
        rate = 0.0
        server = await asyncio.start_server(_echo, "127.0.0.1", 0)
        async with server, ShapedLine(server.sockets[0].getsockname()[1], lambda _: rate) as line:
            host, port = line.address.split(":")
            reader, writer = await asyncio.open_connection(host, int(port))
            writer.write(b"hello")
            waiting = asyncio.create_task(reader.readexactly(500))
            await asyncio.sleep(0.1)
            assert not waiting.done()
            rate = 1e9
            assert await asyncio.wait_for(waiting, 30) == b"hello" * 100
            assert line.passed == 500
            writer.close()

    asyncio.run(scenario())


def test_server_that_leaves_ends_the_connection() -> None:
    async def scenario() -> None:
        server = await asyncio.start_server(lambda _, writer: writer.close(), "127.0.0.1", 0)
        async with server, ShapedLine(server.sockets[0].getsockname()[1], lambda _: 1e9) as line:
            host, port = line.address.split(":")
            reader, writer = await asyncio.open_connection(host, int(port))
            assert await asyncio.wait_for(reader.read(), 30) == b""
            writer.close()

    asyncio.run(scenario())


def test_line_makes_up_for_delays_while_something_waits_and_not_for_having_been_idle() -> None:
    clock = LineClock(0.0)
    assert clock.carry(1000, 8000.0, 0.0, idle=True) == 1.0
    assert clock.carry(1000, 8000.0, 5.0, idle=False) == 2.0
    assert clock.carry(1000, 8000.0, 9.0, idle=True) == 10.0 - LONGEST_BURST
