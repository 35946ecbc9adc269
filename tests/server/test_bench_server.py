from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from server.bad_clients import pings
from server.bench_server import BenchServer


def test_server_tells_what_it_has_cost() -> None:
    async def scenario() -> None:
        server = BenchServer(None, 0.1)
        try:
            assert server.manifest.end == 6.0
            before = await server.costs()
            assert await pings(server.url, 0.1)
            after = await server.costs()
            assert after.processor > before.processor
            assert after.memory > 1 << 20
        finally:
            server.close()

    asyncio.run(scenario())


def test_folder_without_a_scene_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=str(tmp_path)):
        BenchServer(tmp_path, 1.0)
