from __future__ import annotations

from server.serve_bench import bench_serve, serve_text


def test_viewers_and_the_server_are_counted() -> None:
    report = bench_serve(2, 0.5)
    assert report["playing"] == 2
    assert report["bytes"] > 500_000
    assert report["server_seconds"] > 0
    assert "2 viewers" in serve_text(report)
    assert "none plays" in serve_text(report | {"start_p50": None})
