"""Connections of a real server, as seen by clients that do not behave."""

from __future__ import annotations

import asyncio
import socket
from typing import Any

import httpx

from tests.server.conftest import running_server


def test_answers_leave_at_once(server: Any) -> None:
    async def scenario() -> None:
        async with running_server(server.app) as (http, address), httpx.AsyncClient() as client:
            await client.get(f"http://{address}/v1/health")
            (connection,) = http.server_state.connections
            accepted = connection.transport.get_extra_info("socket")
            assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY) != 0

    asyncio.run(scenario())
