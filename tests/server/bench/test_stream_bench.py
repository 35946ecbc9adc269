from __future__ import annotations

import asyncio

from server.bench.bench_scene import made_up_scene
from server.bench.stream_bench import bench_stream, stream_text

SCENE = made_up_scene(2, static_bytes=60_000, slice_bytes=9_000)


def test_every_line_is_watched() -> None:
    report, shown = asyncio.run(bench_stream(SCENE, 0.8))
    assert [row["mbit"] for row in report["starts"]] == [2, 50]
    assert all(0 < row["start_share"] < 1 for row in report["starts"])
    assert len(shown) == len(report["lines"]) == 3
    assert report["seeks"]["twice"] == 0
    assert report["seeks"]["buffered"]["count"] >= 20
    assert report["drops"]["twice"] == 0
    report["lines"][0]["psnr"] = [20.0, 30.0, 25.0]
    text = stream_text(report)
    assert "0.8 of its rate: 25.0 dB (median), 20.0 dB (least)" in text
    assert "2 Mbit/s" in text
