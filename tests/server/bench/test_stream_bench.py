from __future__ import annotations

import asyncio

from server.bench.bench_scene import made_up_scene
from server.bench.stream_bench import bench_stream, stream_text

SCENE = made_up_scene(2, static_bytes=60_000, slice_bytes=9_000)


def test_every_line_is_watched_with_layers_and_without() -> None:
    report, shown = asyncio.run(bench_stream(SCENE, 0.8))
    assert [(row["mbit"], row["protocol"]) for row in report["starts"]] == [(2, 1), (2, 3), (50, 1), (50, 3)]
    first, layered = report["starts"][:2]
    assert layered["start_share"] < first["start_share"]
    assert layered["start_of_line"] < first["start_of_line"]
    assert [row["protocol"] for row in report["lines"]] == [1, 3] * 3
    assert len(shown) == len(report["lines"])
    assert report["seeks"]["twice"] == 0
    assert report["seeks"]["buffered"]["count"] >= 20
    assert report["drops"]["twice"] == 0
    report["lines"][0]["psnr"] = [20.0, 30.0, 25.0]
    text = stream_text(report)
    assert "0.8 of its rate, protocol 1: 25.0 dB (median), 20.0 dB (least)" in text
    assert "2 Mbit/s" in text
