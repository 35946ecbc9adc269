from __future__ import annotations

import json
from typing import Any

import pytest

from hgs_core.codec.format.growth import first_segments
from server.bench.bench_scene import made_up_scene
from server.scenes.scene_growth import is_later
from server.scenes.scene_index import SceneIndex, read_scene

WHOLE = made_up_scene(240, static_bytes=1200, slice_bytes=90).manifest  # 120 segments, 960 chunks that move, 8 pages


def version(segments: int, **changes: Any) -> SceneIndex:
    """Return the scene when it has the first so many segments, with other fields in its manifest."""
    document = first_segments(WHOLE, segments).to_json() | changes
    return read_scene("bench", json.dumps(document).encode())


FIRST, SECOND, LAST = version(60), version(61), version(120)


def test_later_versions_are_known_by_their_pages_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(LAST.pages) > len(FIRST.pages) > 1
    monkeypatch.setattr("server.scenes.scene_growth._manifest_continues", None)
    assert is_later(SECOND, FIRST)
    assert is_later(LAST, SECOND)
    assert not is_later(FIRST, SECOND)
    assert not is_later(FIRST, FIRST)
    assert not is_later(version(1), LAST)
    assert not is_later(version(61, extent=5.0), FIRST)


def test_a_scene_that_has_no_pages_at_last_is_known_by_its_manifest() -> None:
    short = made_up_scene(6, static_bytes=1200, slice_bytes=90).manifest
    one, two, three = (
        read_scene("bench", json.dumps(first_segments(short, count).to_json()).encode()) for count in (1, 2, 3)
    )
    assert [bool(scene.pages) for scene in (one, two, three)] == [True, True, False]
    assert is_later(two, one)
    assert is_later(three, two)
    assert not is_later(two, three)
