"""Silhouettes of moving things at several moments: cameras without a common feature still share these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageFilter

from hgs_core.base.cores import core_pool
from hgs_core.capture.capture import Capture
from hgs_core.capture.pictures.picture import reduced_picture
from hgs_core.decompose.components import component_labels
from hgs_core.points.matching import moving_pixels
from hgs_core.scene.camera import Camera

__all__ = ["Silhouette", "find_silhouettes", "silhouette_frames", "silhouettes_of"]

_MOMENTS = 24
_LEAST = 5e-4  # share of the pixels
_EDGE = 2.0  # pixels from the border of a picture: what touches it goes on outside
_SPECKS = 9  # pixels, side of the median filter against noise
_SIDE = 1000  # pixels: larger masks are thinned out
_MOST_BODIES = 4  # silhouettes of single bodies in a picture, the largest ones ...
_SMALLEST_BODY = 0.1  # ... and share of the largest that each has at least

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Silhouette:
    """The outline of something that moves."""

    middle: Floats  # [2] pixels
    corners: Floats  # [N, 2] of the convex hull, pixels
    inside: Bools  # [N] whether the corner lies off the border of the picture

    @classmethod
    def of(cls, mask: Bools, size: Camera) -> Silhouette | None:
        """Return that of a mask [H, W] in pixels of a camera of another size; None if it marks next to nothing."""
        rows = np.flatnonzero(mask.any(axis=1))
        if not len(rows) or mask.mean() < _LEAST:
            return None
        height, width = mask.shape
        first, last = mask[rows].argmax(axis=1), width - mask[rows][:, ::-1].argmax(axis=1)
        sides = np.concatenate((first, last, first, last)), np.concatenate((rows, rows, rows + 1, rows + 1))
        corners = _hull(np.stack(sides, axis=1).astype(np.float64))
        inside = np.all((corners > _EDGE) & (corners < (width - _EDGE, height - _EDGE)), axis=1)
        scale = np.array((size.width / width, size.height / height))
        columns = mask[rows].sum(axis=0)
        middle = np.array((columns @ np.arange(width), mask[rows].sum(axis=1) @ rows)) / columns.sum() + 0.5
        return cls(middle * scale, corners * scale, inside)


def silhouette_frames(frames: int) -> tuple[int, ...]:
    """Return the moments that silhouettes are taken at, evenly over a capture of so many frames."""
    return tuple(np.unique(np.linspace(0, frames - 1, _MOMENTS).round().astype(int)).tolist())


def find_silhouettes(
    capture: Capture, camera: int, frames: Sequence[int], size: Camera
) -> tuple[list[list[Silhouette]], bool]:
    """Return a camera's silhouettes at each of `frames` in pixels of `size`, and whether they are of given masks.

    Without given masks, what differs from the median of the pictures moves.

    Raises:
        InputError: a picture or a mask is unreadable or of a wrong size.
    """
    with core_pool() as pool:
        given = list(pool.map(lambda frame: capture.mask(camera, frame), frames))
        masks = [mask for mask in given if mask is not None]
        if len(masks) == len(frames):
            return list(pool.map(lambda mask: silhouettes_of(mask, size), masks)), True
        pictures = list(pool.map(lambda frame: reduced_picture(capture.frame(camera, frame), size), frames))
        moving = moving_pixels(pictures)
        return list(pool.map(lambda mask: silhouettes_of(_without_specks(mask), size), moving)), False


def silhouettes_of(mask: Bools, size: Camera) -> list[Silhouette]:
    """Return the silhouette of all that a mask [H, W] marks but for specks, and of each body if there are several."""
    step = -(-max(mask.shape) // _SIDE)
    labels = component_labels(mask[::step, ::step])
    areas = np.bincount(labels.ravel())[1:]
    largest = np.argsort(-areas, kind="stable")[:_MOST_BODIES] + 1
    bodies = [body for body in largest if areas[body - 1] >= _SMALLEST_BODY * areas.max()]
    marked = np.zeros(len(areas) + 1, np.bool_)
    marked[bodies] = True
    found = [Silhouette.of(marked[labels], size)]
    if len(bodies) > 1:
        found += [Silhouette.of(labels == body, size) for body in bodies]
    return [shape for shape in found if shape is not None]


def _without_specks(mask: Bools) -> Bools:
    return np.array(Image.fromarray(mask.astype(np.uint8)).filter(ImageFilter.MedianFilter(_SPECKS)), bool)


def _hull(points: Floats) -> Floats:
    """Return the corners of the convex hull, by Andrew's monotone chain."""
    ordered = np.unique(points, axis=0)

    def chain(points: Floats) -> list[Floats]:
        found: list[Floats] = []
        for point in points:
            while len(found) > 1 and _left_turn(found[-2], found[-1], point) <= 0:
                found.pop()
            found.append(point)
        return found[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def _left_turn(a: Floats, b: Floats, c: Floats) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
