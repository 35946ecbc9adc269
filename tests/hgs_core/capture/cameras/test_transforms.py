"""The nerfstudio / instant-ngp loader: axes, intrinsics, missing pictures, and real photographs' epipolar lines."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.transforms_frame import camera_of_frame
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.points.features import Features, extract_features, fundamental_matrix
from hgs_core.scene.camera import Camera
from tests.hgs_core.capture import layouts

Edit = Callable[[dict[str, Any]], None]


@pytest.fixture
def photographs(tmp_path: Path) -> Path:
    """Three grey photographs from cameras that look along the world's -z, one unit apart along x."""
    root = tmp_path / "photographs"
    (root / "images").mkdir(parents=True)
    frames = []
    for number in range(3):
        Image.new("RGB", (64, 48), (40 * (number + 1),) * 3).save(root / "images" / f"{number:04d}.png")
        pose = np.eye(4)
        pose[0, 3] = number
        frames.append({"file_path": f"images/{number:04d}.png", "transform_matrix": pose.tolist()})
    meta = {"fl_x": 50.0, "fl_y": 52.0, "cx": 31.0, "cy": 25.0, "w": 64, "h": 48, "frames": frames}
    (root / "transforms.json").write_text(json.dumps(meta))
    return root


def edit(root: Path, change: Edit) -> None:
    path = root / "transforms.json"
    meta = json.loads(path.read_text())
    change(meta)
    path.write_text(json.dumps(meta))


def test_a_capture_of_one_moment_with_a_camera_per_photograph(photographs: Path) -> None:
    capture = open_capture(photographs)
    assert [camera.name for camera in capture.cameras] == ["0000", "0001", "0002"]
    assert capture.times.tolist() == [0.0]
    assert [int(capture.frame(i, 0)[0, 0, 0]) for i in range(3)] == [40, 80, 120]
    assert capture.notes == ()


