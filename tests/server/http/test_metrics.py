from __future__ import annotations

import asyncio
import time

import pytest
from prometheus_client.parser import text_string_to_metric_families

from server.http import metrics as module
from server.http.metrics import Metrics


def test_what_is_counted_is_told_in_prometheus_words() -> None:
    metrics = Metrics()
    metrics.requests.labels("GET", "/v1/health", "200").inc()
    families = {family.name: family for family in text_string_to_metric_families(metrics.text().decode())}
    [sample] = [sample for sample in families["hgs_requests"].samples if sample.name == "hgs_requests_total"]
    assert (sample.labels, sample.value) == ({"method": "GET", "route": "/v1/health", "status": "200"}, 1.0)
    assert families["hgs_build_info"].samples[0].value == 1


def test_two_servers_count_for_themselves() -> None:
    first, second = Metrics(), Metrics()
    first.streams.inc()
    assert (b"hgs_streams 1.0" in first.text(), b"hgs_streams 0.0" in second.text()) == (True, True)


def test_a_late_event_loop_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "LAG_INTERVAL", 0.01)

    async def run() -> float:
        metrics = Metrics()
        watch = asyncio.create_task(metrics.watch_lag())
        await asyncio.sleep(0)
        time.sleep(0.2)
        await asyncio.sleep(0.02)
        watch.cancel()
        return metrics.lag

    assert asyncio.run(run()) > 0.1
