"""The size of a training: the numbers of its capture and config that its cost grows with; free of torch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.capture.capture import Capture, frames_in
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
        return cls._with_times(
            capture.times,
            config,
            cameras=len(capture.cameras),
            training_cameras=len(training),
            filmed_pixels=float((shown * np.square(factors)).mean()),
            pixels=float(shown[list(training)].mean()),
            straightened=float(np.mean(capture.straightened)),
            masked=capture.mask_file(training[0], 0) is not None,
            aligned=not capture.unaligned or config.capture.sync == "none",
        )

    @classmethod
    def announced(cls, cameras: int, frames: int, seconds: float, pixels: int, config: RunConfig) -> TrainingSize:
        """Return the size of a training of a capture that is not open: `seconds` are those of all frames.

        Its pictures have so many pixels, and no lens bends.
        """
        return cls._with_times(
            np.linspace(0, seconds * (frames - 1) / frames, frames),
            config,
            cameras=cameras,
            training_cameras=cameras - (cameras >= FEWEST_CAMERAS),
            filmed_pixels=pixels,
            pixels=pixels / config.capture.downscale**2,
            straightened=0.0,
            masked=False,
            aligned=False,
        )

    @classmethod
    def _with_times(cls, times: npt.NDArray[np.float64], config: RunConfig, **known: Any) -> TrainingSize:
        """Return a size from the times of the frames, seconds; `known` are the fields that come from the pictures."""
        seconds = float(times[-1] - times[0])
        segments = cut_into_segments(times, config.train.segment_frames)
        every = frames_in(config.points.interval, times)
        budgets = [config.train.splat_budgets(one.seconds) for one in segments]
        moves = len(times) > 1  # nothing moves in a single moment
        return cls(
            frames=len(times),
            moments=len({frame for one in segments for frame in one.sampled(every)}),
            first_static=config.points.static,
            first_dynamic=config.points.dynamic_in(seconds) if moves else 0,
            segments=tuple(
                SegmentSize(one.frames, static, dynamic if moves else 0)
                for one, (static, dynamic) in zip(segments, budgets, strict=True)
            ),
            iterations=config.train.iterations,
            coarse_until=config.train.coarse_until,
            moving_steps=config.train.moving_steps if moves else 0.0,
            by_segment=config.encode.by_segment,
            **known,
        )
