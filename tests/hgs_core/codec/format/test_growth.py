from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from hgs_core.codec.format.growth import (
    continues,
    first_segments,
    index_continues,
    replaces,
)
from hgs_core.codec.format.manifest_reading import read_manifest
from hgs_core.codec.format.paged_manifest import read_index
from hgs_core.codec.format.paging import paged
from tests.chunks import dynamic_chunk
from tests.growing import STATIC, growing_manifest

COMPLETE: dict[str, Any] = json.loads(
    (Path(__file__).resolve().parents[3] / "vectors" / "manifest.json").read_text(encoding="utf-8")
)


def version(count: int) -> dict[str, Any]:
    return first_segments(read_manifest(COMPLETE), count).to_json()


FIRST, LAST = version(1), version(2)


def test_first_segments_are_a_manifest_of_their_own() -> None:
    manifest = read_manifest(FIRST)
    assert (manifest.live, len(manifest.segments), {piece.segment for piece in manifest.slices}) == (1, 1, {0})
    assert manifest.end == COMPLETE["segments"][1]["start"]
    assert read_manifest(COMPLETE).to_json() == LAST


def test_a_complete_scene_continues_its_first_segment() -> None:
    assert continues(LAST, FIRST)


def test_only_later_versions_continue() -> None:
    assert not continues(FIRST, FIRST)
    assert not continues(FIRST, LAST)
    assert not continues(LAST | {"live": 1}, FIRST)
    assert continues(LAST | {"live": 2}, FIRST)


@pytest.mark.parametrize("name", ["extent", "static", "cameras", "antialiased", "metres_per_unit"])
def test_what_is_there_does_not_change(name: str) -> None:
    assert not continues(LAST | {name: "another"}, FIRST)


def test_sound_grows_with_the_scene() -> None:
    audio = json.loads((Path(__file__).resolve().parents[3] / "vectors" / "audio.json").read_text("utf-8"))["audio"]
    before, after = FIRST | {"audio": audio | {"pieces": audio["pieces"][:2]}}, LAST | {"audio": audio}
    assert continues(after, before)


def test_slices_that_are_there_do_not_change() -> None:
    later = copy.deepcopy(LAST)
    later["slices"][0]["chunks"] = []
    assert not continues(later, FIRST)


def test_damaged_manifests_are_no_later_versions() -> None:
    first, last = json.dumps(FIRST).encode(), json.dumps(LAST).encode()
    assert replaces(last, first)
    for damaged in (b"", b"[]", b"{}", b'{"live": "1"}', b"\xff"):
        assert not replaces(damaged, first)
        assert not replaces(last, damaged)


CHUNKS = [dynamic_chunk(b"%d" % k, (float(k), k + 1.0)) for k in range(7)]


def many_segments(count: int) -> dict[str, Any]:
    """Return the manifest of so many segments with a chunk in each."""
    return growing_manifest(STATIC, CHUNKS[:count], live=count).to_json()


def in_pages(document: dict[str, Any]) -> tuple[dict[str, Any], list[bytes]]:
    made = paged(read_manifest(document), document, full=3)
    return read_index(made.index), list(made.pages.values())


@pytest.mark.parametrize("before", [1, 2, 3, 4, 6])
@pytest.mark.parametrize("after", [1, 3, 4, 5, 7])
@pytest.mark.parametrize("change", [{}, {"extent": 9.0}, {"title": "Another"}])
def test_indexes_and_two_pages_tell_what_the_manifests_tell(before: int, after: int, change: dict[str, Any]) -> None:
    earlier, later = many_segments(before), many_segments(after) | change
    (first, pages), (second, others) = in_pages(earlier), in_pages(later)
    if len(others) >= len(pages):
        told = index_continues(second, first, others[len(pages) - 1], pages[-1])
        assert told == continues(later, earlier)


@pytest.mark.parametrize("place", [0, 4])
def test_another_slice_in_a_page_is_another_scene(place: int) -> None:
    """In a page that is full, and in the last one of the earlier version."""
    earlier, later = many_segments(5), many_segments(7)
    (first, pages), (_, others) = in_pages(earlier), in_pages(later)
    assert index_continues(in_pages(later)[0], first, others[1], pages[1])
    later["slices"][place]["chunks"][0]["bytes"] += 1
    later["totals"]["bytes_dynamic"] += 1
    second, others = in_pages(later)
    assert not continues(later, earlier)
    assert not index_continues(second, first, others[1], pages[1])
