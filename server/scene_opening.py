"""The beginning of a long scene's manifest, which is sent first: the first picture does not wait for the whole one."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from hgs_core.codec.format.growth import first_segments
from hgs_core.codec.format.manifest import Manifest

__all__ = ["opening"]

LONG = 256 << 10  # bytes of a manifest that is not sent at once: about 64 KiB compressed
SECONDS = 30.0  # of the scene, at least, that the beginning covers


def opening(document: Mapping[str, Any], manifest: Manifest, size: int) -> bytes | None:
    """Return the manifest of the beginning of a scene; None where the whole one is short, or grows itself.

    It is that of a scene that grows, and the whole one is its later version (docs/format.md, "Scenes that grow").

    Args:
        document: the whole manifest as plain JSON.
        manifest: the same, read.
        size: its bytes.
    """
    count = sum(segment.start < manifest.start + SECONDS for segment in manifest.segments)
    if size < LONG or manifest.live is not None or count == len(manifest.segments):
        return None
    first = first_segments(manifest, count)
    shown = first.to_json()
    parts = {name: shown[name] for name in ("segments", "slices", "end", "totals", "live")}
    if manifest.audio is not None:
        pieces = [piece for piece in document["audio"]["pieces"] if piece["start"] < first.end]
        parts["audio"] = {**document["audio"], "pieces": pieces}
    return json.dumps({**document, **parts}, separators=(",", ":")).encode()
