"""A file of splats as a run: what `hgs import` makes, and encode, eval and publish go on with."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback
from hgs_core.interchange.formats import Imported, import_scene
from hgs_core.points.point_cloud import PointCloud
from hgs_core.runs.folder import RunFolder, RunSpec
from hgs_core.runs.stages import create_run, encode
from hgs_core.scene.files import save_scene
from hgs_core.scene.splats import HybridScene
from hgs_core.train.config import TrainConfig

__all__ = ["import_run"]


def import_run(
    file: Path,
    run: Path,
    progress: ProgressCallback,
    *,
    duration: float,
    capture: Path | None,
    config: TrainConfig,
    antialiased: bool,
) -> tuple[str, ...]:
    """Make a run folder of a file of splats and encode it; returns notes on what was left out.

    `duration` is how long a 4D file lasts, seconds. With a `capture`, the pictures the splats were made of, the loss of
    encoding is measured on its cameras that `config` does not hold out, and the run can be evaluated; without, views
    are made up around the splats. `antialiased` says that the splats are to be drawn so, if the file cannot.

    Raises:
        InputError: the file, the capture or the config are unusable, or `run` holds something else.
    """
    if not duration > 0:
        raise InputError("--duration", f"{duration} is not positive", "give the seconds that the scene lasts")
    imported = import_scene(file, duration)
    config = dataclasses.replace(config, antialiased=imported.antialiased or antialiased)
    if capture is None:
        if config.hold_out:
            raise InputError("--hold-out", "needs the capture's cameras", "name the capture with --capture")
        fingerprint = hashlib.sha256(file.read_bytes()).hexdigest()
        RunFolder(run).write_spec(RunSpec(file.resolve(), fingerprint, config, without_capture=True))
    else:
        create_run(run, capture, config)
    folder = RunFolder(run)
    with folder.exclusive():
        if not folder.train_summary.exists():
            _write(folder, file, imported)
        encode(run, progress)
    return imported.notes


def _write(folder: RunFolder, file: Path, imported: Imported) -> None:
    _points(imported.scene).save(folder.points)
    save_scene(folder.trained, imported.scene)
    write_bytes(folder.train_summary, json.dumps({"seconds": 0.0, "imported": file.name}, indent=1).encode())


def _points(scene: HybridScene[NDArray[np.float32]]) -> PointCloud:
    """Return the splats' centres as points: near planes are measured on them."""
    xyz = np.concatenate([scene.static.means, *(part.dynamic.motion[:, 0] for part in scene.segments)])
    moving = np.arange(len(xyz)) >= len(scene.static)
    sizes = [scene.static.log_scales, *(part.dynamic.log_scales for part in scene.segments)]
    spacing = np.maximum(np.exp(np.concatenate(sizes)).mean(axis=1), 1e-9)
    rgb = np.concatenate([scene.static.rgb, *(part.dynamic.rgb for part in scene.segments)])
    return PointCloud.at_rest(
        xyz, np.clip(rgb, 0, 1), np.full(len(xyz), scene.start, np.float32), moving.astype(np.float32),
        spacing.astype(np.float32),
    )  # fmt: skip
