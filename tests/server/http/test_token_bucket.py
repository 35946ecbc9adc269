from __future__ import annotations

import pytest

from server.http.token_bucket import TokenBucket


def test_burst_is_free_and_what_is_above_waits_its_share() -> None:
    bucket = TokenBucket(rate=10, capacity=5)
    assert [bucket.spend(1, clock=7.0) for _ in range(7)] == pytest.approx([0, 0, 0, 0, 0, 0.1, 0.2])


def test_tokens_come_with_time_up_to_the_capacity() -> None:
    bucket = TokenBucket(rate=10, capacity=5)
    assert bucket.spend(5, clock=0.0) == 0
    assert bucket.spend(3, clock=0.2) == pytest.approx(0.1)
    assert bucket.spend(5, clock=1000.0) == 0
    assert bucket.spend(1, clock=1000.0) == pytest.approx(0.1)


def test_tokens_can_be_earned() -> None:
    bucket = TokenBucket(rate=10, capacity=5)
    bucket.spend(5, clock=0.0)
    bucket.earn(100)
    assert [bucket.spend(5, clock=0.0), bucket.spend(1, clock=0.0)] == pytest.approx([0, 0.1])
