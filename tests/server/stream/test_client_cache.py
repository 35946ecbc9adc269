from __future__ import annotations

from collections.abc import Callable

import pytest

from server.bench.bench_scene import made_up_scene
from server.protocol.messages import Hello, ProtocolError
from server.scenes.scene_index import SceneIndex, read_scene
from server.stream.client_cache import ClientCache

MakeScene = Callable[..., SceneIndex]


def test_chunks_are_named_by_id_or_by_bits_of_the_manifest_that_is_there(make_scene: MakeScene) -> None:
    scene = make_scene([10, 20], [(0.0, 1.0, [1000, 2000])])
    order = list(scene.sizes)
    hello = Hello(2, 0, have=frozenset({order[3], bytes(32)}), manifest_id=scene.manifest_id, have_bits=b"\x03")
    assert ClientCache.of(hello, scene).whole == {order[0], order[1], order[3]}
    other = Hello(2, 0, have=frozenset({order[3]}), manifest_id=bytes(32), have_bits=b"\x03")
    assert ClientCache.of(other, scene).whole == {order[3]}


def test_pages_name_what_they_list_by_bits() -> None:
    scene = read_scene("bench", made_up_scene(120, static_bytes=1200, slice_bytes=90).document)
    (first, second, *_), listed = scene.page_chunks, scene.page_chunks
    pages = {first: b"\x05\x80", second: b"", bytes(32): b"\xff"}
    known = {first, second, listed[first][0], listed[first][2], listed[first][15]}
    assert ClientCache.of(Hello(3, 0, pages=pages), scene).whole == known
    assert ClientCache.of(Hello(2, 0, pages=pages), scene.whole).whole == set()


def test_what_is_lacking_counts_parts_once_and_wholes_not_at_all(make_scene: MakeScene) -> None:
    scene = make_scene([10, 20], [(0.0, 1.0, [1000])])
    first, second = scene.static
    parts = {first.id: 4, second.id: 5, bytes(32): 1 << 40}
    cache = ClientCache.of(Hello(2, 0, have=frozenset({second.id}), parts=parts), scene)
    assert cache.parts == {first.id: 4}
    assert cache.lacking(scene.sizes) == 6 + 1000


@pytest.mark.parametrize("offset", [10, 1 << 40])
def test_a_part_must_be_smaller_than_its_chunk(make_scene: MakeScene, offset: int) -> None:
    scene = make_scene([10], [])
    with pytest.raises(ProtocolError, match=f"has 10 bytes, not more than {offset}"):
        ClientCache.of(Hello(2, 0, parts={scene.static[0].id: offset}), scene)
