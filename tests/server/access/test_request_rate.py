from __future__ import annotations

import asyncio
from typing import Any

import httpx
import pytest
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.routing import Route

from server.access import request_rate as module
from server.access.request_rate import BURST_SECONDS, RequestRate


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def answers(app: RequestRate, address: str, count: int) -> list[httpx.Response]:
    async def ask() -> list[httpx.Response]:
        transport = httpx.ASGITransport(app, client=(address, 1234))
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            return [await client.get("/") for _ in range(count)]

    return asyncio.run(ask())


def statuses(app: RequestRate, address: str, count: int) -> list[int]:
    return [answer.status_code for answer in answers(app, address, count)]


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def app(clock: Clock) -> RequestRate:
    async def page(request: Any) -> PlainTextResponse:
        return PlainTextResponse("here")

    return RequestRate(Starlette(routes=[Route("/", page)]), 2.0, clock)


def test_requests_beyond_the_rate_are_refused_until_their_time_has_come(app: RequestRate, clock: Clock) -> None:
    at_once = int(2 * BURST_SECONDS)
    assert statuses(app, "192.0.2.7", at_once + 3) == [200] * at_once + [429] * 3  # refused ones cost nothing
    (refused,) = answers(app, "192.0.2.7", 1)
    assert (refused.headers["Retry-After"], refused.json()["code"]) == ("1", "too-many-requests")
    clock.now += 1.0
    assert statuses(app, "192.0.2.7", 3) == [200, 200, 429]


def test_a_client_has_its_own_rate(app: RequestRate) -> None:
    assert statuses(app, "192.0.2.7", 20)[-1] == 429
    assert statuses(app, "192.0.2.8", 1) == [200]


def test_no_more_than_so_many_clients_are_remembered(app: RequestRate, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_CLIENTS", 2)
    for last in range(5):
        statuses(app, f"192.0.2.{last}", 1)
    assert list(app._of_client) == ["address 192.0.2.3/32", "address 192.0.2.4/32"]
