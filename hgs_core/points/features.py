"""SIFT features and their matches between cameras with known poses."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.scene.camera import Camera

__all__ = ["Features", "extract_features", "fundamental_matrix", "match_features", "mutual_matches"]

_MASK_MARGIN = 24  # pixels around the mask's box: the descriptors there see beyond it
# Pixels; a smaller picture is searched at twice its size, which finds about three times as much.
_SMALL_PICTURE = 60_000
# Pixels; a larger picture is searched at the halved size nearest to this. Of a megapixel the finest features are those
# beyond _MAX_FEATURES, and finding them takes four fifths of the time.
_SEARCHED_PIXELS = 350_000
_MAX_FEATURES = 3000
_MAX_FINE_FEATURES = 8000
_EPIPOLAR_TOLERANCE = 1.5  # pixels from the epipolar line (Sampson distance)
_MAX_ANGLE = 0.7  # radians between descriptors, COLMAP's default
_MAX_RATIO = 0.8  # ratio of angles to the best and the second candidate, Lowe's test
_MATCHED_ROWS = 512  # rows at once: little memory for many threads
_DESCRIPTOR_LENGTH = 512.0  # length of a descriptor stored in bytes


@dataclass(frozen=True)
class Features:
    """N features of one picture."""

    xy: npt.NDArray[np.float64]  # [N, 2] pixels, centres at +0.5
    descriptors: npt.NDArray[np.float32]  # [N, 128] whole numbers 0..255


def extract_features(
    picture: npt.NDArray[np.uint8],  # [H, W, 3]
    mask: npt.NDArray[np.bool_] | None = None,  # [H, W] where features are wanted; None: everywhere
    *,
    fine: bool = False,
) -> Features:
    """Return the SIFT features of a picture, the same for the same input, the finest first.

    A small picture is searched at twice its size, and any picture for which `fine` asks for it. From 700,000 pixels on,
    other pictures are searched at half their size, from four times as many on at a quarter, and so on.
    """
    from hgs_core.points.colmap_points import pycolmap

    empty = Features(np.zeros((0, 2)), np.zeros((0, 128), np.float32))
    left = top = 0
    grey = (picture @ np.array([0.299, 0.587, 0.114])).round().astype(np.uint8)
    if mask is not None:
        rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        if len(rows) == 0:
            return empty
        left, top = max(0, int(columns[0]) - _MASK_MARGIN), max(0, int(rows[0]) - _MASK_MARGIN)
        grey = grey[top : int(rows[-1]) + _MASK_MARGIN, left : int(columns[-1]) + _MASK_MARGIN]
    if min(grey.shape) < 32:
        return empty
    pycolmap.logging.minloglevel = 2  # errors alone
    options = pycolmap.FeatureExtractionOptions(num_threads=1, use_gpu=False)
    options.sift.first_octave = -1 if fine or grey.size < _SMALL_PICTURE else _halvings(grey.size)
    options.sift.max_num_features = _MAX_FINE_FEATURES if fine else _MAX_FEATURES
    extractor = pycolmap.FeatureExtractor.create(options, pycolmap.Device.cpu)
    keypoints, descriptors = extractor.extract_from_uint8_array(np.ascontiguousarray(grey))
    if len(keypoints) == 0:
        return empty
    xy = np.asarray(pycolmap.keypoints_to_matrix(keypoints)[:, :2], np.float64) + np.array([left, top])
    values = np.asarray(descriptors.data, np.float32)
    if mask is not None:
        column, row = np.clip(xy.astype(int), 0, (picture.shape[1] - 1, picture.shape[0] - 1)).T
        kept = mask[row, column]
        xy, values = xy[kept], values[kept]
    return Features(xy, values)


def _halvings(pixels: int) -> int:
    """Return how many times a picture's sides are halved before its search."""
    return max(0, round(math.log(pixels / _SEARCHED_PIXELS, 4)))


