"""The sources of an export: the float32 scene of a run, or an encoded scene."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback, silent
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.codec.format.scene_folder import MANIFEST
from hgs_core.interchange.baked_softness import with_baked_softness
from hgs_core.interchange.changes import Action, Change
from hgs_core.interchange.export_scene import export_scene, export_sequence
from hgs_core.interchange.formats import format_of
from hgs_core.interchange.ply.ply_sequence import is_sequence
from hgs_core.runs.encode_inputs import trained_scene
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["Source", "encoded_scene", "open_source"]


@dataclass(frozen=True)
class Source:
    """A scene with the facts of its files beside the splats."""

    scene: HybridScene[NDArray[np.float32]]
    cameras: tuple[Camera, ...]
    frame_rate: float  # frames per second of the capture
    photographed: bool = False  # `cameras` took the pictures that made the splats

    def export(
        self,
        path: Path,
        *,
        time: float | None = None,
        segment: int | None = None,
        version: int | None = None,
        frame_rate: float | None = None,
        frames: str | None = None,
        bake: bool = False,
        progress: ProgressCallback = silent,
    ) -> tuple[Change, ...]:
        """Write the scene to a file (see `export_scene`), or to a folder of frames (`export_sequence`), by default .ply
        files at the capture's rate; with `bake` the training pictures' softness is in them (`with_baked_softness`).

        Raises:
            InputError: an option is not for what is written, or cannot be.
        """
        if bake and not self.photographed:
            raise InputError("--bake", "needs the cameras of the pictures that made the splats", "leave it out")
        scene = with_baked_softness(self.scene, self.cameras) if bake else self.scene
        told = [] if bake else self._sharper()
        rate = self.frame_rate if frame_rate is None else frame_rate
        if is_sequence(path):
            for option, value in (("--time", time), ("--segment", segment), ("--spz-version", version)):
                if value is not None:
                    raise InputError(
                        option, "is not for a folder of frames", f"leave it out, or export {path.name}.ply"
                    )
            return (*export_sequence(scene, path, rate, progress, frames or "ply"), *told)
        if frames is not None:
            raise InputError("--frames", f"is for a folder of frames, not for {path.suffix}", "leave it out")
        if frame_rate is not None and (time is not None or not format_of(path, lambda one: True).sampled):
            raise InputError("--fps", f"is for frames and samples, and {path.name} has none", "leave it out")
        changes = export_scene(
            scene, path, cameras=self.cameras, time=time, segment=segment, version=version, frame_rate=rate
        )
        return (*changes, *told)

    def _sharper(self) -> list[Change]:
        """Return the magnification (docs/numerics.md) as a loss: no other format or viewer has it."""
        if not self.photographed:
            return []
        largest = max(self.cameras, key=lambda camera: camera.width * camera.height)
        size = f"{largest.width}x{largest.height}"
        reason = (
            f"other viewers draw thin splats as needles on screens finer than the training pictures' {size}; try --bake"
        )
        return [Change.whole(Action.LEFT_OUT, "softness on larger screens", reason)]


def open_source(path: Path) -> Source:
    """Open the float32 scene of a run, or decode the folder of an encoded scene.

    Raises:
        InputError: it is neither, or damaged.
    """
    folder = encoded_scene(path)
    if folder != path and not RunFolder(path).trained.is_file():
        raise _unfinished(path)
    manifest = load_manifest(folder)
    scene = decode_scene(path) if folder == path else trained_scene(RunFolder(path))
    return Source(scene, manifest.cameras, manifest.frame_rate, manifest.photographed)


def encoded_scene(path: Path) -> Path:
    """Return the folder of an encoded scene: `path` itself, or that of a run.

    Raises:
        InputError: it is neither.
    """
    if (path / MANIFEST).is_file():
        return path
    folder = RunFolder(path)
    if not folder.manifest.is_file():
        raise _unfinished(path)
    return folder.scene


def _unfinished(path: Path) -> InputError:
    return InputError(path, "is neither a finished run nor a scene folder", "give what hgs train has finished")
