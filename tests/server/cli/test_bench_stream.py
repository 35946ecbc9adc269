"""`hgs bench stream`; tests/server/bench/test_stream_bench.py tests the measurements."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from server.bench import stream_bench
from server.cli import main
from tests.hgs_core.codec.scenes import encode, scene
from tests.synthetic import ring_of_cameras


def test_pictures_of_a_scene_are_told_for_the_first_time_round(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest = encode(scene(60, 40), tmp_path / "scene", ring_of_cameras(2, 32, 24))
    everything = frozenset(entry.id for entry in manifest.chunks)

    async def bench(*_: Any) -> Any:
        lines = [{"line": "slow"}]
        return {"lines": lines}, [[(0.1, frozenset()), (0.6, everything), (0.1, everything)]]

    monkeypatch.setattr(stream_bench, "bench_stream", bench)
    monkeypatch.setattr(stream_bench, "stream_text", lambda _: "text")
    assert main(["bench", "stream", str(tmp_path), "--json"]) == 0
    (line,) = json.loads(capsys.readouterr().out)["lines"]
    assert len(line["psnr"]) == 2
    assert line["psnr"][0] < line["psnr"][1] == 99.0


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        (["stream", "--seconds", "0"], "--seconds"),
        (["stream", "--minutes", "0"], "--minutes"),
        (["stream", "nowhere"], "nowhere"),
    ],
)
def test_bad_arguments_are_named(wrong: list[str], word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", *wrong]) == 2
    assert word in capsys.readouterr().err
