"""The inputs of a run's training from its folder."""

from __future__ import annotations

from hgs_core.capture.capture import Capture
from hgs_core.decompose.masks import MotionMasks
from hgs_core.points.backdrop import load_backdrop
from hgs_core.points.kept_points import BACKDROP, segment_points
from hgs_core.points.near_plane import load_near_planes
from hgs_core.points.point_cloud import PointCloud
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.train.capture_training import TrainingInputs
from hgs_core.train.segment_cuts import CaptureSegment, cut_into_segments

__all__ = ["masks_of_run", "segment_starts", "training_inputs"]


def segment_starts(capture: Capture, config: RunConfig) -> list[int]:
    """Return the first frame of each segment."""
    return [segment.first for segment in cut_into_segments(capture.times, config.train.segment_frames)]


def masks_of_run(folder: RunFolder, capture: Capture, config: RunConfig) -> MotionMasks:
    """Return the masks of an initialised run; a file of them is opened when a frame of its segment is asked for."""
    cameras = config.capture.training_cameras(capture)
    return MotionMasks.load(folder.masks, capture, cameras, segment_starts(capture, config))


def training_inputs(folder: RunFolder, capture: Capture, config: RunConfig) -> TrainingInputs:
    """Return the inputs of an initialised run's training; a segment's points are read when they are asked for."""
    cameras = load_near_planes(folder.near_planes, capture.cameras)
    starts = segment_starts(capture, config)

    def points(segment: CaptureSegment) -> PointCloud:
        return segment.points(segment_points(folder.points, starts.index(segment.first)))

    return TrainingInputs(
        capture,
        {i: cameras[i] for i in config.capture.training_cameras(capture)},
        config.train,
        config.seed,
        points,
        capture.frames_in(config.points.interval),
        masks_of_run(folder, capture, config),
        load_backdrop(folder.points / BACKDROP),
    )
