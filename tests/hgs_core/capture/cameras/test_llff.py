"""The N3DV layout: geometry against the sample's own cameras.json, and everything that can be wrong with a folder."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.llff import camera_of_row
from hgs_core.capture.open import open_capture
from hgs_core.scene.camera import Camera

SAMPLE = Path(__file__).resolve().parents[4] / "samples" / "studio"


def truth_cameras() -> list[Camera]:
    """The cameras as the renderer wrote them, which the loader never reads."""
    meta = json.loads((SAMPLE / "cameras.json").read_text())
    return [
        Camera(c["name"], meta["width"], meta["height"], c["fx"], c["fy"], c["cx"], c["cy"], np.array(c["w2c"]))
        for c in meta["cameras"]
    ]


def test_sample_cameras_project_as_the_renderer_says() -> None:
    capture = open_capture(SAMPLE)
    points = np.random.default_rng(0).uniform((-1, 0, 0.3), (1, 1.5, 2), (50, 3))
    for camera, truth in zip(capture.cameras, truth_cameras(), strict=True):
        assert camera.name == truth.name
        np.testing.assert_allclose(camera.project(points)[0], truth.project(points)[0], atol=1e-3)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_flipped_axis_would_not_pass(axis: int) -> None:
    """The projection test has teeth: poses with one axis mirrored are refused or land elsewhere."""
    row = np.load(SAMPLE / "poses_bounds.npy")[0]
    flipped = row.copy()
    flipped[:15].reshape(3, 5)[:, axis] *= -1
    with pytest.raises(InputError, match="reflection"):
        camera_of_row(flipped, "row 0").camera("cam00", 512, 384)
    flipped[:15].reshape(3, 5)[:, (axis + 1) % 3] *= -1  # two mirrored axes are a rotation again
    turned = camera_of_row(flipped, "row 0").camera("cam00", 512, 384)
    point = np.array([[0.3, 1.0, 1.2]])
    pixel, depth = turned.project(point)
    assert depth[0] < 0 or np.abs(pixel - truth_cameras()[0].project(point)[0]).max() > 5


def test_known_point_lands_right_of_and_below_the_centre(n3dv: Path) -> None:
    camera = open_capture(n3dv).cameras[0]
    pixel, depth = camera.project(np.array([[0.2, 0.1, 2.0]]))  # right (+x) and down (+y) of an OpenCV camera
    np.testing.assert_allclose(pixel[0], [32 + 50 * 0.1, 24 + 50 * 0.05])
    assert depth[0] == pytest.approx(2.0)


def test_principal_point_is_the_middle_of_the_picture(n3dv: Path) -> None:
    camera = open_capture(n3dv).cameras[0]
    assert (camera.cx, camera.cy) == (32.0, 24.0)  # pixel centres at +0.5: the middle of 64 pixels is 32, not 31.5


def test_poses_of_another_resolution_are_scaled(n3dv: Path) -> None:
    poses = np.load(n3dv / "poses_bounds.npy")
    poses[:, 4], poses[:, 9], poses[:, 14] = 480, 640, 500
    np.save(n3dv / "poses_bounds.npy", poses)
    camera = open_capture(n3dv).cameras[0]
    assert (camera.width, camera.height, camera.fx, camera.fy) == (64, 48, 50, 50)


def test_masks_beside_the_videos_are_given_masks(n3dv: Path) -> None:
    folder = n3dv / "masks" / "cam01"
    folder.mkdir(parents=True)
    for frame in range(6):
        mask = np.zeros((48, 64), np.uint8)
        mask[frame, 2] = 13
        Image.fromarray(mask).save(folder / f"{frame:04d}.png")
    capture = open_capture(n3dv)
    given = capture.mask(1, 4)
    assert capture.mask(0, 4) is None
    assert given is not None
    assert np.argwhere(given).tolist() == [[4, 2]]
    (folder / "0003.png").unlink()
    with pytest.raises(InputError, match="mask of frame 3 is missing"):
        open_capture(n3dv)


def test_times_follow_the_frame_rate(n3dv: Path) -> None:
    np.testing.assert_allclose(open_capture(n3dv).times, np.arange(6) / 30)


def test_missing_video_and_missing_poses(n3dv: Path) -> None:
    shutil.move(n3dv / "cam01.mp4", n3dv / "elsewhere.mp4")
    (n3dv / "elsewhere.mp4").rename(n3dv / "elsewhere.mp4.part")
    with pytest.raises(InputError, match=r"2 poses for 1 video \(cam00\)"):
        open_capture(n3dv)
    (n3dv / "cam00.mp4").unlink()
    (n3dv / "elsewhere.mp4.part").unlink()
    with pytest.raises(InputError, match=r"poses_bounds\.npy\) but no videos and no folders of pictures; put each"):
        open_capture(n3dv)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "unreadable"),
        (b"\x93NUMPY garbage", "unreadable"),
    ],
)
def test_damaged_poses_file(n3dv: Path, content: bytes, message: str) -> None:
    (n3dv / "poses_bounds.npy").write_bytes(content)
    with pytest.raises(InputError, match=rf"poses_bounds\.npy: {message}"):
        open_capture(n3dv)


def test_poses_of_a_wrong_shape(n3dv: Path) -> None:
    np.save(n3dv / "poses_bounds.npy", np.zeros((2, 15)))
    with pytest.raises(InputError, match=r"\(2, 15\).*17 values"):
        open_capture(n3dv)


def test_nan_pose_names_its_row(n3dv: Path) -> None:
    poses = np.load(n3dv / "poses_bounds.npy")
    poses[1, 3] = np.nan
    np.save(n3dv / "poses_bounds.npy", poses)
    with pytest.raises(InputError, match="row 1: the pose holds NaN"):
        open_capture(n3dv)


def test_aspect_ratio_of_another_picture_is_refused(n3dv: Path) -> None:
    poses = np.load(n3dv / "poses_bounds.npy")
    poses[:, 4] = 30
    np.save(n3dv / "poses_bounds.npy", poses)
    with pytest.raises(InputError, match="64x30 pixels and the pictures have 64x48"):
        open_capture(n3dv)
