from __future__ import annotations

import json

from hgs_core.codec.format.growth import first_segments
from hgs_core.codec.format.manifest import Manifest
from hgs_core.codec.format.paged_manifest import PagedManifest, read_index
from hgs_core.codec.format.paging import paged
from server.bench.bench_scene import made_up_scene
from server.client.client_hello import hello_of
from server.protocol.messages import MAX_HAVE

SCENE = made_up_scene(120, static_bytes=1200, slice_bytes=90)
MOVING = [chunk.id for chunk in SCENE.manifest.chunks[12:]]


def read(manifest: Manifest, count: int) -> PagedManifest:
    """A manifest in pages, of which the first so many have come."""
    made = paged(manifest, json.loads(json.dumps(manifest.to_json())))
    found = PagedManifest(read_index(made.index))
    for name, data in list(made.pages.items())[:count]:
        found.add(name, data)
    return found


def test_who_has_nothing_names_nothing() -> None:
    hello = hello_of(5, paged=None, have={}, parts={}, time=1.0)
    assert (hello.have, hello.pages, hello.parts) == (frozenset(), {}, {})
    assert (hello.protocol, hello.credits, hello.time, hello.follow) == (1, 5, 1.0, True)


def test_chunks_are_named_by_their_pages_and_others_by_their_ids() -> None:
    static = SCENE.manifest.static[0].id
    have = [MOVING[0], MOVING[9], MOVING[200], static]
    manifest = read(SCENE.manifest, 1)
    hello = hello_of(5, paged=manifest, have=have, parts={MOVING[1]: bytearray(7)})
    assert hello.pages == {bytes.fromhex(manifest.pages[0].id): b"\x01\x02" + bytes(14)}
    assert hello.have == {bytes.fromhex(name) for name in (MOVING[200], static)}  # the page of the one is not here
    assert hello.parts == {bytes.fromhex(MOVING[1]): 7}


def test_last_page_of_a_scene_that_grows_is_named_with_its_chunks_by_their_ids() -> None:
    manifest = read(first_segments(SCENE.manifest, 1), 1)
    hello = hello_of(5, paged=manifest, have=MOVING[:2], parts={})
    assert hello.pages == {}
    assert hello.have == {bytes.fromhex(name) for name in (*MOVING[:2], manifest.pages[0].id)}


def test_of_more_than_a_hello_may_name_the_last_are_named() -> None:
    have = [f"{k:064x}" for k in range(MAX_HAVE + 5)]
    hello = hello_of(5, paged=None, have=have, parts={})
    assert hello.have == frozenset(map(bytes.fromhex, have[5:]))
