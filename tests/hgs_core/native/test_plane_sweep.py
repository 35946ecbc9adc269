"""The plane sweep, against a plain one in numpy and on surfaces of known depth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.native.plane_sweep import plane_sweep
from hgs_core.scene.camera import Camera

Depth = Callable[[npt.NDArray[np.float64], npt.NDArray[np.float64]], npt.NDArray[np.float64]]
REACH, CONTRAST, STEP, JUMP, EDGE, BLIND = (
    4,
    1e-3,
    82,
    1024.0,
    30.0,
    0.9,
)  # constants of src/plane_sweep.cpp and src/semi_global.cpp


def view(x: float, y: float = 0.0, width: int = 64, height: int = 48) -> Camera:
    pose = np.eye(4)
    pose[:3, 3] = (-x, -y, 0)
    return Camera(f"{x} {y}", width, height, 60, 60, width / 2, height / 2, pose)


def waves(x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The brightness of a pattern that does not repeat within a few units."""
    return 0.5 + 0.2 * np.sin(7 * x + 2 * np.sin(3 * y)) + 0.2 * np.sin(9 * y + 2 * np.sin(5 * x))


def photograph(camera: Camera, depth: float, brightness: Depth = waves) -> npt.NDArray[np.float32]:
    """Ray-cast a wall that faces the cameras."""
    row, column = np.mgrid[0 : camera.height, 0 : camera.width] + 0.5
    x = (column - camera.cx) / camera.fx * depth + camera.position[0]
    y = (row - camera.cy) / camera.fy * depth + camera.position[1]
    return np.ascontiguousarray(brightness(x, y), np.float32)


def inverse_depths(near: float, far: float, count: int) -> npt.NDArray[np.float64]:
    return 1 / np.linspace(1 / near, 1 / far, count)


def swept_depths(camera: Camera, pictures: dict[Camera, npt.NDArray[np.float32]]) -> npt.NDArray[np.float64]:
    others = [(other, picture) for other, picture in pictures.items() if other is not camera]
    places, _ = plane_sweep(camera, pictures[camera], others, inverse_depths(1.5, 8, 60))
    return 1 / (1 / 1.5 + places * (1 / 8 - 1 / 1.5) / 59)


def test_a_wall_is_found_at_its_depth_between_two_that_were_tried() -> None:
    cameras = [view(0), view(0.4), view(-0.4), view(0, 0.4)]
    depths = swept_depths(cameras[0], {camera: photograph(camera, 3.1) for camera in cameras})
    assert (np.abs(depths[4:-4, 4:-4] / 3.1 - 1) < 0.01).mean() > 0.95


def test_brightness_and_contrast_of_cameras_do_not_count() -> None:
    cameras = [view(0), view(0.4), view(-0.4)]
    pictures = {camera: photograph(camera, 3.1) for camera in cameras}
    pictures[cameras[1]] = pictures[cameras[1]] * np.float32(0.5) + np.float32(0.3)
    assert (np.abs(swept_depths(cameras[0], pictures)[4:-4, 12:-12] / 3.1 - 1) < 0.01).mean() > 0.98


