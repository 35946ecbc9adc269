"""What can be exported: the float32 scene of a run, or an encoded scene."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.errors import InputError
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.codec.format.folder import MANIFEST
from hgs_core.interchange.changes import Change
from hgs_core.interchange.exporting import export_scene
from hgs_core.runs.encode_inputs import trained_scene
from hgs_core.runs.folder import RunFolder
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["Source", "open_source"]


@dataclass(frozen=True)
class Source:
    """A scene with what its files say beside the splats."""

    scene: HybridScene[NDArray[np.float32]]
    cameras: tuple[Camera, ...]

    def export(
        self, path: Path, *, time: float | None = None, segment: int | None = None, version: int | None = None
    ) -> tuple[Change, ...]:
        """Write the scene to a file; see `export_scene`."""
        return export_scene(self.scene, path, cameras=self.cameras, time=time, segment=segment, version=version)


def open_source(path: Path) -> Source:
    """Open a run, whose float32 scene is taken, or the folder of an encoded scene, which is decoded.

    Raises:
        InputError: it is neither, or damaged.
    """
    if (path / MANIFEST).is_file():
        manifest, scene = load_manifest(path), decode_scene(path)
    else:
        folder = RunFolder(path)
        if not folder.trained.is_file() or not folder.manifest.is_file():
            raise InputError(path, "is neither a finished run nor a scene folder", "give what hgs train has finished")
        manifest, scene = load_manifest(folder.manifest), trained_scene(folder)
    return Source(scene, manifest.cameras)
