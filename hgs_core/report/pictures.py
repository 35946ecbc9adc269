"""The pictures of a report: drawn beside true ones, error maps, and maps of static and dynamic splats."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from PIL import Image
from torch import Tensor

from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.codec import decode_scene
from hgs_core.metrics.psnr import psnr
from hgs_core.render.fixed_view import FixedView
from hgs_core.render.scene_picture import pixels_of
from hgs_core.render.threads import one_torch_thread
from hgs_core.report.embedded_pictures import Bytes, data_uri, reduced, reduced_size
from hgs_core.report.error_colours import error_picture
from hgs_core.report.sources import FinishedRun
from hgs_core.scene.splats import HybridScene
from hgs_core.train.targets import target_picture

__all__ = ["MOVING_COLOUR", "CameraPictures", "Moment", "choose_frames", "draw_pictures", "evenly", "picture_of"]

MOVING_COLOUR = (255, 122, 26)  # sRGB, of pixels that dynamic splats draw
_MOMENTS_PER_CAMERA = 3  # moments of a camera, beside the worst
_STRETCHES_ALIKE = 10  # frames nearer than the capture's length over this show about the same
_MOST_CAMERAS = 4  # a report stays a few megabytes
_MOST_FRAMES_MEASURED = 60  # frames of a camera, where the report measures them itself
_ERROR_MAP_QUALITY = 75  # JPEG, of error maps: mostly noise, which costs bytes


@dataclass(frozen=True)
class Moment:
    """One frame of one camera; the pictures are data URIs of equal size."""

    frame: int
    seconds: float
    psnr: float  # dB, of the whole frame at its full size
    worst: bool  # whether it is the worst of the camera's measured frames
    size: tuple[int, int]  # width and height of the pictures
    drawn: str
    truth: str
    error: str
    moving: str
    dynamic_share: float  # share of pixels drawn by dynamic splats for more than half


@dataclass(frozen=True)
class CameraPictures:
    """The moments of one camera in order of time, and the PSNR in dB of the frames that were measured."""

    camera: str
    moments: Sequence[Moment]
    frames: Sequence[int]
    psnr: Sequence[float]


def draw_pictures(run: FinishedRun, capture: Capture, progress: ProgressCallback) -> list[CameraPictures]:
    """Draw the scored cameras, or some training cameras where none was scored.

    Frames whose PSNR eval.json does not tell are measured, 60 per camera at most.
    """
    scene = decode_scene(run.folder.scene).map(torch.from_numpy)
    known = run.per_frame("psnr")
    scored = [name for name in run.scores.get("cameras", run.spec.config.capture.hold_out) if name]
    names = evenly(scored or [camera.name for camera in capture.cameras], _MOST_CAMERAS)
    result = []
    with one_torch_thread():
        for done, name in enumerate(names):
            progress(Progress("pictures", done, len(names)))
            artist = _Artist(run, capture, scene, name)
            frames = list(range(len(capture.times)))
            figures = known.get(name, [])
            if len(figures) != len(frames):
                frames = evenly(frames, _MOST_FRAMES_MEASURED)
                figures = [artist.psnr(frame) for frame in frames]
            chosen, worst = choose_frames(frames, figures)
            of = dict(zip(frames, figures, strict=True))
            moments = [artist.moment(frame, of[frame], frame == worst) for frame in chosen]
            result.append(CameraPictures(name, moments, frames, figures))
        progress(Progress("pictures", len(names), len(names)))
    return result


def choose_frames(frames: Sequence[int], psnrs: Sequence[float]) -> tuple[list[int], int]:
    """Return frames from the middles of equal parts and the one of the lowest PSNR, ascending; and that one.

    The worst frame replaces a middle that would show about the same.
    """
    middles = [int((part + 0.5) / _MOMENTS_PER_CAMERA * len(frames)) for part in range(_MOMENTS_PER_CAMERA)]
    worst = int(np.argmin(np.where(np.isfinite(psnrs), psnrs, np.inf)))
    apart = {place for place in middles if abs(place - worst) * _STRETCHES_ALIKE > len(frames)}
    return [frames[place] for place in sorted({*apart, worst})], frames[worst]


def evenly(items: Sequence[Any], count: int) -> list[Any]:
    """Return at most `count` of the items, evenly chosen, the first and the last among them."""
    if len(items) <= count:
        return list(items)
    return [items[round(place)] for place in np.linspace(0, len(items) - 1, count)]


def picture_of(capture: Capture, camera: str, frame: int) -> str:
    """Return a picture of the capture at the report's size, as a data URI."""
    return data_uri(reduced(capture.frame(capture.camera_index(camera), frame)))


