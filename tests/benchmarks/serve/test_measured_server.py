from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from benchmarks.serve import measured_server as bench_server
from benchmarks.serve.bad_clients import pings
from benchmarks.serve.measured_server import BenchServer
from hgs_core.base.errors import InputError
from server.bench.bench_scene import made_up_scene


def test_server_tells_what_it_has_cost() -> None:
    async def scenario() -> None:
        server = BenchServer(None, 0.1)
        try:
            assert server.manifest.end == 6.0
            before = await server.costs()
            assert await pings(server.url, 0.1)
            after = await server.costs()
            assert after.processor > before.processor
            assert after.memory > 1 << 20
        finally:
            server.close()

    asyncio.run(scenario())


def test_chunk_that_is_missing_is_named(tmp_path: Path) -> None:
    scene = made_up_scene(1)
    (tmp_path / "manifest.json").write_bytes(scene.document)
    (tmp_path / "chunks").mkdir()
    for name, data in scene.chunks.items():
        (tmp_path / "chunks" / name).write_bytes(data)
    gone = scene.manifest.slices[0].chunks[0].id
    (tmp_path / "chunks" / gone).unlink()
    with pytest.raises(InputError, match=rf"{gone}: cannot be read: No such file or directory; encode the run again"):
        BenchServer(tmp_path, 1.0)


def test_server_that_ends_before_it_serves_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_server, "_serve", print)  # another program in its place
    with pytest.raises(RuntimeError, match="has ended before it served"):
        BenchServer(None, 0.1)


def test_folder_without_a_scene_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=str(tmp_path)):
        BenchServer(tmp_path, 1.0)
