from __future__ import annotations

import asyncio
import threading

import pytest
from starlette.concurrency import run_in_threadpool

from server.http.slow_work import SlowWork


def test_what_waits_for_slow_work_keeps_nobody_else_waiting() -> None:
    async def scenario() -> None:
        slow, go = SlowWork("slow", 2), threading.Event()
        waiting = [asyncio.create_task(slow.run(go.wait)) for _ in range(400)]
        assert await run_in_threadpool(lambda: "a page") == "a page"
        assert not any(task.done() for task in waiting)
        go.set()
        assert all(await asyncio.gather(*waiting))

    asyncio.run(scenario())


def test_what_it_raises_is_raised() -> None:
    with pytest.raises(ValueError, match="three"):
        asyncio.run(SlowWork("slow", 1).run(int, "three"))


def test_nothing_is_begun_after_it_was_closed() -> None:
    slow = SlowWork("slow", 1)
    slow.close()
    with pytest.raises(RuntimeError):
        asyncio.run(slow.run(int))