def fundamental_matrix(first: Camera, second: Camera) -> npt.NDArray[np.float64]:
    """Return F [3, 3] with x2^T F x1 = 0 for the homogeneous pixels x1, x2 of one point (Hartley & Zisserman 9.6)."""
    relative = second.world_to_camera @ np.linalg.inv(first.world_to_camera)
    x, y, z = relative[:3, 3]
    essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ relative[:3, :3]
    return np.asarray(np.linalg.inv(_intrinsics(second)).T @ essential @ np.linalg.inv(_intrinsics(first)))


def match_features(
    first: Features, second: Features, fundamental: npt.NDArray[np.float64]
) -> npt.NDArray[np.uint32]:  # [M, 2] rows of first and second
    """Return the pairs that are each other's best candidate along the epipolar lines and pass the ratio test."""
    return _matches(first, second, fundamental)


def mutual_matches(first: Features, second: Features) -> npt.NDArray[np.uint32]:  # [M, 2] rows of first and second
    """Return the pairs that are each other's best candidate anywhere and pass the ratio test."""
    return _matches(first, second, None)


def _matches(first: Features, second: Features, fundamental: npt.NDArray[np.float64] | None) -> npt.NDArray[np.uint32]:
    if min(len(first.xy), len(second.xy)) < 2:
        return np.zeros((0, 2), np.uint32)
    best = np.zeros(len(first.xy), np.int64)
    top, rivals = np.zeros((2, len(first.xy)), np.float32)
    highest = np.zeros(len(second.xy), np.float32)  # likeness that any of the first has to each of the second
    for start in range(0, len(first.xy), _MATCHED_ROWS):
        rows = slice(start, start + _MATCHED_ROWS)
        # Whole numbers up to 128 * 255^2 < 2^24 are exact in float32: the result is the same for any number of threads.
        likeness = first.descriptors[rows] @ second.descriptors.T
        if fundamental is not None:
            likeness[~_near_epipolar_lines(first.xy[rows], second.xy, fundamental)] = 0.0
        best[rows] = likeness.argmax(axis=1)
        places = np.arange(len(likeness)), best[rows]
        top[rows] = likeness[places]
        np.maximum(highest, likeness.max(axis=0), out=highest)
        likeness[places] = 0.0
        rivals[rows] = likeness.max(axis=1)
    mutual = np.zeros(len(best), bool)  # the first among equals
    favourites = np.flatnonzero(top == highest[best])
    mutual[favourites[np.unique(best[favourites], return_index=True)[1]]] = True
    angle = np.arccos(np.minimum(top / _DESCRIPTOR_LENGTH**2, 1.0))
    rival = np.arccos(np.minimum(rivals / _DESCRIPTOR_LENGTH**2, 1.0))
    kept = mutual & (angle < _MAX_ANGLE) & (angle < _MAX_RATIO * rival)
    return np.stack((np.flatnonzero(kept), best[kept]), axis=1).astype(np.uint32)


def _near_epipolar_lines(
    first: npt.NDArray[np.float64], second: npt.NDArray[np.float64], fundamental: npt.NDArray[np.float64]
) -> npt.NDArray[np.bool_]:  # [N1, N2]
    """Return which pairs of pixels have a small Sampson distance."""
    x1 = np.column_stack((first, np.ones(len(first))))
    x2 = np.column_stack((second, np.ones(len(second))))
    lines2, lines1 = x1 @ fundamental.T, x2 @ fundamental  # lines of the second and the first picture
    residual = (lines2 @ x2.T).astype(np.float32)
    slope2 = (lines2[:, :2] ** 2).sum(axis=1).astype(np.float32)
    slope1 = (lines1[:, :2] ** 2).sum(axis=1).astype(np.float32)
    return np.asarray(residual**2 < np.float32(_EPIPOLAR_TOLERANCE**2) * (slope2[:, None] + slope1))


def _intrinsics(camera: Camera) -> npt.NDArray[np.float64]:
    return np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])
