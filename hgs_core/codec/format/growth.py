"""How the manifest of a scene that grows follows from the one before (docs/format.md, "Scenes that grow")."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from typing import Any

from hgs_core.codec.format.manifest import Manifest
from hgs_core.codec.format.pages import read_page

__all__ = ["continues", "first_segments", "index_continues", "replaces"]

Document = Mapping[str, Any]

_APPENDED = ("segments", "slices")
_FREE = frozenset({*_APPENDED, "version", "title", "end", "totals", "thumbnail", "training", "live", "audio"})


def continues(later: Document, earlier: Document) -> bool:
    """Return whether a manifest, as plain JSON, is a later version of a scene that grows than another one."""
    before, after = earlier.get("live"), later.get("live")
    if before is None or (after is not None and after <= before):
        return False
    if later["end"] < earlier["end"] or later["version"] < earlier["version"]:
        return False
    if any(later[name][: len(earlier[name])] != earlier[name] for name in _APPENDED):
        return False
    return all(later.get(name) == earlier.get(name) for name in (later.keys() | earlier.keys()) - _FREE)


def index_continues(later: Document, earlier: Document, page: bytes, last: bytes) -> bool:
    """Return whether a manifest in pages `continues` another, from their indexes, as plain JSON, and two pages alone.

    `last` is the last page of the earlier one, and `page` what the later one has in its place.

    Raises:
        InputError: a page is damaged.
    """
    full = len(earlier["pages"]) - 1  # pages, which no growth changes
    if later["pages"][:full] != earlier["pages"][:full]:
        return False
    elsewhere: Document = {name: [] for name in _APPENDED}
    if not continues({**later["manifest"], **elsewhere}, {**earlier["manifest"], **elsewhere}):
        return False
    before, after = read_page(last), read_page(page)
    segments, slices = len(before.segments), len(before.slices)
    return after.segments[:segments] == before.segments and after.slices[:slices] == before.slices


def replaces(later: bytes, earlier: bytes) -> bool:
    """Return whether the bytes of a manifest are a later version of those of another one; damaged ones are none."""
    try:
        return continues(json.loads(later), json.loads(earlier))
    except (ValueError, RecursionError, AttributeError, TypeError, KeyError):
        return False


def first_segments(manifest: Manifest, count: int) -> Manifest:
    """Return the manifest of a scene's first `count` segments, at least one, as if it had no others yet."""
    segments = manifest.segments[:count]
    rest = len(manifest.segments) > count
    return dataclasses.replace(
        manifest,
        end=manifest.segments[count].start if rest else manifest.end,
        segments=segments,
        slices=tuple(piece for piece in manifest.slices if piece.segment < count),
        live=count if rest else manifest.live,
    )
