from __future__ import annotations

import asyncio
import json
import socket

import httpx

from server.bench.bench_scene import made_up_scene
from server.bench.one_scene_server import serving
from server.listener.http_server import bind

SCENE = made_up_scene(1, static_bytes=12_000, slice_bytes=3_000)


def test_one_scene_is_served_with_its_chunks_and_no_other() -> None:
    name = SCENE.manifest.static[0].id

    async def fetch() -> list[httpx.Response]:
        async with serving(SCENE) as port, httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}/v1") as client:
            paths = ("/scenes/bench/manifest", f"/chunks/{name}", "/scenes/other/manifest")
            return [await client.get(path) for path in paths]

    manifest, chunk, other = asyncio.run(fetch())
    assert manifest.json() == json.loads(SCENE.document)
    assert chunk.content == SCENE.chunks[name]
    assert other.status_code == 404


def test_it_is_served_on_the_socket_that_is_given() -> None:
    async def port_of(listener: socket.socket) -> int:
        async with serving(SCENE, listener) as port:
            return port

    listener = bind("127.0.0.1", 0)
    expected = listener.getsockname()[1]
    assert asyncio.run(port_of(listener)) == expected
