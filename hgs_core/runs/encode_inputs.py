"""The inputs of encoding from a run on disk: the views of its capture, and the final states of its trainings."""

from __future__ import annotations

import dataclasses

import torch

from hgs_core.base.arrays import Floats
from hgs_core.base.errors import InputError
from hgs_core.fit.encoding_views import EncodeViews, views_around
from hgs_core.points.near_plane import load_near_planes
from hgs_core.runs.kept_views import KeptViews
from hgs_core.runs.run_folder import RunFolder, RunSpec
from hgs_core.runs.training_inputs import masks_of_run
from hgs_core.scene.files import load_scene
from hgs_core.scene.splats import HybridScene
from hgs_core.train.checkpoint import TrainState, load_state
from hgs_core.train.targets import target_picture

__all__ = ["trained_scene", "training_states", "views_of_run"]


def trained_scene(folder: RunFolder) -> HybridScene[Floats]:
    """Return the scene that a run trained, to be drawn as its config says: files of older runs do not say it.

    Raises:
        InputError: the run is not trained yet, or a file of it is damaged.
    """
    return dataclasses.replace(load_scene(folder.trained), antialiased=folder.read_spec().config.train.antialiased)


def views_of_run(folder: RunFolder, spec: RunSpec, scene: HybridScene[Floats]) -> EncodeViews:
    """Return the views of a run: its capture's, those an edited one took over, or those around an imported scene.

    Raises:
        InputError: the capture is gone or has changed, the run's near planes are missing, or its masks are unreadable.
    """
    if spec.edited:
        return KeptViews.load(folder.views).of(scene)
    if spec.without_capture:
        return views_around(scene, spec.capture.stem)
    capture = folder.open_capture(spec)
    cameras = load_near_planes(folder.near_planes, capture.cameras)
    trained = {i: cameras[i] for i in spec.config.capture.training_cameras(capture)}
    masks = masks_of_run(folder, capture, spec.config) if folder.masks.is_dir() else None
    return EncodeViews(
        capture.name,
        cameras,
        trained,
        capture.times,
        lambda i, frame: target_picture(capture, i, frame, cameras[i]),
        capture,
        None if masks is None else lambda i, frame: torch.from_numpy(masks.mask(i, frame)),
        photographed=True,
    )


def training_states(run: RunFolder, scene: HybridScene[Floats]) -> tuple[TrainState, ...]:
    """Return the states in which the trainings of a run's segments ended; empty if a segment has no
    checkpoint of this scene.
    """
    try:
        states = tuple(load_state(run.checkpoint(number)) for number in range(len(scene.segments)))
    except (FileNotFoundError, InputError):  # trained already, without a readable checkpoint
        return ()
    fits = len(states[0].static) == len(scene.static) and all(
        len(state.dynamic) == len(segment.dynamic) for state, segment in zip(states, scene.segments, strict=True)
    )
    return states if fits else ()