class _Artist:
    """Draws one camera: the scene as it is, and with black statics and white dynamics, which shows their weights."""

    def __init__(self, run: FinishedRun, capture: Capture, scene: HybridScene[Tensor], name: str) -> None:
        self._capture, self._scene = capture, scene
        self._index = capture.camera_index(name)
        self._camera = next(camera for camera in run.manifest.cameras if camera.name == name)
        self._view = FixedView(scene.static, self._camera, background=scene.background, antialiased=scene.antialiased)
        black = dataclasses.replace(scene.static, rgb=torch.zeros_like(scene.static.rgb))
        self._weights = FixedView(black, self._camera, antialiased=scene.antialiased)

    def psnr(self, frame: int) -> float:
        """Return the PSNR of a frame in dB."""
        return psnr(self._drawn(frame), self._truth(frame))

    def moment(self, frame: int, decibels: float, worst: bool) -> Moment:
        """Draw a frame."""
        drawn, truth = self._drawn(frame), self._truth(frame)
        share = self._dynamic_share(frame)
        picture, size = reduced(pixels_of(drawn)), self._size()
        error = _reduced_field((drawn - truth).abs().mean(dim=0), size)
        return Moment(
            frame=frame,
            seconds=float(self._capture.times[frame]),
            psnr=decibels,
            worst=worst,
            size=size,
            drawn=data_uri(picture),
            truth=data_uri(reduced(pixels_of(truth))),
            error=data_uri(error_picture(error), _ERROR_MAP_QUALITY),
            moving=data_uri(_tinted(picture, _reduced_field(share, size))),
            dynamic_share=float((share > 0.5).double().mean()),
        )

    def _size(self) -> tuple[int, int]:
        return reduced_size(self._camera.width, self._camera.height)

    def _truth(self, frame: int) -> Tensor:
        return target_picture(self._capture, self._index, frame, self._camera)

    def _drawn(self, frame: int) -> Tensor:
        segment = self._scene.segment_at(float(self._capture.times[frame]))
        moment = segment.normalised(self._capture.moment(self._index, frame))
        return self._view.frame(segment.dynamic, moment).rgb.clamp(0, 1)

    def _dynamic_share(self, frame: int) -> Tensor:
        """Return the share [H, W] of every pixel's colour that dynamic splats give."""
        segment = self._scene.segment_at(float(self._capture.times[frame]))
        moment = segment.normalised(self._capture.moment(self._index, frame))
        white = dataclasses.replace(segment.dynamic, rgb=torch.ones_like(segment.dynamic.rgb))
        return self._weights.frame(white, moment).rgb[0].clamp(0, 1)


def _reduced_field(values: Tensor, size: tuple[int, int]) -> npt.NDArray[np.float32]:
    """Average a field [H, W] down to `size`."""
    image = Image.fromarray(np.ascontiguousarray(values.numpy(), np.float32))
    return np.asarray(image.resize(size, Image.Resampling.BOX), np.float32)


def _tinted(pixels: Bytes, share: npt.NDArray[np.float32]) -> Bytes:
    """Return the picture in grey, and in shades of `MOVING_COLOUR` as far as dynamic splats drew it."""
    grey = (pixels @ np.array([0.299, 0.587, 0.114]))[..., None]
    still = np.repeat(30 + 0.6 * grey, 3, axis=2)
    moving = np.array(MOVING_COLOUR) * (0.4 + 0.6 * grey / 255)
    weight = share[..., None]
    return np.asarray(np.rint(np.clip((1 - weight) * still + weight * moving, 0, 255)), np.uint8)