def test_a_blank_stripe_takes_the_depth_of_what_is_beside_it() -> None:
    def striped(x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return np.where(np.abs(x) < 0.4, 0.5, waves(x, y))

    cameras = [view(0), view(0.4), view(-0.4)]
    depths = swept_depths(cameras[0], {camera: photograph(camera, 3.1, striped) for camera in cameras})
    assert np.abs(depths[8:-8, 24:40] / 3.1 - 1).max() < 0.03


def test_what_no_source_sees_says_so() -> None:
    camera = view(0)
    _, costs = plane_sweep(
        camera, photograph(camera, 3), [(view(99), photograph(view(99), 3))], inverse_depths(1, 9, 5)
    )
    np.testing.assert_allclose(costs, BLIND, atol=1e-3)


def test_costs_and_places_are_those_of_a_plain_sweep() -> None:
    camera, others = view(0, 0, 20, 14), [view(0.5, 0.1, 22, 16), view(-0.4, 0.2, 20, 14)]
    generator = np.random.default_rng(3)
    grey = photograph(camera, 3) + generator.normal(0, 0.02, (14, 20)).astype(np.float32)
    sources = [(other, photograph(other, 3)) for other in others]
    depths = inverse_depths(2, 6, 12)
    places, costs = plane_sweep(camera, grey, sources, depths)
    volume = np.stack([_matched(camera, grey, sources, depth) for depth in depths], 2)
    expected = _smoothest(volume, grey)
    whole = np.abs(places - expected) < 0.02  # a cost that is rounded the other way may move a draw
    assert whole.mean() > 0.98
    chosen = np.take_along_axis(volume, np.rint(places).astype(np.int64)[:, :, None], 2)[:, :, 0]
    np.testing.assert_allclose(costs, chosen, atol=1e-3)


@pytest.mark.parametrize("count", [0, 2])
def test_too_few_depths_are_refused(count: int) -> None:
    with pytest.raises(ValueError, match=f"3 depths or more, got {count}"):
        plane_sweep(view(0), photograph(view(0), 3), [], np.ones(count))


def test_source_of_a_wrong_size_is_refused() -> None:
    with pytest.raises(ValueError, match=r"picture must be .* shape \(48, 64\)"):
        plane_sweep(view(0), photograph(view(0), 3), [(view(1), np.zeros((3, 3), np.float32))], np.arange(1.0, 5.0))


def _matched(
    camera: Camera,
    grey: npt.NDArray[np.float32],
    sources: list[tuple[Camera, npt.NDArray[np.float32]]],
    depth: float,
) -> npt.NDArray[np.float64]:
    """The mean cost of the sources that see a pixel at a depth, window by window."""
    row, column = np.mgrid[0 : camera.height, 0 : camera.width] + 0.5
    points = camera.position + camera.rays(np.stack([column.ravel(), row.ravel()], 1)) * depth
    total, count = np.zeros(grey.shape), np.zeros(grey.shape)
    for other, picture in sources:
        pixels, z = other.project(points)
        seen = ((z > 0) & (pixels >= 0).all(1) & (pixels < (other.width, other.height)).all(1)).reshape(grey.shape)
        x, y = np.clip(pixels[:, 0] - 0.5, 0, other.width - 1), np.clip(pixels[:, 1] - 0.5, 0, other.height - 1)
        i, j = np.minimum(x.astype(int), other.width - 2), np.minimum(y.astype(int), other.height - 2)
        upper = picture[j, i] * (1 - (x - i)) + picture[j, i + 1] * (x - i)
        lower = picture[j + 1, i] * (1 - (x - i)) + picture[j + 1, i + 1] * (x - i)
        warped = (upper * (1 - (y - j)) + lower * (y - j)).reshape(grey.shape)
        for r, c in np.argwhere(seen):
            window = np.s_[max(r - REACH, 0) : r + REACH + 1, max(c - REACH, 0) : c + REACH + 1]
            a, b = grey[window].astype(np.float64), warped[window]
            covariance = (a * b).mean() - a.mean() * b.mean()
            total[r, c] += 0.5 * (1 - covariance / (a.std() * b.std() + CONTRAST))
        count += seen
    return np.where(count > 0, total / np.maximum(count, 1), BLIND)


def _smoothest(volume: npt.NDArray[np.float64], grey: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
    """Semi-global matching along eight directions, one pixel after the other."""
    costs = np.rint(volume * 2048).astype(np.int64)
    height, width, depths = costs.shape
    total = np.zeros_like(costs)
    for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)):
        paths = np.zeros_like(costs)
        for y in range(height)[:: dy or 1]:
            for x in range(width)[:: dx or 1]:
                paths[y, x] = costs[y, x]
                if 0 <= y - dy < height and 0 <= x - dx < width:
                    before = np.pad(paths[y - dy, x - dx], 1, constant_values=1 << 20)
                    edge = abs(float(grey[y, x]) - float(grey[y - dy, x - dx]))
                    jump = int(max(JUMP / (1 + EDGE * edge), 1.5 * STEP))
                    least = before.min()
                    beside = np.minimum(before[:-2], before[2:]) + STEP
                    paths[y, x] += np.minimum(np.minimum(before[1:-1], beside), least + jump) - least
        total += paths
    best = total.argmin(2)
    inner = best.clip(1, depths - 2)
    left, middle, right = (np.take_along_axis(total, (inner + k)[:, :, None], 2)[:, :, 0] for k in (-1, 0, 1))
    bend = left - 2 * middle + right
    shift = np.where((best == inner) & (bend > 0), 0.5 * (left - right) / np.maximum(bend, 1), 0)
    return np.asarray(best + shift.clip(-0.5, 0.5))
