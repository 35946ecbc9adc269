"""The description of a published scene: the facts of its manifest that lists show, in a small file beside it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

__all__ = ["DESCRIPTION", "SceneDescription"]

DESCRIPTION = "description.json"


@dataclass(frozen=True)
class SceneDescription:
    """The facts of a manifest that a list of scenes shows."""

    title: str
    start: float  # seconds of the capture's clock
    end: float  # seconds
    bytes_total: int  # chunks of splats and of sound, and the manifest
    splats_static: int
    splats_dynamic: int
    live: bool  # whether the scene still grows

    @classmethod
    def of(cls, manifest: Mapping[str, Any], size: int) -> Self:
        """Describe a manifest of `size` bytes, given as plain JSON that was checked before."""
        totals = manifest["totals"]
        sounds = {piece["id"]: piece["bytes"] for piece in manifest.get("audio", {}).get("pieces", ())}
        return cls(
            title=manifest["title"],
            start=manifest["start"],
            end=manifest["end"],
            bytes_total=totals["bytes_static"] + totals["bytes_dynamic"] + sum(sounds.values()) + size,
            splats_static=totals["splats_static"],
            splats_dynamic=totals["splats_dynamic"],
            live="live" in manifest,
        )

    def packed(self, tag: str) -> bytes:
        """Return the file's bytes, for the manifest that the store gave this entity tag."""
        return json.dumps({"manifest": tag, **asdict(self)}, indent=1).encode() + b"\n"

    @classmethod
    def unpacked(cls, data: bytes, tag: str) -> Self | None:
        """Undo `packed`; None if that was of another manifest, or is damaged."""
        try:
            fields = json.loads(data)
            return cls(**fields) if fields.pop("manifest") == tag else None
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            return None
