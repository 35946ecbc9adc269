"""COLMAP's models as cameras: one image for each camera, a folder for each, or a model for each frame."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.colmap import COLMAP
from hgs_core.capture.cameras.rig import Rig
from hgs_core.capture.open import open_capture
from tests.hgs_core.capture import layouts
from tests.hgs_core.capture.layouts import FRAMES, PICTURES


def read(root: Path) -> Rig:
    file = COLMAP.find(root)
    assert file is not None
    return COLMAP.read(root, file)


def write_text(
    folder: Path, poses: dict[str, tuple[float, float, float]], model: str = "PINHOLE 48 32 40 40 24 16"
) -> None:
    """Cameras that look along z, by the names of their images and their translations."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "cameras.txt").write_text(f"# a comment\n1 {model}\n")
    lines = [f"{i} 1 0 0 0 {x} {y} {z} 1 {name}\n\n" for i, (name, (x, y, z)) in enumerate(poses.items(), 1)]
    (folder / "images.txt").write_text("# a comment\n" + "".join(lines))


@pytest.mark.parametrize("folder", ["sparse/0", "sparse", "colmap/sparse/0", "sparse_", "."])
def test_models_are_found_where_tools_put_them(tmp_path: Path, folder: str) -> None:
    write_text(tmp_path / folder, {"a.png": (0, 0, 0), "b.png": (1, 0, 0)})
    assert [camera.names[0] for camera in read(tmp_path).cameras] == ["a", "b"]


def test_frames_of_a_folder_with_about_one_pose_are_of_one_camera(tmp_path: Path) -> None:
    write_text(
        tmp_path / "sparse/0",
        {"left/0.png": (0, 0, 0), "left/1.png": (0.0001, 0, 0), "right/0.png": (1, 0, 0), "right/1.png": (1, 0, 0)},
    )
    assert [camera.names for camera in read(tmp_path).cameras] == [("left",), ("right",)]


def test_frames_of_a_folder_with_many_poses_are_photographs(tmp_path: Path) -> None:
    write_text(tmp_path / "sparse/0", {"walk/0.png": (0, 0, 0), "walk/1.png": (0.5, 0, 0), "walk/2.png": (1, 0, 0)})
    assert [camera.names for camera in read(tmp_path).cameras] == [(f"walk/{i}", f"{i}") for i in range(3)]


def test_one_image_of_a_folder_may_be_called_like_it(tmp_path: Path) -> None:
    write_text(tmp_path / "sparse/0", {"cam01/0000.png": (0, 0, 0), "cam02/0000.png": (1, 0, 0)})
    assert read(tmp_path).cameras[0].names == ("cam01/0000", "cam01", "0000")


def test_models_of_every_frame_must_agree(tmp_path: Path) -> None:
    layouts.colmap_of_every_frame(tmp_path)
    PICTURES["moments"](tmp_path)
    assert len(open_capture(tmp_path).times) == FRAMES
    write_text(tmp_path / "colmap_3/sparse/0", {"cam01.png": (0, 0, 0)})
    for name in ("cameras.bin", "images.bin"):
        (tmp_path / "colmap_3/sparse/0" / name).unlink()
    with pytest.raises(InputError, match=r"colmap_3/sparse/0/images\.txt: cam\d+\.png is in .*; every frame needs"):
        open_capture(tmp_path)


def test_a_camera_that_moves_between_frames_is_named(tmp_path: Path) -> None:
    for frame in range(3):
        write_text(tmp_path / f"colmap_{frame}/sparse/0", {"a.png": (0, 0, 0), "b.png": (1 + 0.1 * frame, 0, 0)})
    with pytest.raises(InputError, match=r"colmap_1.*the camera of b\.png is not where colmap_0/sparse/0 has it"):
        read(tmp_path)


def test_captures_in_numbered_folders_are_not_frames(tmp_path: Path) -> None:
    for number in range(2):
        write_text(tmp_path / f"scan{number}/sparse/0", {"a.png": (0, 0, 0)})
    assert COLMAP.find(tmp_path) is None


def test_a_distorted_video_is_straightened(tmp_path: Path) -> None:
    layouts.colmap(True, model="OPENCV_FISHEYE", bends=(0.02, 0.001, 0.0, 0.0))(tmp_path)
    PICTURES["videos"](tmp_path)
    capture = open_capture(tmp_path)
    camera = capture.cameras[0]
    assert capture.frame(0, 1).shape == (camera.height, camera.width, 3)
    assert camera.width > layouts.WIDTH  # a fisheye's edges are far apart in a straight picture
    assert np.ptp(capture.frame(0, 1)) <= 1  # no black borders


