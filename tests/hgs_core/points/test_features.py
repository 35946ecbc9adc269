"""Epipolar geometry and matching, against synthetic points with known projections."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points.features import Features, extract_features, fundamental_matrix, match_features
from hgs_core.scene.camera import Camera


def camera_at(x: float, turn: float = 0.0) -> Camera:
    pose = np.eye(4)
    c, s = np.cos(turn), np.sin(turn)
    pose[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    pose[:3, 3] = -pose[:3, :3] @ (x, 0.1 * x, 0)
    return Camera(f"at {x}", 640, 480, 500, 510, 322, 238, pose)


def synthetic(count: int) -> tuple[Camera, Camera, np.ndarray, np.ndarray]:
    numbers = np.random.default_rng(1)
    points = numbers.uniform((-1, -1, 3), (1, 1, 5), (count, 3))
    descriptors = numbers.integers(0, 100, (count, 128)).astype(np.float64)
    descriptors *= 512 / np.linalg.norm(descriptors, axis=1, keepdims=True)
    return camera_at(0), camera_at(1.0, -0.2), points, descriptors.round().clip(0, 255)


def test_fundamental_matrix_annihilates_true_pairs() -> None:
    a, b, points, _ = synthetic(20)
    x1, x2 = (np.column_stack((camera.project(points)[0], np.ones(20))) for camera in (a, b))
    F = fundamental_matrix(a, b)
    np.testing.assert_allclose(np.einsum("ni,ij,nj->n", x2, F, x1) / np.linalg.norm(F), 0, atol=1e-6)


def test_matching_finds_the_true_pairs() -> None:
    a, b, points, descriptors = synthetic(40)
    order = np.random.default_rng(2).permutation(40)
    first = Features(a.project(points)[0], descriptors.astype(np.float32))
    second = Features(b.project(points[order])[0], descriptors[order].astype(np.float32))
    matches = match_features(first, second, fundamental_matrix(a, b))
    assert len(matches) == 40
    np.testing.assert_array_equal(order[matches[:, 1]], matches[:, 0])


def test_a_look_alike_off_the_epipolar_line_is_no_match() -> None:
    a, b, points, descriptors = synthetic(40)
    first = Features(a.project(points)[0], descriptors.astype(np.float32))
    moved = b.project(points)[0]
    moved[7, 1] += 40
    second = Features(moved, descriptors.astype(np.float32))
    matches = match_features(first, second, fundamental_matrix(a, b))
    assert 7 not in matches[:, 0]
    assert len(matches) >= 38


def picture_of_spots(height: int, width: int, *spots: tuple[float, float, float]) -> np.ndarray:
    """Return a picture [H, W, 3] of Gaussian spots (x, y, sigma); centres of pixels lie at a half."""
    y, x = np.mgrid[0:height, 0:width] + 0.5
    light = sum(180 * np.exp(-((x - u) ** 2 + (y - v) ** 2) / (2 * sigma**2)) for u, v, sigma in spots)
    return np.repeat((40 + light)[:, :, None], 3, 2).round().astype(np.uint8)


@pytest.mark.parametrize("size", [(64, 80), (900, 1200)])
def test_a_spot_is_found_at_its_centre_with_pixel_centres_at_a_half(size: tuple[int, int]) -> None:
    """The middle of pixel (column 40, row 30), in a small picture and in one that is halved."""
    features = extract_features(picture_of_spots(*size, (40.5, 30.5, 5.0)))
    assert np.linalg.norm(features.xy - (40.5, 30.5), axis=1).min() < 0.15


def test_a_large_picture_is_searched_for_what_half_of_it_shows() -> None:
    coarse, fine = (40.5, 30.5), (600.5, 500.5)
    picture = picture_of_spots(900, 1200, (*coarse, 5.0), (*fine, 1.3))
    found = [extract_features(picture, fine=asked).xy for asked in (False, True)]
    assert [np.linalg.norm(xy - coarse, axis=1).min() < 1.0 for xy in found] == [True, True]
    assert [np.linalg.norm(xy - fine, axis=1).min() < 1.0 for xy in found] == [False, True]


@pytest.mark.parametrize("mask", [None, "half"])
def test_features_lie_where_they_are_wanted(mask: str | None) -> None:
    picture = np.random.default_rng(0).integers(0, 255, (16, 20, 3)).astype(np.uint8).repeat(8, 0).repeat(8, 1)
    wanted = None
    if mask:
        wanted = np.zeros(picture.shape[:2], bool)
        wanted[:, 80:] = True
    features = extract_features(picture, wanted)
    assert len(features.xy) > 20
    assert features.xy[:, 0].min() >= (80 if mask else 0)


def test_a_blank_picture_has_no_features() -> None:
    assert len(extract_features(np.full((64, 64, 3), 128, np.uint8)).xy) == 0
