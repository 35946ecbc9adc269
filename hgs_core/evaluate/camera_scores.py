"""The scores of cameras: gathered frame by frame, and combined over frames and cameras."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from torch import Tensor

from hgs_core.evaluate.picture_scores import PICTURE_METRICS, REGION_METRICS, RIG_METRICS, PictureScorer
from hgs_core.evaluate.rig_view import RigView
from hgs_core.metrics.colour_corrected_psnr import ColourCorrectedError
from hgs_core.metrics.flicker import Flicker
from hgs_core.metrics.psnr import decibels
from hgs_core.metrics.region_psnr import RegionError

__all__ = ["REGIONS", "CameraScores", "FrameScores", "Scores", "combine"]

REGIONS = {"psnr_dynamic": True, "psnr_static": False}
"""The metrics of a region, and whether it is the one that moves."""

Scores = dict[str, float | None]
"""A score by the name of its metric; None where it was not measured or is not finite, as JSON needs it."""

_MEANS = (*PICTURE_METRICS, *(f"{name}_rig" for name in RIG_METRICS))  # means over frames
_POOLED = {**REGIONS, "psnr_dynamic_rig": True}
_PIXEL_MEANS = (*REGION_METRICS, *(f"{name}_rig" for name in REGION_METRICS))
_SERIES = (*_MEANS, *_POOLED, *_PIXEL_MEANS)


@dataclass
class _PixelMean:
    """A mean over pixels, added up over frames."""

    total: float = 0.0
    pixels: int = 0

    def add(self, mean: float, pixels: int) -> None:
        """Add the mean of so many pixels."""
        self.total += mean * pixels
        self.pixels += pixels


@dataclass(frozen=True)
class FrameScores:
    """A frame with its own part in the scores of its camera."""

    image: Tensor  # [3, H, W] in [0, 1]
    truth: Tensor  # [3, H, W]
    moving: Tensor | None  # [H, W] bool
    metrics: Scores  # metrics of pictures and of moving pixels
    regions: dict[str, RegionError]
    colour_corrected: ColourCorrectedError
    lens_corrected: ColourCorrectedError

    @classmethod
    def of(
        cls, scorer: PictureScorer, image: Tensor, truth: Tensor, moving: Tensor | None, rig: RigView | None = None
    ) -> FrameScores:
        """Score a frame [3, H, W] in [0, 1], with its motion mask [H, W] bool, if there is one.

        `rig` is the lens of the training cameras, if one was learned. Without it the rig shows the picture as it is.
        """
        metrics = scorer.score(image, truth, moving)
        as_rig, rig_metrics = image, metrics
        corrected, lens_corrected = ColourCorrectedError(), ColourCorrectedError()
        corrected.add(image, truth, moving)
        if rig is not None:
            lens_corrected.add(rig.darkened(image), truth, moving)
            as_rig = rig.shown(image)
            rig_metrics = scorer.score_as_rig(as_rig, truth, moving)
        metrics |= {f"{name}_rig": rig_metrics[name] for name in (*RIG_METRICS, *REGION_METRICS)}
        regions = {name: RegionError() for name in _POOLED}
        if moving is not None:
            for name, inside in _POOLED.items():
                drawn = as_rig if name.endswith("_rig") else image
                regions[name].add(drawn, truth, moving if inside else ~moving)
        return cls(image, truth, moving, metrics, regions, corrected, lens_corrected)


class CameraScores:
    """The scores of one camera's frames."""

    def __init__(self) -> None:
        self._flicker = Flicker()
        self.flicker: float | None = None
        self.flicker_steady: float | None = None
        self.colour_corrected = ColourCorrectedError()
        self.lens_corrected = ColourCorrectedError()
        self.frames: dict[str, list[float | None]] = {name: [] for name in _SERIES}
        self.regions = {name: RegionError() for name in _POOLED}
        self.means = {name: _PixelMean() for name in _PIXEL_MEANS}

    def add(self, frame: FrameScores) -> None:
        """Add the next frame."""
        for name, value in frame.metrics.items():
            self.frames[name].append(value)
            if name in self.means and value is not None and frame.moving is not None:
                self.means[name].add(value, int(frame.moving.sum()))
        for name, error in frame.regions.items():
            self.frames[name].append(error.psnr())
            self.regions[name].include(error)
        self._flicker.add(frame.image, frame.truth, frame.moving)
        self.colour_corrected.include(frame.colour_corrected)
        self.lens_corrected.include(frame.lens_corrected)

    def finish(self) -> None:
        """Compute the flicker after the last frame and free its memory: several pictures' worth."""
        self.flicker, self.flicker_steady = self._flicker.value(), self._flicker.steady()
        self._flicker = Flicker()

    def per_frame(self) -> dict[str, list[float | None]]:
        """The scores of every frame, of the metrics that at least one frame has; None as in `Scores`."""
        finite = {name: [_finite(value) for value in values] for name, values in self.frames.items()}
        return {name: values for name, values in finite.items() if any(value is not None for value in values)}


def combine(cameras: Sequence[CameraScores]) -> Scores:
    """Return the scores of all frames of the cameras together.

    They are means over frames and cameras, but for those of regions, which are of all their pixels in all frames
    together, and psnr_colour_corrected, psnr_lens_corrected, flicker and flicker_steady, which are means over cameras.
    """
    scores: Scores = {name: _mean([value for camera in cameras for value in camera.frames[name]]) for name in _MEANS}
    for name in _POOLED:
        pooled = RegionError()
        for camera in cameras:
            pooled.include(camera.regions[name])
        scores[name] = _finite(pooled.psnr())
    for name in _PIXEL_MEANS:
        means = [camera.means[name] for camera in cameras]
        pixels = sum(mean.pixels for mean in means)
        scores[name] = _finite(sum(mean.total for mean in means) / pixels) if pixels else None
    for name, errors in (
        ("colour_corrected", [camera.colour_corrected for camera in cameras]),
        ("lens_corrected", [camera.lens_corrected for camera in cameras]),
    ):
        scores[f"psnr_dynamic_{name}"] = _finite(_pooled_of_regions(errors))
        scores[f"psnr_{name}"] = _mean([_finite(error.psnr()) for error in errors])
    scores["flicker"] = _mean([camera.flicker for camera in cameras])
    scores["flicker_steady"] = _mean([camera.flicker_steady for camera in cameras])
    return scores


def _pooled_of_regions(cameras: Sequence[ColourCorrectedError]) -> float | None:
    """Return the PSNR of moving pixels in all frames, after each camera's colour map; None if nothing moves."""
    errors = [camera.region_error() for camera in cameras]
    values = sum(count for _, count in errors)
    return decibels(sum(squared for squared, _ in errors) / values) if values else None


def _mean(values: Sequence[float | None]) -> float | None:
    present = [value for value in values if value is not None]
    return _finite(sum(present) / len(present)) if present else None


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
