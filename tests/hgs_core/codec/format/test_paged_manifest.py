from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.format.manifest import SegmentEntry
from hgs_core.codec.format.paged_manifest import PagedManifest, read_index

VECTORS: dict[str, Any] = json.loads((Path(__file__).parents[3] / "vectors" / "pages.json").read_text(encoding="utf-8"))
INDEX = read_index(bytes.fromhex(VECTORS["whole"]["index"]))
PAGES = {name: bytes.fromhex(data) for name, data in VECTORS["whole"]["pages"].items()}
FIRST, SECOND = PAGES


def beginning() -> PagedManifest:
    paged = PagedManifest(read_index(bytes.fromhex(VECTORS["beginning"]["index"])))
    ((name, data),) = VECTORS["beginning"]["pages"].items()
    paged.add(name, bytes.fromhex(data))
    return paged


def test_all_pages_together_are_the_manifest_in_any_order() -> None:
    paged = PagedManifest(INDEX)
    for name in (SECOND, FIRST):
        assert paged.lacks(name)
        paged.add(name, PAGES[name])
        assert not paged.lacks(name)
    assert paged.manifest.to_json() == VECTORS["manifest"]


def test_a_page_that_comes_makes_nothing_anew_but_its_own_part() -> None:
    """An hour has 113 pages: making all of them anew with each took most of the reading."""
    paged = PagedManifest(INDEX)
    paged.add(SECOND, PAGES[SECOND])
    before = paged.manifest
    paged.add(FIRST, PAGES[FIRST])
    after = paged.manifest
    assert after is not before
    assert [a is b for a, b in zip(before.slices[-4:], after.slices[-4:], strict=True)] == [True] * 4
    assert paged.manifest is after


def test_in_place_of_a_page_is_a_slice_that_needs_it() -> None:
    paged = PagedManifest(INDEX)
    paged.add(SECOND, PAGES[SECOND])
    first, *others = paged.manifest.slices
    assert (first.segment, first.start, first.end) == (0, 0.0, 4.0)
    assert [(chunk.id, chunk.bytes, chunk.splats) for chunk in first.chunks] == [(FIRST, len(PAGES[FIRST]), 0)]
    assert [piece.segment for piece in others] == [2] * 4  # equal to the whole manifest
    assert paged.manifest.segments[2] == SegmentEntry(4.0, 6.0)
    assert paged.manifest.audio is not None
    assert [piece.start for piece in paged.manifest.audio.pieces] == [4.5, 5.5]


def test_earlier_version_of_a_page_stands_for_the_beginning_of_the_later_one() -> None:
    paged = beginning()
    known = paged.manifest.slices
    later = PagedManifest(INDEX)
    assert paged.continued_by(later)
    paged.become(later)
    assert paged.lacks(FIRST)
    assert paged.manifest.slices[: len(known)] == known
    awaited = paged.manifest.slices[len(known)]
    assert (awaited.segment, awaited.start, awaited.end, awaited.chunks[0].id) == (1, 2.0, 4.0, FIRST)
    for name, data in PAGES.items():
        paged.add(name, data)
    assert paged.manifest.to_json() == VECTORS["manifest"]


@pytest.mark.parametrize("change", [{"live": 1}, {"end": 1.0}, {"static": []}])
def test_only_a_later_version_of_the_scene_continues_it(change: dict[str, Any]) -> None:
    header = {**INDEX["manifest"], **change}
    if "static" in change:
        header["totals"] = {**header["totals"], "splats_static": 0, "bytes_static": 0}
    other = PagedManifest({**INDEX, "manifest": header})
    assert not beginning().continued_by(other)
    assert not PagedManifest(INDEX).continued_by(other)  # INDEX is complete


def test_pages_list_what_they_name_but_the_last_one_of_a_scene_that_grows() -> None:
    paged = PagedManifest(INDEX)
    paged.add(FIRST, PAGES[FIRST])
    listed = paged.listed()
    assert list(listed) == [FIRST]
    manifest = VECTORS["manifest"]
    chunks = [chunk["id"] for piece in manifest["slices"][:8] for chunk in piece["chunks"]]
    assert listed[FIRST] == chunks + [piece["id"] for piece in manifest["audio"]["pieces"][:5]]
    assert beginning().listed() == {}


def test_index_of_a_short_scene_is_its_manifest() -> None:
    paged = PagedManifest(read_index(gzip.compress(json.dumps(VECTORS["manifest"]).encode())))
    assert (paged.pages, paged.manifest.to_json()) == ((), VECTORS["manifest"])


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"format": "hgs"}, "format"),
        ({"version": 2}, "version"),
        ({"pages": []}, "pages"),
        ({"pages": [{"id": "x"}]}, r"pages\[0\].id"),
        ({"manifest": {}}, "manifest"),
    ],
)
def test_wrong_index_is_refused_with_the_field(change: dict[str, Any], field: str) -> None:
    with pytest.raises(InputError, match=f"^the index.*{field}"):
        PagedManifest({**INDEX, **change}, "the index")


@pytest.mark.parametrize("data", [b"", b"{}", gzip.compress(b"{", mtime=0), gzip.compress(b"[]", mtime=0)])
def test_what_is_no_index_is_refused(data: bytes) -> None:
    with pytest.raises(InputError, match=r"^an index"):
        read_index(data, "an index")


def test_page_that_is_not_what_the_index_says_is_refused() -> None:
    rows = [dict(row, segments=3) for row in INDEX["pages"]]
    with pytest.raises(InputError, match="has 2 segments, the index says 3"):
        PagedManifest({**INDEX, "pages": rows}).add(FIRST, PAGES[FIRST])
