"""The size of a training: the numbers of its capture and config that its cost grows with; free of torch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hgs_core.capture.capture import Capture
from hgs_core.capture.held_out import FEWEST_CAMERAS
from hgs_core.runs.run_config import RunConfig
from hgs_core.train.segment_cuts import cut_into_segments

__all__ = ["SegmentSize", "TrainingSize"]


@dataclass(frozen=True)
class SegmentSize:
    """One segment of the capture."""

    frames: int
    static: int  # splats that the budget allows in the end
    dynamic: int


@dataclass(frozen=True)
class TrainingSize:
    """The size of a training; pixels are means over the cameras."""

    cameras: int
    training_cameras: int
    frames: int
    filmed_pixels: float  # pixels of a picture before its reduction
    pixels: float  # pixels of a picture as trained
    straightened: float  # share of the cameras with a lens that bends
    moments: int  # moments that points are taken from
    masked: bool  # whether the capture gives masks
    aligned: bool  # whether it is known when its videos began
    first_static: int  # points to start with
    first_dynamic: int
    segments: tuple[SegmentSize, ...]
    iterations: int  # iterations of a segment
    coarse_until: float  # share of them at half resolution
    moving_steps: float  # further steps in an iteration
    by_segment: bool  # whether each segment is encoded by itself

    @classmethod
    def of(cls, capture: Capture, config: RunConfig) -> TrainingSize:
        """Return the size of a capture's training; the capture is open as the config reduces it."""
        training = config.capture.training_cameras(capture)
        shown = np.array([camera.width * camera.height for camera in capture.cameras], float)
        reductions = config.capture.reductions
        factors = [reductions.get(camera.name, config.capture.downscale) for camera in capture.cameras]
        segments = cut_into_segments(capture.times, config.train.segment_frames)
        every = capture.frames_in(config.points.interval)
        budgets = [(one.frames, *config.train.splat_budgets(one.seconds)) for one in segments]
        return cls(
            len(capture.cameras),
            len(training),
            len(capture.times),
            float((shown * np.square(factors)).mean()),
            float(shown[list(training)].mean()),
            float(np.mean(capture.straightened)),
            len({frame for one in segments for frame in one.sampled(every)}),
            capture.mask_file(training[0], 0) is not None,
            not capture.unaligned or config.capture.sync == "none",
            config.points.static,
            config.points.dynamic_in(capture.seconds),
            tuple(SegmentSize(*one) for one in budgets),
            config.train.iterations,
            config.train.coarse_until,
            config.train.moving_steps,
            config.encode.by_segment,
        )

    @classmethod
    def announced(cls, cameras: int, frames: int, seconds: float, pixels: int, config: RunConfig) -> TrainingSize:
        """Return the size of a training of a capture that is not open: `seconds` are those of all frames.

        Its pictures have so many pixels, and no lens bends.
        """
        last = seconds * (frames - 1) / frames
        every = int(np.clip(round(config.points.interval / last * (frames - 1)), 1, frames)) if frames > 1 else 1
        segments = cut_into_segments(np.linspace(0, last, frames), config.train.segment_frames)
        return cls(
            cameras,
            cameras - (cameras >= FEWEST_CAMERAS),
            frames,
            pixels,
            pixels / config.capture.downscale**2,
            0.0,
            len({frame for one in segments for frame in one.sampled(every)}),
            False,
            False,
            config.points.static,
            config.points.dynamic_in(last),
            tuple(SegmentSize(one.frames, *config.train.splat_budgets(one.seconds)) for one in segments),
            config.train.iterations,
            config.train.coarse_until,
            config.train.moving_steps,
            config.encode.by_segment,
        )
