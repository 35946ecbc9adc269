from __future__ import annotations

import asyncio

from benchmarks.serve.bad_clients import idling, pings, stalled
from benchmarks.serve.measured_server import BenchServer


def test_bad_clients_are_there_while_they_are_wanted() -> None:
    async def scenario() -> None:
        server = BenchServer(None, 0.1)
        try:
            async with stalled(server.url, 2):
                assert (await server.costs()).connections == 2
                async with asyncio.timeout(60):
                    while (await server.costs()).kernel <= 2 * 4096:  # they take no more
                        await asyncio.sleep(0.05)
            with idling(server.port, 3):
                assert await pings(server.url, 0.1)
                assert (await server.costs()).connections >= 3
        finally:
            server.close()

    asyncio.run(scenario())
