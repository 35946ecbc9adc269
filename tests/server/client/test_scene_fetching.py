from __future__ import annotations

import asyncio
import functools
import threading
from collections.abc import Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from server.bench.bench_scene import made_up_scene
from server.bench.one_scene_server import serving
from server.cli import main
from server.client import scene_fetching
from server.client import stream_client as client_module
from server.client.stream_client import StreamClient, StreamRefusedError
from server.protocol.messages import Seek
from server.scenes.scene_index import read_scene
from tests.growing import write_growing_scene
from tests.server.lacking_proxy import Lack, lacking_proxy

SCENE = made_up_scene(3, static_bytes=200_000, slice_bytes=30_000)


@asynccontextmanager
async def behind(lack: Lack, most: int | None = None):  # type: ignore[no-untyped-def]
    async with serving(SCENE) as port, lacking_proxy(port, lack, most) as proxy:
        yield f"ws://127.0.0.1:{proxy}/v1/scenes/bench/stream"


async def received(client: StreamClient, until: Callable[[], bool] | None = None) -> None:
    """Run a client until all is here."""
    running = asyncio.create_task(client.run())
    try:
        async with asyncio.timeout(60):
            while not (until or (lambda: client.complete))():
                if running.done():
                    await running
                await asyncio.sleep(0.01)
            await client.close()
            await running
    finally:
        running.cancel()


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client_module, "FIRST_RETRY", 0.01)
    monkeypatch.setattr(scene_fetching, "FIRST_RETRY", 0.01)


@pytest.mark.parametrize("lack", ["no upgrade", "200", "400", "502", "hang up", "drop", "swallow"])
def test_a_scene_is_fetched_where_a_proxy_lets_no_stream_through(lack: Lack, monkeypatch: pytest.MonkeyPatch) -> None:
    if lack == "swallow":
        monkeypatch.setattr(client_module, "FIRST_MESSAGE", 0.5)

    async def scenario() -> StreamClient:
        async with behind(lack) as url:
            client = StreamClient(url)
            await received(client)
            return client

    client = asyncio.run(scenario())
    assert client.over_http
    assert client.have == SCENE.chunks
    assert client.payload == sum(map(len, SCENE.chunks.values()))
    assert client.manifest is not None
    assert client.manifest.to_json() == SCENE.manifest.to_json()


def test_one_failure_is_that_of_a_server_that_restarts() -> None:
    async def scenario() -> StreamClient:
        async with behind("502", most=1) as url:
            client = StreamClient(url)
            await received(client)
            return client

    client = asyncio.run(scenario())
    assert not client.over_http
    assert client.have == SCENE.chunks


def test_a_stream_that_has_worked_is_waited_for() -> None:
    async def scenario() -> StreamClient:
        async with serving(SCENE) as port:
            client = StreamClient(f"ws://127.0.0.1:{port}/v1/scenes/bench/stream")
            running = asyncio.create_task(client.run())
            while client.manifest is None:
                await asyncio.sleep(0)
            client.url = f"ws://127.0.0.1:{port}/v1/scenes/bench/nowhere"  # handshakes fail from now on
            client.drop()
            await asyncio.sleep(0.3)
            running.cancel()
            return client

    assert not asyncio.run(scenario()).over_http


def test_a_server_that_is_away_is_no_proxy_that_lacks_something() -> None:
    async def scenario() -> StreamClient:
        async with serving(SCENE) as port:
            pass
        client = StreamClient(f"ws://127.0.0.1:{port}/v1/scenes/bench/stream")
        running = asyncio.create_task(client.run())
        await asyncio.sleep(0.3)
        running.cancel()
        return client

    assert not asyncio.run(scenario()).over_http


def test_a_scene_that_is_not_there_is_refused_over_http_too() -> None:
    async def scenario() -> None:
        async with behind("no upgrade") as url:
            await received(StreamClient(url.replace("bench", "other")))

    with pytest.raises(StreamRefusedError, match="no such scene"):
        asyncio.run(scenario())


def test_what_is_fetched_next_follows_the_playhead() -> None:
    order: list[str] = []

    async def scenario() -> None:
        async with behind("no upgrade") as url:
            client = StreamClient(url, at=SCENE.manifest.slices[-1].start)
            client.arrived = lambda: order.extend(name for name in client.have if name not in order)
            await client.send(Seek(SCENE.manifest.slices[-1].start))
            await received(client)

    asyncio.run(scenario())
    last, first = SCENE.manifest.slices[-1].chunks[0].id, SCENE.manifest.slices[0].chunks[-1].id
    assert order.index(last) < order.index(first)


@contextmanager
def hosting(folder: Path) -> Iterator[str]:
    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, format: str, *args: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(folder)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


def published(folder: Path) -> Path:
    """A folder on a web server, with pages and whole."""
    site = folder / "my scenes" / "bench"
    (site / "chunks").mkdir(parents=True)
    (site / "manifest.json").write_bytes(SCENE.document)
    (site / "index.hgs").write_bytes(read_scene("bench", SCENE.document).manifest)
    for name, data in SCENE.chunks.items():
        (site / "chunks" / name).write_bytes(data)
    return site


@pytest.mark.parametrize("address", ["", "manifest.json", "index.hgs"])
def test_a_folder_of_a_web_server_is_fetched(address: str, tmp_path: Path) -> None:
    published(tmp_path)
    with hosting(tmp_path) as host:
        client = StreamClient(f"{host}/my%20scenes/bench/{address}")
        asyncio.run(received(client))
    assert (client.have, client.connections) == (SCENE.chunks, 0)


def test_chunks_that_a_folder_lacks_or_has_damaged_are_missing(tmp_path: Path) -> None:
    chunks = published(tmp_path) / "chunks"
    gone, damaged = sorted(SCENE.chunks)[:2]
    (chunks / gone).unlink()
    (chunks / damaged).write_bytes(bytes(len(SCENE.chunks[damaged])))
    with hosting(tmp_path) as host:
        client = StreamClient(f"{host}/my%20scenes/bench/")
        asyncio.run(received(client))
    assert client.missing == {gone, damaged}
    assert client.have == {name: data for name, data in SCENE.chunks.items() if name not in client.missing}


def test_hgs_play_plays_a_folder_below_a_path(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    published(tmp_path)
    with hosting(tmp_path) as host:
        assert main(["play", f"{host}/my%20scenes/bench/", "--stats", "--seconds", "1.5"]) == 0
        assert "bytes of chunks came" in capsys.readouterr().out
        assert main(["play", f"{host}/none/", "--stats", "--seconds", "5"]) == 2
        assert "404" in capsys.readouterr().err


def test_a_scene_that_grows_is_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_fetching, "POLL", 0.05)
    write_growing_scene(tmp_path / "live", 1)

    async def scenario(host: str) -> StreamClient:
        client = StreamClient(f"{host}/live/")

        async def grow() -> None:
            while len(client.have) < 2:
                await asyncio.sleep(0.01)
            assert not client.complete
            write_growing_scene(tmp_path / "live", 3)

        await asyncio.gather(received(client), grow())
        return client

    with hosting(tmp_path) as host:
        client = asyncio.run(scenario(host))
    assert client.manifest is not None
    assert (client.manifest.end, client.manifest.live, len(client.have)) == (3.0, None, 4)
