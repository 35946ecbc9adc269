"""The growth of scenes: whether one is a later version of another."""

from __future__ import annotations

import json
from functools import lru_cache

from hgs_core.codec.format.growth import continues, index_continues
from hgs_core.codec.format.paged_manifest import read_index
from server.scenes.scene_index import SceneIndex

__all__ = ["is_later"]

_KEPT = 16  # cached results: all viewers of a scene request the same ones


def is_later(scene: SceneIndex, earlier: SceneIndex) -> bool:
    """Return whether a scene is a later version of a growing one.

    Scenes in pages are compared by their indices and two pages: 0.1 s faster than by the manifests of an hour.
    """
    place = len(earlier.pages) - 1
    if not 0 <= place < len(scene.pages):
        if not scene.document or not earlier.document:  # a long scene never becomes a short one
            return False
        return _manifest_continues(scene.document, earlier.document)
    return _index_continues(scene.manifest, earlier.manifest, _page(scene, place), _page(earlier, place))


def _page(scene: SceneIndex, place: int) -> bytes:
    return scene.page_bytes[scene.pages[place].chunks[0].id]


@lru_cache(maxsize=_KEPT)
def _index_continues(later: bytes, earlier: bytes, page: bytes, last: bytes) -> bool:
    return index_continues(read_index(later), read_index(earlier), page, last)


@lru_cache(maxsize=_KEPT)
def _manifest_continues(later: bytes, earlier: bytes) -> bool:
    return continues(json.loads(later), json.loads(earlier))
