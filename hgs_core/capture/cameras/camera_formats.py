"""The formats of calibrations, and the files of a capture that are in one of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from hgs_core.capture.cameras.calibration_toml import CALIBRATION_TOML
from hgs_core.capture.cameras.colmap import COLMAP
from hgs_core.capture.cameras.easymocap import EASYMOCAP
from hgs_core.capture.cameras.immersive import IMMERSIVE
from hgs_core.capture.cameras.llff import LLFF
from hgs_core.capture.cameras.opencv_files import OPENCV_FILES
from hgs_core.capture.cameras.panoptic import PANOPTIC_SPORTS
from hgs_core.capture.cameras.rig import CameraFormat
from hgs_core.capture.cameras.transforms import NERFSTUDIO

__all__ = ["CAMERA_FORMATS", "calibration"]

CAMERA_FORMATS: tuple[CameraFormat, ...] = (
    PANOPTIC_SPORTS,
    LLFF,
    NERFSTUDIO,
    IMMERSIVE,
    EASYMOCAP,
    CALIBRATION_TOML,
    COLMAP,
    OPENCV_FILES,
)
"""In the order in which a folder is tried; a new format is a module and an entry."""


def calibration(capture: Path) -> Iterator[tuple[CameraFormat, Path]]:
    """Yield the formats of the cameras in a folder and their files, the one to be used first."""
    for camera_format in CAMERA_FORMATS:
        if (file := camera_format.find(capture)) is not None:
            yield camera_format, file