def test_opengl_axes_become_opencv_axes(photographs: Path) -> None:
    """A point right of (+x), above (+y) and in front of (-z) an OpenGL camera lands right of and above its centre."""
    camera = open_capture(photographs).cameras[1]
    pixel, depth = camera.project(np.array([[1.2, 0.1, -2.0]]))
    np.testing.assert_allclose(pixel[0], [31 + 50 * 0.1, 25 - 52 * 0.05])
    assert depth[0] == pytest.approx(2.0)
    np.testing.assert_allclose(camera.position, [1, 0, 0], atol=1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_mirrored_axis_is_refused(photographs: Path, axis: int) -> None:
    def mirror(meta: dict[str, Any]) -> None:
        pose = np.array(meta["frames"][0]["transform_matrix"])
        pose[:, axis] *= -1
        meta["frames"][0]["transform_matrix"] = pose.tolist()

    edit(photographs, mirror)
    with pytest.raises(InputError, match=r"1 of 3 poses are reflections.*frame 0"):
        open_capture(photographs)


def test_frames_without_a_picture_are_left_out_and_named(photographs: Path) -> None:
    (photographs / "images" / "0001.png").unlink()
    capture = open_capture(photographs)
    assert [camera.name for camera in capture.cameras] == ["0000", "0002"]
    assert len(capture.notes) == 1
    assert "1 of the 3 pictures that transforms.json lists are not there and left out: 0001.png" in capture.notes[0]


def test_no_picture_at_all_is_refused(photographs: Path) -> None:
    for picture in (photographs / "images").iterdir():
        picture.unlink()
    with pytest.raises(InputError, match="none of its 3 pictures is there"):
        open_capture(photographs)


def test_a_frame_s_own_intrinsics_win(photographs: Path) -> None:
    edit(photographs, lambda meta: meta["frames"][2].update(fl_x=70.0, cx=30.0))
    cameras = open_capture(photographs).cameras
    assert (cameras[2].fx, cameras[2].fy, cameras[2].cx) == (70.0, 52.0, 30.0)
    assert cameras[1].fx == 50.0


def test_intrinsics_of_another_resolution_are_scaled(photographs: Path) -> None:
    edit(photographs, lambda meta: meta.update(w=640, h=480))
    camera = open_capture(photographs).cameras[0]
    assert (camera.fx, camera.cx, camera.width) == (5.0, 3.1, 64)


def test_the_angle_of_view_will_do(photographs: Path) -> None:
    def angle(meta: dict[str, Any]) -> None:
        for name in ("fl_x", "fl_y", "cx", "cy"):
            del meta[name]
        meta["camera_angle_x"] = 2 * math.atan(32 / 45)

    edit(photographs, angle)
    camera = open_capture(photographs).cameras[0]
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == pytest.approx((45, 45, 32, 24))


def test_a_distorted_photograph_is_straightened(photographs: Path) -> None:
    edit(photographs, lambda meta: meta.update(k1=0.1, p1=0.001))
    capture = open_capture(photographs)
    camera = capture.cameras[0]
    assert camera.width < 64
    assert capture.frame(0, 0).shape == (camera.height, camera.width, 3)
    assert (capture.frame(0, 0) == 40).all()  # no black borders


def test_a_photograph_is_held_out_by_its_file_name_too(photographs: Path) -> None:
    capture = open_capture(photographs)
    assert capture.camera_index("0002") == capture.camera_index("0002.png") == capture.camera_index("images/0002.png")


def test_equal_names_in_two_folders_keep_their_folders(photographs: Path) -> None:
    (photographs / "more").mkdir()
    (photographs / "images" / "0001.png").rename(photographs / "more" / "0000.png")
    edit(photographs, lambda meta: meta["frames"][1].update(file_path="more/0000.png"))
    names = [camera.name for camera in open_capture(photographs).cameras]
    assert names == ["images/0000", "more/0000", "images/0002"]


def test_masks_of_one_moment_are_not_used(photographs: Path) -> None:
    (photographs / "masks" / "0000").mkdir(parents=True)
    Image.new("L", (64, 48), 255).save(photographs / "masks" / "0000" / "0000.png")
    capture = open_capture(photographs)
    assert capture.mask(0, 0) is None
    assert "the masks are not used" in capture.notes[-1]


def test_the_fingerprint_follows_poses_and_pictures(photographs: Path) -> None:
    before = open_capture(photographs).fingerprint()
    edit(photographs, lambda meta: meta.update(cx=31.5))
    changed = open_capture(photographs).fingerprint()
    assert changed != before
    (photographs / "images" / "0001.png").unlink()
    assert open_capture(photographs).fingerprint() not in (before, changed)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda meta: meta.update(frames=[]), "frames is not a list"),
        (lambda meta: meta.update(camera_model="EQUIRECTANGULAR"), "camera_model is EQUIRECTANGULAR"),
        (lambda meta: meta.update(w=48, h=64), "the camera is for 48x64 pixels and the pictures have 64x48"),
        (lambda meta: meta.update(fl_x=-50.0), "not positive"),
        (lambda meta: meta.update(fl_x="fifty"), "fl_x is 'fifty'"),
        (lambda meta: meta.update(k1=math.nan), "k1 is nan"),
        (lambda meta: meta.pop("fl_x"), "neither fl_x nor camera_angle_x"),
        (lambda meta: meta["frames"][1].pop("transform_matrix"), "frame 1.*transform_matrix"),
        (lambda meta: meta["frames"][1].update(transform_matrix=[[1]]), "not a finite 4x4"),
        (lambda meta: meta["frames"][1].pop("file_path"), "frame 1.*file_path is None"),
        (lambda meta: meta["frames"][0].update(file_path="../secret.png"), "outside the capture"),
        (lambda meta: meta["frames"][0].update(file_path="/etc/secret.png"), "outside the capture"),
        (
            lambda meta: [f.update(time=i) for i, f in enumerate(meta["frames"])],
            "3 frames are each from another place: one camera that moves",
        ),
    ],
)
def test_bad_values_are_named(photographs: Path, change: Edit, problem: str) -> None:
    edit(photographs, change)
    with pytest.raises(InputError, match=problem):
        open_capture(photographs)


