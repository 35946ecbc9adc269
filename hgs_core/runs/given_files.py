"""The files that a run uses instead of its capture's own. Light: the API process and the command line know them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hgs_core.runs.sound_choice import OWN_SOUND

__all__ = ["GivenFiles"]


@dataclass(frozen=True)
class GivenFiles:
    """Masks, depth maps, a mesh and a sound that replace those of a capture."""

    masks: Path | None = None  # a folder of masks
    depth: Path | None = None  # a folder of depth maps
    mesh: Path | None = None  # a file of triangles
    audio: str = OWN_SOUND  # the sound: of the capture, "camera:" and a name, "none", or a file

    def resolved(self) -> GivenFiles:
        """Return the files by their absolute paths; the sound stays as it is."""
        masks, depth, mesh = (path and path.resolve() for path in (self.masks, self.depth, self.mesh))
        return GivenFiles(masks, depth, mesh, self.audio)

    @property
    def places(self) -> tuple[Path, ...]:
        """Absolute paths of the files and folders; a sound may be a word."""
        return tuple(path for path in map(Path, self.to_json().values()) if path.is_absolute())

    def to_json(self) -> dict[str, str]:
        """Return the paths by name, the capture's own left out."""
        return {name: str(value) for name, value in vars(self).items() if value not in (None, OWN_SOUND)}

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> GivenFiles:
        """Return the files that `to_json` wrote, perhaps among other things."""
        masks, depth, mesh = (Path(value[name]) if name in value else None for name in ("masks", "depth", "mesh"))
        return cls(masks, depth, mesh, str(value.get("audio", OWN_SOUND)))
