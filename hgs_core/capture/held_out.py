"""Which camera is kept to score a scene with, where nobody says."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from hgs_core.capture.capture_config import CaptureConfig
from hgs_core.scene.camera import Camera

__all__ = ["AUTO", "FEWEST_CAMERAS", "with_held_out"]

AUTO = ("auto",)
"""The `hold_out` that stands for the camera that `with_held_out` chooses."""

FEWEST_CAMERAS = 6
"""Cameras of a capture that can spare one."""


def with_held_out(config: CaptureConfig, cameras: Sequence[Camera]) -> CaptureConfig:
    """Return the config with cameras for `AUTO`: of six or more the one in the middle of the rig, of fewer none.

    In the middle is the camera that differs least from all others in view direction and place: those around it see what
    it sees, and without it no side of the scene goes unseen.
    """
    if config.hold_out != AUTO:
        return config
    if len(cameras) < FEWEST_CAMERAS:
        return dataclasses.replace(config, hold_out=())
    directions = np.array([camera.world_to_camera[2, :3] for camera in cameras])
    places = np.array([camera.position for camera in cameras])
    extent = float(np.linalg.norm(places - places.mean(axis=0), axis=1).max()) or 1.0
    gaps = np.linalg.norm(places[:, None] - places, axis=2) / extent
    unlike = np.arccos(np.clip(directions @ directions.T, -1.0, 1.0)) + gaps
    middle = int(unlike.sum(axis=1).round(9).argmin())  # rounded, so that the first of equals wins
    return dataclasses.replace(config, hold_out=(cameras[middle].name,))
