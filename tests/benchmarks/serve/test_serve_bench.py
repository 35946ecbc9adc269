from __future__ import annotations

import asyncio
from typing import Any

import pytest

from benchmarks.serve import serve_bench
from benchmarks.serve.serve_bench import bench_serve, serve_text


@pytest.mark.slow
def test_viewers_and_the_server_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serve_bench, "AHEAD", 0.2)
    monkeypatch.setattr(serve_bench, "WITNESSES", 1)
    report = asyncio.run(bench_serve(2, 1.0, minutes=0.2, processes=1))
    assert report["witnesses"]["playing"] == 1
    assert report["visits"] == 2
    assert report["lateness"]["count"] > 0
    assert report["server_seconds"] > 0
    assert report["viewers_cores"] > 0
    assert "2 viewers" in serve_text(report)


@pytest.mark.slow
def test_bad_clients_are_told_one_kind_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = {
        "STALLED": 2,
        "IDLE": 4,
        "FLOODERS": 1,
        "RESTING": 2,
        "PATIENCE": 0.1,
        "PING_SECONDS": 0.1,
        "FLOOD_SECONDS": 0.5,
        "REST_SECONDS": 0.5,
    }
    for name, value in settings.items():
        monkeypatch.setattr(serve_bench, name, value)

    async def crowd(*_: Any) -> dict[str, Any]:
        return {}

    monkeypatch.setattr(serve_bench, "_crowd", crowd)
    found = asyncio.run(bench_serve(1, 1.0, minutes=0.1, bad_clients=True))["bad_clients"]
    assert found["stalled"]["still_there"] == 2  # they are cut off after 45 s
    assert found["stalled"]["kernel_each"] > 0
    assert found["pings_alone"]["count"] > 0
    assert found["resting"]["server_seconds_each"] > 0
    assert found["idle"]["pings"]["count"] > 0
    assert found["idle"]["server_seconds"] > 0
    assert found["idle_and_flooders"]["pings"]["count"] > 0


def test_text_tells_what_was_found() -> None:
    few = {"count": 3, "p50": 0.001, "p99": 0.0025, "max": 0.003}
    report = {
        "viewers": 7,
        "seconds": 5.0,
        "processes": 2,
        "cores": 4,
        "load": 1.5,
        "visits": 7,
        "lost": 1,
        "bytes": 5_000_000,
        "mbit_per_viewer": 0.9,
        "server_seconds": 0.02,
        "server_seconds_per_gb": 4.0,
        "busiest_core": 0.25,
        "viewers_cores": 0.5,
        "memory": 200_000_000,
        "memory_per_viewer": 80_000.0,
        "lateness": few,
        "witnesses": {"count": 5, "playing": 0, "start_p50": None, "stalls": 0},
        "bad_clients": {
            "pings_alone": few,
            "stalled": {"count": 50, "still_there": 0, "seconds": 46.0, "kernel_each": 37_000},
            "resting": {"count": 1000, "server_seconds_each": 5e-6},
            "idle": {"count": 5000, "pings": few, "server_seconds": 0.8},
            "idle_and_flooders": {"count": 4, "pings": few | {"count": 0}},
        },
    }
    text = serve_text(report)
    assert "2 server(s): 5 MB, 0.90 Mbit/s each, 1 lost" in text
    assert "lateness: p50 1.0 ms, p99 2.5 ms, max 3.0 ms" in text
    assert "none plays" in text
    assert "0 of them there after 46 s, 37 kB" in text
    assert "1000 viewers at rest: 5.0 us" in text
    assert "max 3.0 ms; 0.80 s of processor time" in text
    assert "with 4 that seek all the time: none" in text
