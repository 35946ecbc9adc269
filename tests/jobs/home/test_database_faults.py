"""Writing until the database takes it."""

from __future__ import annotations

import asyncio

import pytest
import sqlalchemy as sa

from jobs.home import database_faults


@pytest.fixture(autouse=True)
def slept(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    seconds: list[float] = []

    async def sleep(wait: float) -> None:
        seconds.append(wait)

    monkeypatch.setattr(database_faults.asyncio, "sleep", sleep)
    return seconds


def test_a_fault_of_the_database_is_waited_for_longer_each_time(slept: list[float]) -> None:
    faults: list[Exception] = [sa.exc.OperationalError("", None, Exception("locked")) for _ in range(7)]

    def write(value: int) -> int:
        if faults:
            raise faults.pop()
        return value

    assert asyncio.run(database_faults.persist(write, 3)) == 3
    assert slept == [1, 2, 4, 8, 16, 30, 30]


def test_any_other_fault_is_raised(slept: list[float]) -> None:
    def write() -> None:
        raise ValueError("a fault of this program")

    with pytest.raises(ValueError, match="of this program"):
        asyncio.run(database_faults.persist(write))
    assert slept == []
