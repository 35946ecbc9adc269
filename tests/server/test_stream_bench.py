from __future__ import annotations

import asyncio
import json
from pathlib import Path

from hgs_core.codec.format.folder import CHUNKS, MANIFEST
from hgs_core.codec.format.manifest import Manifest
from server.stream_bench import bench_stream, made_up_scene, scene_of, stream_text

SCENE = made_up_scene(2, static_bytes=60_000, slice_bytes=9_000)


def test_made_up_scene_is_one_that_readers_take() -> None:
    assert Manifest.from_json(json.loads(SCENE.document)).to_json() == SCENE.manifest.to_json()
    assert set(SCENE.chunks) == {entry.id for entry in SCENE.manifest.chunks}
    assert SCENE.rate == 8 * 4 * 9_000 / 2


def test_scene_folder_is_read(tmp_path: Path) -> None:
    (tmp_path / CHUNKS).mkdir()
    (tmp_path / MANIFEST).write_bytes(SCENE.document)
    for name, data in SCENE.chunks.items():
        (tmp_path / CHUNKS / name).write_bytes(data)
    read = scene_of(tmp_path)
    assert (read.document, read.chunks, read.size) == (SCENE.document, SCENE.chunks, SCENE.size)


def test_every_line_is_watched_with_layers_and_without() -> None:
    report, shown = asyncio.run(bench_stream(SCENE, 0.8))
    assert [(row["mbit"], row["protocol"]) for row in report["starts"]] == [(2, 1), (2, 2), (50, 1), (50, 2)]
    first, layered = report["starts"][:2]
    assert layered["start_share"] < first["start_share"]
    assert [row["protocol"] for row in report["lines"]] == [1, 2] * 3
    assert len(shown) == len(report["lines"])
    assert report["seeks"]["twice"] == 0
    assert report["seeks"]["buffered"]["count"] >= 20
    assert report["drops"]["twice"] == 0
    report["lines"][0]["psnr"] = [20.0, 30.0, 25.0]
    text = stream_text(report)
    assert "0.8 of its rate, protocol 1: 25.0 dB (median), 20.0 dB (least)" in text
    assert "2 Mbit/s" in text
