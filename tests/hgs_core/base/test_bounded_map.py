"""A bounded map: order, memory, and the end after an error."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from hgs_core.base.bounded_map import bounded_map


def test_results_come_in_order_whichever_is_ready_first() -> None:
    second_is_done = threading.Event()

    def work(number: int) -> int:
        if number == 0:
            assert second_is_done.wait(60)
        if number == 1:
            second_is_done.set()
        return number * number

    with ThreadPoolExecutor(2) as pool:
        assert list(bounded_map(pool, work, range(6), 3)) == [0, 1, 4, 9, 16, 25]


def test_few_items_are_held() -> None:
    taken: list[int] = []

    def items() -> Iterator[int]:
        for number in range(20):
            taken.append(number)
            yield number

    with ThreadPoolExecutor(2) as pool:
        for result in bounded_map(pool, lambda number: number, items(), 3):
            assert len(taken) <= result + 4  # three in the pool, and one that is about to enter it


def test_an_error_comes_at_its_turn_and_ends_the_work() -> None:
    begun: list[int] = []

    def work(number: int) -> int:
        begun.append(number)
        if number == 2:
            raise ValueError("the third")
        return number

    with ThreadPoolExecutor(1) as pool:
        results = bounded_map(pool, work, range(100), 2)
        assert [next(results), next(results)] == [0, 1]
        with pytest.raises(ValueError, match="the third"):
            next(results)
    assert len(begun) <= 5
