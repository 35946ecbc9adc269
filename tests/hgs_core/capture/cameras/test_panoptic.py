"""The PanopticSports loader, and everything that can be wrong with a folder."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture

Edit = Callable[[Callable[[dict[str, Any]], None]], None]


def test_pictures_masks_and_cameras(panoptic: Path) -> None:
    capture = open_capture(panoptic)
    assert [camera.name for camera in capture.cameras] == ["3", "17"]
    np.testing.assert_allclose(capture.cameras[1].position, [1, 0, 0])
    np.testing.assert_allclose(capture.times, np.arange(6) / 30)
    assert round(float(capture.frame(1, 2).mean())) == 100
    mask = capture.mask(1, 2)
    assert mask is not None
    assert np.argwhere(mask)[0].tolist() == [10, 7]


def test_intrinsics_keep_pixel_centres_at_a_half(panoptic: Path) -> None:
    pixel, _ = open_capture(panoptic).cameras[0].project(np.array([[0.0, 0.0, 2.0]]))
    np.testing.assert_allclose(pixel[0], [32.5, 23.5])


def test_cameras_that_others_score_with_belong_to_the_capture(panoptic: Path) -> None:
    move_to_test_meta(panoptic, 1)
    capture = open_capture(panoptic)
    assert [camera.name for camera in capture.cameras] == ["3", "17"]
    assert round(float(capture.frame(1, 2).mean())) == 100
    assert capture.notes[0].endswith("--hold-out 17 keeps them for scores")


def test_test_meta_without_its_pictures_is_left_aside(panoptic: Path) -> None:
    move_to_test_meta(panoptic, 1)
    shutil.rmtree(panoptic / "ims" / "17")
    capture = open_capture(panoptic)
    assert [camera.name for camera in capture.cameras] == ["3"]
    assert "test_meta.json is left aside: its pictures are not there" in capture.notes


def test_missing_picture_of_test_meta_is_named(panoptic: Path) -> None:
    move_to_test_meta(panoptic, 1)
    (panoptic / "ims" / "17" / "000004.jpg").unlink()
    with pytest.raises(InputError, match=r"000004\.jpg: camera 17 has no picture for frame 4"):
        open_capture(panoptic)


def test_camera_in_both_files(panoptic: Path) -> None:
    shutil.copy(panoptic / "train_meta.json", panoptic / "test_meta.json")
    with pytest.raises(InputError, match=r"test_meta\.json: camera 3 is in train_meta\.json, too"):
        open_capture(panoptic)


def move_to_test_meta(panoptic: Path, column: int) -> None:
    """Take a camera out of train_meta.json and give it to a test_meta.json of its own."""
    train = json.loads((panoptic / "train_meta.json").read_text())
    test = dict(train)
    for field in ("k", "w2c", "fn", "cam_id"):
        test[field] = [row[column : column + 1] for row in train[field]]
        train[field] = [row[:column] + row[column + 1 :] for row in train[field]]
    (panoptic / "train_meta.json").write_text(json.dumps(train))
    (panoptic / "test_meta.json").write_text(json.dumps(test))


def test_real_capture_reprojects_a_known_point(test_data: Callable[[str], Path]) -> None:
    """The cameras of the ring all look inwards: the point nearest to their axes is in front of and inside all."""
    capture = open_capture(test_data("panoptic_basketball"))
    axes = np.array([camera.world_to_camera[2, :3] for camera in capture.cameras])
    centres = np.array([camera.position for camera in capture.cameras])
    projectors = np.eye(3) - axes[:, :, None] * axes[:, None]
    focus = np.linalg.solve(projectors.sum(0), (projectors @ centres[:, :, None]).sum(0)[:, 0])
    for camera in capture.cameras:
        pixel, depth = camera.project(focus[None])
        assert depth[0] > 0
        assert 0 <= pixel[0, 0] < camera.width
        assert 0 <= pixel[0, 1] < camera.height


def test_missing_picture_is_named(panoptic: Path) -> None:
    (panoptic / "ims" / "17" / "000004.jpg").unlink()
    with pytest.raises(InputError, match=r"000004\.jpg: camera 17 has no picture for frame 4"):
        open_capture(panoptic)


def test_missing_mask_is_named(panoptic: Path) -> None:
    (panoptic / "seg" / "3" / "000001.png").unlink()
    with pytest.raises(InputError, match=r"seg/3: the mask of frame 1 is missing"):
        open_capture(panoptic)


def test_without_masks_there_are_none(panoptic: Path) -> None:
    for path in (panoptic / "seg" / "3").iterdir():
        path.unlink()
    (panoptic / "seg" / "3").rmdir()
    assert open_capture(panoptic).mask(0, 0) is None


def test_empty_picture_is_found_when_opened(panoptic: Path) -> None:
    (panoptic / "ims" / "3" / "000005.jpg").write_bytes(b"")
    with pytest.raises(InputError, match=r"000005\.jpg: the file is empty"):
        open_capture(panoptic)


def test_damaged_picture_is_found_at_first_use(panoptic: Path) -> None:
    path = panoptic / "ims" / "3" / "000002.jpg"
    whole = path.read_bytes()
    path.write_bytes(whole[: whole.index(b"\xff\xda") + 14])  # nothing after the beginning of its scan
    capture = open_capture(panoptic)
    with pytest.raises(InputError, match=r"000002\.jpg: the picture is unreadable"):
        capture.frame(0, 2)


@pytest.mark.parametrize("frame", [0, 3])
def test_picture_of_a_wrong_size(panoptic: Path, frame: int) -> None:
    Image.new("RGB", (32, 24)).save(panoptic / "ims" / "3" / f"{frame:06d}.jpg")
    problem = rf"{frame:06d}\.jpg: the picture is 32x24; other pictures of camera 3 have 64x48"
    with pytest.raises(InputError, match=problem):
        open_capture(panoptic)


@pytest.mark.parametrize(
    ("content", "message"), [("{", "unreadable"), ("[]", "holds a list"), ("{}", "'w' is missing"), ("", "unreadable")]
)
def test_damaged_meta_file(panoptic: Path, content: str, message: str) -> None:
    (panoptic / "train_meta.json").write_text(content)
    with pytest.raises(InputError, match=rf"train_meta\.json: .*{message}"):
        open_capture(panoptic)


def drop_camera(meta: dict[str, Any]) -> None:
    for field in ("k", "w2c", "fn", "cam_id"):
        meta[field][4] = meta[field][4][:1]


def move_camera(meta: dict[str, Any]) -> None:
    meta["w2c"][3][1][0][3] += 0.01


def nan_pose(meta: dict[str, Any]) -> None:
    meta["w2c"][2][0][1][3] = float("nan")


def mirror(meta: dict[str, Any]) -> None:
    for row in meta["w2c"]:
        row[0][1][1] = -1.0


def skew(meta: dict[str, Any]) -> None:
    for row in meta["k"]:
        row[1][0][1] = 5.0


def shorten(meta: dict[str, Any]) -> None:
    meta["k"] = meta["k"][:-1]


def text_pose(meta: dict[str, Any]) -> None:
    meta["w2c"][0][0][0][0] = "one"


def no_frames(meta: dict[str, Any]) -> None:
    for field in ("k", "w2c", "fn", "cam_id"):
        meta[field] = []


def stray_picture(meta: dict[str, Any]) -> None:
    meta["fn"][2][1] = "../../secret.jpg"


def bad_width(meta: dict[str, Any]) -> None:
    meta["w"] = "wide"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (drop_camera, "frame 4 lists 1 camera and frame 0 lists 2.*17"),
        (move_camera, "camera 17: w2c changes at frame 3.*fixed cameras"),
        (nan_pose, "camera 3: w2c of frame 2 holds NaN"),
        (mirror, "1 of 2 poses are reflections.*camera 3"),
        (skew, "camera 17: k has a skew"),
        (shorten, "k has 5 frames and fn has 6"),
        (text_pose, "not a matrix of numbers"),
        (no_frames, "lists no picture"),
        (bad_width, "w is 'wide'"),
        (stray_picture, r"secret\.jpg', outside ims/"),
    ],
)
def test_inconsistent_meta_file(
    panoptic: Path, edit_meta: Edit, change: Callable[[dict[str, Any]], None], message: str
) -> None:
    edit_meta(change)
    with pytest.raises(InputError, match=message):
        open_capture(panoptic)
