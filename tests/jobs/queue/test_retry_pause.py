from __future__ import annotations

import pytest

from jobs.queue.retry_pause import retry_pause


@pytest.mark.parametrize(("waits", "seconds"), [(0, 5.0), (1, 10.0), (10, 5120.0), (11, 7200.0), (1000, 7200.0)])
def test_every_pause_is_twice_the_last_up_to_two_hours(waits: int, seconds: float) -> None:
    assert retry_pause(waits) == seconds
