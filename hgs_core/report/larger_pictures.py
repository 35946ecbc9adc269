"""The pictures of a report on larger screens and from nearer: one place at several sizes, and a walk to the movers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import avg_pool2d

from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.codec import Manifest, decode_scene
from hgs_core.evaluate.magnified import WALKS, depth_of_movers, walked
from hgs_core.metrics.psnr import psnr
from hgs_core.render.scene_picture import pixels_of, scene_picture
from hgs_core.render.threads import one_torch_thread
from hgs_core.report.embedded_pictures import data_uri, reduced, reduced_size
from hgs_core.report.sources import FinishedRun
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["Crop", "LargerPictures", "draw_larger_pictures"]

_FACTORS = (2, 4)
_MOST_PIXELS = 1 << 26  # pixels of the largest picture drawn: 1 GiB of colours and alpha
_CROP_QUALITY = 92  # JPEG; the smallest crop is shown four times as large


@dataclass(frozen=True)
class Crop:
    """The same part of the picture at one size."""

    factor: int  # times the training size
    picture: str  # data URI
    agreement: float | None  # dB, averaged to the training size, from the part at that size; None for that itself


@dataclass(frozen=True)
class LargerPictures:
    """One moment of one camera on larger screens and from nearer."""

    camera: str
    frame: int
    seconds: float
    crop_size: tuple[int, int]  # width and height of the largest crop, pixels
    crops: Sequence[Crop]  # the training size first
    size: tuple[int, int]  # width and height of the pictures of the walk, pixels
    walk: Sequence[str]  # data URIs; from the camera's place, then from `WALKS` of the way


def draw_larger_pictures(
    run: FinishedRun, capture: Capture, names: Sequence[str], progress: ProgressCallback
) -> list[LargerPictures]:
    """Draw the middle moment of each of the cameras `names`."""
    scene = decode_scene(run.folder.scene).map(torch.from_numpy)
    result = []
    with one_torch_thread():
        for done, name in enumerate(names):
            progress(Progress("larger pictures", done, len(names)))
            result.append(_larger_pictures(run.manifest, capture, scene, name))
        progress(Progress("larger pictures", len(names), len(names)))
    return result


def _larger_pictures(manifest: Manifest, capture: Capture, scene: HybridScene[Tensor], name: str) -> LargerPictures:
    camera = next(camera for camera in manifest.cameras if camera.name == name)
    frame = len(capture.times) // 2
    seconds = capture.moment(capture.camera_index(name), frame)

    def drawn(eye: Camera) -> Tensor:
        return scene_picture(scene, eye, seconds, rig=manifest.rig).rgb.clamp(0, 1)

    plain = drawn(camera)
    fitting = [k for k in _FACTORS if k * k * camera.width * camera.height <= _MOST_PIXELS]
    larger = {factor: drawn(camera.scaled(factor)) for factor in fitting}
    width, height = (max(1, side // _FACTORS[-1]) for side in reduced_size(camera.width, camera.height))
    top, left = _most_different(plain, next(iter(larger.values()), plain), height, width)

    def crop(picture: Tensor, factor: int) -> Tensor:
        return picture[:, top * factor : (top + height) * factor, left * factor : (left + width) * factor]

    crops = [Crop(1, data_uri(pixels_of(crop(plain, 1)), _CROP_QUALITY), None)]
    for factor, picture in larger.items():
        part = crop(picture, factor)
        agreement = psnr(avg_pool2d(part[None], factor)[0], crop(plain, 1))
        crops.append(Crop(factor, data_uri(pixels_of(part), _CROP_QUALITY), agreement))
    way = depth_of_movers(scene, camera, seconds, manifest.center)
    nearer = [drawn(walked(camera, share, way)) for share in WALKS]
    return LargerPictures(
        camera=name,
        frame=frame,
        seconds=float(capture.times[frame]),
        crop_size=(width * _FACTORS[-1], height * _FACTORS[-1]),
        crops=crops,
        size=reduced_size(camera.width, camera.height),
        walk=[data_uri(reduced(pixels_of(picture))) for picture in (plain, *nearer)],
    )


def _most_different(plain: Tensor, larger: Tensor, height: int, width: int) -> tuple[int, int]:
    """Return the row and column of the part, `height` x `width`, where a larger picture is least like `plain`."""
    error = (avg_pool2d(larger[None], larger.shape[-1] // plain.shape[-1]) - plain).square().mean(dim=1)
    down, across = max(1, height // 4), max(1, width // 4)
    means = avg_pool2d(error, (height, width), stride=(down, across))[0]
    row, column = divmod(int(means.argmax()), means.shape[1])
    return row * down, column * across
