from __future__ import annotations

from collections.abc import Callable

import pytest

from server.bench.bench_scene import made_up_scene
from server.protocol.messages import Hello, ProtocolError
from server.scenes.scene_index import SceneIndex, read_scene
from server.stream.client_cache import ClientCache

MakeScene = Callable[..., SceneIndex]


def test_pages_name_what_they_list_by_bits() -> None:
    scene = read_scene("bench", made_up_scene(120, static_bytes=1200, slice_bytes=90).document)
    (first, second, *_), listed = scene.page_chunks, scene.page_chunks
    pages = {first: b"\x05\x80", second: b"", bytes(32): b"\xff"}
    known = {first, second, listed[first][0], listed[first][2], listed[first][15]}
    assert ClientCache.of(Hello(1, 0, pages=pages), scene).whole == known


def test_what_is_lacking_counts_parts_once_and_wholes_not_at_all(make_scene: MakeScene) -> None:
    scene = make_scene([10, 20], [(0.0, 1.0, [1000])])
    first, second = scene.static
    parts = {first.id: 4, second.id: 5, bytes(32): 1 << 40}
    cache = ClientCache.of(Hello(1, 0, have=frozenset({second.id}), parts=parts), scene)
    assert cache.parts == {first.id: 4}
    assert cache.lacking(scene.sizes) == 6 + 1000


@pytest.mark.parametrize("offset", [10, 1 << 40])
def test_a_part_must_be_smaller_than_its_chunk(make_scene: MakeScene, offset: int) -> None:
    scene = make_scene([10], [])
    with pytest.raises(ProtocolError, match=f"has 10 bytes, not more than {offset}"):
        ClientCache.of(Hello(1, 0, parts={scene.static[0].id: offset}), scene)