def test_unreadable_files_are_named(photographs: Path) -> None:
    (photographs / "images" / "0001.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"0001\.png: the picture is unreadable: of no known kind"):
        open_capture(photographs)
    (photographs / "transforms.json").write_text("{")
    with pytest.raises(InputError, match=r"transforms\.json: unreadable"):
        open_capture(photographs)


@pytest.mark.parametrize("file", ["transforms.json", "transforms_train.json"])
def test_one_camera_that_moves_is_out_of_scope(photographs: Path, file: str) -> None:
    """D-NeRF's frames have times, Blender's splits have none."""
    if file == "transforms.json":
        edit(photographs, lambda meta: [f.update(time=i / 2) for i, f in enumerate(meta["frames"])])
    (photographs / "transforms.json").rename(photographs / file)
    problem = r"3 frames are each from another place: one camera that moves \(D-NeRF, Blender\); HGS needs several"
    with pytest.raises(InputError, match=problem):
        open_capture(photographs)


def test_splits_of_fixed_cameras_are_one_capture(tmp_path: Path) -> None:
    pattern = "images/{camera}/{frame}.png"
    layouts.folders(pattern)(tmp_path)
    frames = layouts.frames_of_pictures(pattern, lambda frame: frame / 10)
    layouts.transforms(frames[: layouts.FRAMES], "transforms_test.json")(tmp_path)
    layouts.transforms(frames[layouts.FRAMES :], "transforms_train.json")(tmp_path)
    capture = open_capture(tmp_path)
    assert [camera.name for camera in capture.cameras] == list(layouts.NAMES)
    assert len(capture.times) == layouts.FRAMES


def test_a_frame_may_name_a_video(tmp_path: Path) -> None:
    layouts.videos("scene")(tmp_path)
    layouts.transforms(layouts.frames_of_videos("scene/"))(tmp_path)
    capture = open_capture(tmp_path)
    assert [camera.name for camera in capture.cameras] == list(layouts.NAMES)
    assert len(capture.times) == layouts.FRAMES


def test_one_picture_of_each_folder_stands_for_the_folder(tmp_path: Path) -> None:
    pattern = "images/{camera}/{frame}.png"
    layouts.folders(pattern)(tmp_path)
    layouts.transforms(layouts.frames_of_pictures(pattern)[:: layouts.FRAMES])(tmp_path)
    assert len(open_capture(tmp_path).times) == layouts.FRAMES


def test_times_that_are_missing_in_part_are_refused(tmp_path: Path) -> None:
    pattern = "images/{camera}/{frame}.png"
    layouts.folders(pattern)(tmp_path)
    frames = layouts.frames_of_pictures(pattern, lambda frame: frame / 10)
    del frames[7]["time"]
    layouts.transforms(frames)(tmp_path)
    with pytest.raises(InputError, match="some frames have a time and some have none"):
        open_capture(tmp_path)


def test_a_picture_that_is_missing_at_its_time_leaves_out_the_moment(tmp_path: Path) -> None:
    pattern = "images/{camera}/{frame}.png"
    layouts.folders(pattern)(tmp_path)
    layouts.transforms(layouts.frames_of_pictures(pattern, lambda frame: frame / 10))(tmp_path)
    (tmp_path / "images" / "cam02" / "2.png").unlink()
    capture = open_capture(tmp_path)
    np.testing.assert_allclose(capture.times, np.array([0, 1, 3, 4]) / 30)
    assert "1 of the 20 pictures that transforms.json lists are not there and left out: 2.png" in capture.notes


PAIRS = ((0, 1), (10, 12), (40, 41))


@pytest.fixture(scope="module")
def fox(test_data: Callable[[str], Path]) -> Capture:
    return open_capture(test_data("fox"), downscale=2)


@pytest.fixture(scope="module")
def matches(fox: Capture) -> list[tuple[np.ndarray, np.ndarray]]:
    """Pixels of the same points in pairs of photographs, by descriptors alone: poses play no part."""
    found = {i: extract_features(fox.frame(i, 0)) for pair in PAIRS for i in pair}
    return [_mutual(found[a], found[b]) for a, b in PAIRS]


def _mutual(first: Features, second: Features) -> tuple[np.ndarray, np.ndarray]:
    likeness = first.descriptors @ second.descriptors.T
    best, rows = likeness.argmax(axis=1), np.arange(len(likeness))
    kept = (likeness.argmax(axis=0)[best] == rows) & (likeness.max(axis=1) > 0.9 * 512**2)
    return first.xy[rows[kept]], second.xy[best[kept]]


def _epipolar_error(first: Camera, second: Camera, a: np.ndarray, b: np.ndarray) -> float:
    """Median distance of b from the epipolar lines of a, pixels."""
    lines = np.column_stack((a, np.ones(len(a)))) @ fundamental_matrix(first, second).T
    gaps = (lines * np.column_stack((b, np.ones(len(b))))).sum(axis=1) / np.hypot(lines[:, 0], lines[:, 1])
    return float(np.median(np.abs(gaps)))


def _errors(cameras: list[Camera], matches: list[tuple[np.ndarray, np.ndarray]]) -> list[float]:
    pairs = zip(PAIRS, matches, strict=True)
    return [_epipolar_error(cameras[i], cameras[j], a, b) for (i, j), (a, b) in pairs]


@pytest.mark.data
def test_fox_leaves_out_what_is_not_there(fox: Capture) -> None:
    assert len(fox.cameras) == 50
    assert "17 of the 67 pictures" in fox.notes[0]
    assert fox.frame(0, 0).shape == (fox.cameras[0].height, fox.cameras[0].width, 3)
    assert 530 <= fox.cameras[0].width <= 540


@pytest.mark.data
def test_fox_features_lie_on_their_epipolar_lines(fox: Capture, matches: list[tuple[np.ndarray, np.ndarray]]) -> None:
    assert min(len(a) for a, _ in matches) > 100
    assert max(_errors(list(fox.cameras), matches)) < 0.5  # half-size pixels: 1 px of the photographs


@pytest.mark.data
@pytest.mark.parametrize("signs", [(-1, -1, 1), (1, -1, -1), (-1, 1, -1)])
def test_fox_with_two_mirrored_axes_would_not_pass(
    fox: Capture, matches: list[tuple[np.ndarray, np.ndarray]], signs: tuple[int, int, int], test_data: Any
) -> None:
    """One mirrored axis is refused as a reflection; two make a rotation, which features must find wrong."""
    frames = {f["file_path"]: f for f in json.loads((test_data("fox") / "transforms.json").read_text())["frames"]}
    turned = []
    for camera in fox.cameras:
        pose = np.array(frames[f"images/{camera.name}.jpg"]["transform_matrix"])
        pose[:3, :3] *= signs
        values = {"fl_x": camera.fx, "fl_y": camera.fy, "cx": camera.cx, "cy": camera.cy, "transform_matrix": pose}
        fixed = camera_of_frame(values, (camera.width, camera.height), camera.name)
        turned.append(fixed.camera(camera.name, camera.width, camera.height))
    assert min(_errors(turned, matches)) > 3


PATTERN = "images/{camera}/{frame:04d}.png"


def timed_frames() -> list[dict[str, Any]]:
    return layouts.frames_of_pictures(PATTERN, lambda frame: frame / 30)


@pytest.mark.parametrize("times", ["times", "no times", "one folder"])
def test_poses_that_jitter_are_one_camera_and_their_median_counts(tmp_path: Path, times: str) -> None:
    pattern = "images/{camera}_{frame:04d}.png" if times == "one folder" else PATTERN
    layouts.folders(pattern)(tmp_path)
    frames = layouts.frames_of_pictures(pattern, None if times == "no times" else lambda frame: frame / 30)
    chance = np.random.default_rng(0)
    for frame in frames:
        pose = np.array(frame["transform_matrix"])
        turn = np.eye(3) + np.cross(np.eye(3), chance.normal(0, 1e-4, 3))
        pose[:3, :3] = np.linalg.qr(turn)[0] @ np.diag(np.sign(np.diag(np.linalg.qr(turn)[1]))) @ pose[:3, :3]
        pose[:3, 3] += chance.normal(0, 2e-4, 3)
        frame["transform_matrix"] = pose.tolist()
    layouts.transforms(frames)(tmp_path)
    capture = open_capture(tmp_path)
    assert (len(capture.cameras), len(capture.times)) == (4, layouts.FRAMES)
    for camera, true in zip(capture.cameras, layouts.truth(), strict=True):
        np.testing.assert_allclose(camera.world_to_camera, true.world_to_camera, atol=2e-3)
    assert sum("from picture to picture; their median is taken" in note for note in capture.notes) == 1


@pytest.mark.parametrize("away", [0.1, 1e4])
def test_a_picture_that_was_placed_elsewhere_is_named_and_the_cure_cures(tmp_path: Path, away: float) -> None:
    layouts.folders(PATTERN)(tmp_path)
    frames = timed_frames()
    astray = layouts.FRAMES + 2  # third picture of the second camera
    frames[astray]["transform_matrix"] = np.array(frames[astray]["transform_matrix"])
    frames[astray]["transform_matrix"][:3, 3] += away
    frames[astray]["transform_matrix"] = frames[astray]["transform_matrix"].tolist()
    layouts.transforms(frames)(tmp_path)
    with pytest.raises(InputError, match=r"images/cam02/0002.png' has another pose than most pictures of its folder;"):
        open_capture(tmp_path)
    del frames[astray]
    layouts.transforms(frames)(tmp_path)
    capture = open_capture(tmp_path)
    assert (len(capture.cameras), len(capture.times)) == (4, layouts.FRAMES - 1)


@pytest.mark.parametrize("step", [0.0005, 0.02])
def test_a_camera_that_moves_slowly_is_no_rig(tmp_path: Path, step: float) -> None:
    """Neighbours on its way are as near as poses that jitter; they are no cameras that last."""
    layouts.folders(PATTERN)(tmp_path)
    frames = timed_frames()[: layouts.FRAMES]
    for number, frame in enumerate(frames):
        frame["transform_matrix"][0][3] += step * number
    layouts.transforms(frames)(tmp_path)
    with pytest.raises(InputError, match="one camera that moves"):
        open_capture(tmp_path)


def test_two_pictures_at_one_time_are_refused_and_both_cures_cure(tmp_path: Path) -> None:
    layouts.folders(PATTERN)(tmp_path)
    frames = timed_frames()
    frames[3]["time"] = frames[2]["time"]
    layouts.transforms(frames)(tmp_path)
    problem = (
        r"transforms\.json: 0002\.png and 0003\.png of cam01 both have the time 0\.0666667; correct one of them, or re"
    )
    with pytest.raises(InputError, match=problem):
        open_capture(tmp_path)
    layouts.transforms([{key: frame[key] for key in frame if key != "time"} for frame in frames])(tmp_path)
    assert len(open_capture(tmp_path).times) == layouts.FRAMES
    layouts.transforms(timed_frames())(tmp_path)
    assert len(open_capture(tmp_path).times) == layouts.FRAMES
