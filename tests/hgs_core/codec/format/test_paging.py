from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.codec.format.growth import first_segments
from hgs_core.codec.format.manifest import Manifest
from hgs_core.codec.format.manifest_reading import read_manifest
from hgs_core.codec.format.paged_manifest import read_index
from hgs_core.codec.format.pages import read_page
from hgs_core.codec.format.paging import PagedScene, paged

VECTORS: dict[str, Any] = json.loads((Path(__file__).parents[3] / "vectors" / "pages.json").read_text(encoding="utf-8"))
WHOLE = read_manifest(VECTORS["manifest"])


def pages(manifest: Manifest, full: int = 16, short: int = 0) -> PagedScene:
    return paged(manifest, manifest.to_json(), full, short)


def test_pages_hold_whole_segments_and_all_that_the_manifest_lists() -> None:
    first, second = (read_page(data) for data in pages(WHOLE).pages.values())
    assert first.segments + second.segments == WHOLE.segments
    assert first.slices == WHOLE.slices[:8]
    assert [dataclasses.replace(piece, segment=2) for piece in second.slices] == list(WHOLE.slices[8:])
    assert WHOLE.audio is not None
    assert first.pieces + second.pieces == WHOLE.audio.pieces
    assert [piece.start for piece in second.pieces] == [4.5, 5.5]


def test_index_says_where_pages_begin_and_how_much_room_the_slices_need() -> None:
    made = pages(WHOLE)
    index = read_index(made.index)
    rows = [(name, len(data)) for name, data in made.pages.items()]
    assert [(row["id"], row["bytes"]) for row in index["pages"]] == rows
    assert [(row["start"], row["segments"]) for row in index["pages"]] == [(0.0, 2), (4.0, 1)]
    # Chunks of 60 and 30 bytes have 6 and 3 splats; a slice needs those of two slices before it, and the next one's.
    assert index["room"] == {"chunks": 24, "most_chunks": 6, "most_splats": 30}
    assert "slices" not in index["manifest"]
    assert "pieces" not in index["manifest"]["audio"]


def test_short_scene_has_no_pages_unless_it_grows() -> None:
    made = pages(WHOLE, short=24)
    assert (made.pages, read_index(made.index)) == ({}, WHOLE.to_json())
    assert len(pages(first_segments(WHOLE, 1), short=24).pages) == 1
    assert len(pages(WHOLE, short=23).pages) == 2


def test_full_pages_of_a_scene_stay_when_it_grows() -> None:
    before, after = (list(pages(manifest, 8).pages) for manifest in (first_segments(WHOLE, 2), WHOLE))
    assert before == after[:2]
    assert (
        next(iter(pages(first_segments(WHOLE, 1)).pages)) not in pages(WHOLE).pages
    )  # it had room for another segment


def test_of_sound_beyond_the_edge_of_a_scene_that_grows_nothing_is_listed() -> None:
    (page,) = (read_page(data) for data in pages(first_segments(WHOLE, 1)).pages.values())
    assert [piece.start for piece in page.pieces] == [-0.5, 0.5, 1.5]


def test_boxes_are_never_smaller_than_they_were() -> None:
    box = ((0.1, -0.1, 1e-50), (0.3, 0.7, 1.0))  # few are numbers of 32 bits
    pieces = tuple(
        dataclasses.replace(piece, chunks=tuple(dataclasses.replace(chunk, box=box) for chunk in piece.chunks))
        for piece in WHOLE.slices
    )
    made = pages(dataclasses.replace(WHOLE, slices=pieces))
    low, high = read_page(next(iter(made.pages.values()))).slices[0].chunks[0].box
    assert np.all(np.array(low) <= box[0])
    assert np.all(np.array(high) >= box[1])
    assert np.allclose((low, high), box, atol=1e-7)
    assert high[2] == 1.0


def test_slices_out_of_the_order_of_their_segments_are_left_as_they_are() -> None:
    moved = (*WHOLE.slices[4:8], *WHOLE.slices[:4])
    assert pages(dataclasses.replace(WHOLE, slices=moved)).pages == {}


def test_packed_pages_are_read_for_their_own_manifest_alone() -> None:
    made = pages(WHOLE)
    packed = made.packed(b"manifest")
    assert PagedScene.unpacked(packed, b"manifest") == made
    assert PagedScene.unpacked(packed, b"another") is None
    for damaged in (b"", packed[:35], packed[:-1], packed + b"!", packed[:32] + b"\xff\xff\xff\xff" + packed[36:]):
        assert PagedScene.unpacked(damaged, b"manifest") is None
