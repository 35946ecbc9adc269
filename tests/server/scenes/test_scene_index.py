from __future__ import annotations

import gc
import gzip
import hashlib
import json
import tracemalloc
from collections.abc import Callable, Sequence

import pytest

from hgs_core.base.errors import InputError
from server.bench.bench_scene import made_up_scene
from server.scenes.scene_index import SceneIndex, read_scene, read_whole
from tests.server.conftest import SliceSpec

MakeScene = Callable[[Sequence[int], Sequence[SliceSpec]], SceneIndex]


def test_a_manifest_is_read_with_the_chunks_that_each_slice_needs(manifest: bytes, chunks: list[bytes]) -> None:
    scene = read_scene("studio", manifest)
    ids = [hashlib.sha256(chunk).digest() for chunk in chunks]
    assert [chunk.id for chunk in scene.static] == ids[:2]
    assert [(piece.start, piece.end) for piece in scene.slices] == [(0.0, 1.0), (1.0, 2.0), (2.0, 3.0)]
    # Each slice after the first needs the chunk of the one before, which has to come first.
    assert [[chunk.id for chunk in piece.chunks] for piece in scene.slices] == [[ids[2]], ids[2:4], ids[3:5]]
    assert scene.sizes == dict(zip(ids, map(len, chunks), strict=True))
    assert (scene.start, scene.end) == (0.0, 3.0)


def test_the_manifest_is_named_by_the_hash_of_its_bytes(manifest: bytes) -> None:
    scene = read_scene("studio", manifest)
    assert scene.document == manifest
    assert json.loads(gzip.decompress(scene.manifest)) == json.loads(manifest)
    assert scene.manifest_id == hashlib.sha256(scene.manifest).digest()
    whole = read_whole("studio", manifest)
    assert (whole.manifest, whole.manifest_id) == (manifest, hashlib.sha256(manifest).digest())


@pytest.mark.parametrize("manifest", [b"", b"{}", b"[" * 100_000, b"\xff"], ids=["empty", "bare", "deep", "not UTF-8"])
def test_what_is_no_manifest_is_refused_with_the_scene(manifest: bytes) -> None:
    with pytest.raises(InputError, match="manifest of scene studio"):
        read_scene("studio", manifest)


@pytest.mark.parametrize(
    ("time", "alive"), [(0.0, [0]), (0.5, [0]), (1.0, [0, 1]), (2.0, [1]), (2.5, [1, 2]), (3.0, [1, 2]), (-1.0, [])]
)
def test_slices_are_shown_from_their_start_to_before_their_end(
    make_scene: MakeScene, time: float, alive: list[int]
) -> None:
    """And the last one at its very end, as in a still picture of the last moment."""
    scene = make_scene([], [(0.0, 2.0, [1]), (1.0, 4.0, [1]), (2.5, 3.0, [1])])
    assert scene.alive(time) == alive


def test_sound_is_read_and_counts_for_the_size_and_for_what_a_link_opens(manifest: bytes, chunks: list[bytes]) -> None:
    name = hashlib.sha256(b"sound").hexdigest()
    pieces = [{"id": name, "bytes": 5, "start": start, "end": start + 1.0} for start in (0.0, 1.0)]
    audio = {"codec": "opus", "sample_rate": 48000, "channels": 1, "pieces": pieces}
    sounding = json.dumps(json.loads(manifest) | {"audio": audio}).encode()
    scene = read_scene("studio", sounding)
    assert [(piece.start, piece.chunks[0].id.hex(), piece.chunks[0].size) for piece in scene.sounds] == [
        (0.0, name, 5),
        (1.0, name, 5),
    ]
    assert scene.sizes == read_scene("studio", manifest).sizes
    assert scene.chunk_ids == {hashlib.sha256(chunk).hexdigest() for chunk in chunks} | {name}


def test_pages_are_chunks_that_the_slices_need_first() -> None:
    made_up = made_up_scene(120, static_bytes=1200, slice_bytes=90)
    scene = read_scene("bench", made_up.document)
    assert [len(page.chunks) for page in scene.pages] == [1] * 4
    assert [piece.chunks[0] for piece in scene.slices[63:65]] == [page.chunks[0] for page in scene.pages[:2]]
    assert {name: len(data) for name, data in scene.page_bytes.items()}.items() <= scene.sizes.items()
    listed = [name for names in scene.page_chunks.values() for name in names]
    assert listed == [bytes.fromhex(chunk.id) for chunk in made_up.manifest.chunks[12:]]


def test_the_whole_scene_is_the_same_without_pages() -> None:
    document = made_up_scene(120, static_bytes=1200, slice_bytes=90).document
    paged = read_scene("bench", document)
    whole = read_whole("bench", document)
    assert (whole.manifest, whole.pages, whole.page_bytes) == (document, (), {})
    assert [piece.chunks for piece in whole.slices] == [piece.chunks[1:] for piece in paged.slices]
    assert (whole.static, whole.end) == (paged.static, paged.end)


def test_a_long_scene_is_kept_without_its_manifest_and_a_short_one_with_it() -> None:
    long, short = (made_up_scene(slices, static_bytes=1200, slice_bytes=90).document for slices in (120, 6))
    assert (read_scene("long", long).document, read_scene("short", short).document) == (b"", short)


def test_the_memory_of_an_index_is_not_far_from_what_it_takes() -> None:
    document = made_up_scene(1200, static_bytes=1200, slice_bytes=90).document
    read_scene("bench", document)
    tracemalloc.start()
    scene = read_scene("bench", document)
    used = [scene.chunk_ids, scene.stored, scene.queue, [(piece.base, piece.refinements) for piece in scene.slices]]
    gc.collect()
    taken = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert used
    assert scene.memory == pytest.approx(taken, rel=0.3)


def test_pages_that_were_made_before_save_the_reading() -> None:
    made_up = made_up_scene(120, static_bytes=1200, slice_bytes=90)
    ready = read_scene("bench", made_up.document, made_up.pages)
    assert ready == read_scene("bench", made_up.document)
    assert read_scene("bench", b"not looked at", made_up.pages).slices == ready.slices


def test_scene_too_short_for_pages_has_its_slices_with_and_without_what_publishing_left() -> None:
    made_up = made_up_scene(1, static_bytes=1200, slice_bytes=90)
    assert not made_up.pages.pages
    assert read_scene("bench", made_up.document, made_up.pages) == read_scene("bench", made_up.document)