def test_a_panorama_is_refused(tmp_path: Path) -> None:
    write_text(tmp_path / "sparse/0", {"a.png": (0, 0, 0)}, "EQUIRECTANGULAR 48 24 48 24")
    with pytest.raises(InputError, match=r"image a\.png: .*EQUIRECTANGULAR is a panorama"):
        read(tmp_path)


PLACES = {f"cam{i}.png": (i % 3, i // 3, 0) for i in range(6)}


def without_cameras(count: int) -> dict[str, tuple[float, float, float]]:
    return dict(list(PLACES.items())[count:])


@pytest.mark.parametrize("order", list(itertools.permutations(range(4)))[::5])
@pytest.mark.parametrize("folder", ["sparse", "colmap/sparse"])
def test_the_model_with_most_cameras_counts_whatever_its_number(
    tmp_path: Path, order: tuple[int, ...], folder: str
) -> None:
    """Structure from motion writes unconnected parts as models of their own, in no particular order."""
    models = [PLACES, without_cameras(4), without_cameras(3), {"x.png": (0, 0, 0), "y.png": (1, 0, 0)}]
    for number, which in enumerate(order):
        write_text(tmp_path / folder / str(number), models[which])
    for name in PLACES:
        (tmp_path / name).with_suffix(".mp4").touch()
    rig = read(tmp_path)
    assert [camera.names[0] for camera in rig.cameras] == [name[:-4] for name in PLACES]
    assert rig.notes[0].startswith(f"the cameras are those of {folder}/{order.index(0)} (6 cameras); ")
    assert rig.notes[0].endswith("is left aside")


def test_cameras_with_footage_count_for_more_than_others(tmp_path: Path) -> None:
    write_text(tmp_path / "sparse/0", {f"other{i}.png": (i, 0, 0) for i in range(9)})
    write_text(tmp_path / "sparse/1", PLACES)
    for name in PLACES:
        (tmp_path / name).with_suffix(".mp4").touch()
    assert len(read(tmp_path).cameras) == 6


def test_a_damaged_model_is_left_aside_where_another_is_whole(tmp_path: Path) -> None:
    write_text(tmp_path / "sparse/0", PLACES)
    (tmp_path / "sparse/0/images.txt").write_text("1 2 3\n")
    write_text(tmp_path / "sparse/1", PLACES)
    assert len(read(tmp_path).cameras) == 6
    (tmp_path / "sparse/1/images.txt").write_text("1 2 3\n")
    with pytest.raises(InputError, match=r"images\.txt: unreadable"):
        read(tmp_path)


def test_the_median_of_a_camera_s_poses_counts_and_their_spread_is_said(tmp_path: Path) -> None:
    offsets = (0.0001, -0.0001, 0.0, 0.0004, 0.0)
    poses = {f"{name}/{i}.png": (x + d, 0.0, 0.0) for name, x in (("a", 0), ("b", 1)) for i, d in enumerate(offsets)}
    write_text(tmp_path / "sparse/0", poses)
    rig = read(tmp_path)
    assert [camera.world_to_camera[0, 3] for camera in rig.cameras] == pytest.approx([0, 1])
    assert "differ by up to 0 degrees and 0.0003 units of length" in rig.notes[0]


def test_an_image_that_was_placed_elsewhere_is_named_and_the_cure_cures(tmp_path: Path) -> None:
    poses = {f"{name}/{i}.png": (float(x), 0.0, 0.0) for name, x in (("a", 0), ("b", 1)) for i in range(5)}
    write_text(tmp_path / "sparse/0", poses | {"b/3.png": (7.0, 0.0, 0.0)})
    with pytest.raises(InputError, match=r"images.txt: b/3.png has another pose than most .* its two lines of images"):
        read(tmp_path)
    del poses["b/3.png"]
    write_text(tmp_path / "sparse/0", poses)
    assert [camera.names for camera in read(tmp_path).cameras] == [("a",), ("b",)]


@pytest.mark.parametrize(
    "name", ["cam{}\\0000.png", "C:\\scan\\cam{}\\0000.png", "cam{}.png", "/data/scan/images/cam{}.png"]
)
def test_names_of_windows_and_of_other_machines_are_cameras(tmp_path: Path, name: str) -> None:
    write_text(tmp_path / "sparse/0", {name.format(i): (i, 0, 0) for i in range(4)})
    layouts.videos(names=[f"CAM{i}" for i in range(4)])(tmp_path)
    assert [camera.name.lower() for camera in open_capture(tmp_path).cameras] == [f"cam{i}" for i in range(4)]
