"""COLMAP's files as pycolmap writes them, and damaged ones. test_layout.py reads whole captures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.colmap_model import model_files, read_model
from tests.hgs_core.capture import layouts


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize(("model", "bends"), [("PINHOLE", ()), ("OPENCV_FISHEYE", (0.1, -0.02, 0.003, 0.0004))])
def test_what_pycolmap_writes_is_read(tmp_path: Path, binary: bool, model: str, bends: tuple[float, ...]) -> None:
    layouts.colmap(binary, ".", model, bends)(tmp_path)
    files = model_files(tmp_path)
    assert files is not None
    cameras, images = read_model(*files)
    assert [image.name for image in images] == [f"{name}.png" for name in layouts.NAMES]
    for image, true in zip(images, layouts.truth(), strict=True):
        np.testing.assert_allclose(image.world_to_camera, true.world_to_camera, atol=1e-12)
        camera = cameras[image.camera]
        assert (camera.model, camera.width, camera.height) == (model, layouts.WIDTH, layouts.HEIGHT)
        assert camera.parameters == pytest.approx((true.fx, true.fy, true.cx, true.cy, *bends))


def test_points_of_images_are_passed_over(tmp_path: Path) -> None:
    import pycolmap

    model = pycolmap.Reconstruction()
    model.add_camera_with_trivial_rig(
        pycolmap.Camera(model="SIMPLE_PINHOLE", width=8, height=6, params=[9.0, 4.0, 3.0], camera_id=7)
    )
    for number in (1, 2):
        image = pycolmap.Image(name=f"a {number}.png", keypoints=np.ones((5, 2)), camera_id=7, image_id=number)
        model.add_image_with_trivial_frame(image, pycolmap.Rigid3d())
    for write in (model.write_binary, model.write_text):
        for path in tmp_path.iterdir():
            path.unlink()
        write(str(tmp_path))
        files = model_files(tmp_path)
        assert files is not None
        assert [image.name for image in read_model(*files)[1]] == ["a 1.png", "a 2.png"]


@pytest.mark.parametrize("damage", ["cameras", "images"])
@pytest.mark.parametrize("binary", [True, False])
def test_damaged_files_are_named(tmp_path: Path, damage: str, binary: bool) -> None:
    layouts.colmap(binary, ".")(tmp_path)
    path = tmp_path / f"{damage}.{'bin' if binary else 'txt'}"
    path.write_bytes(path.read_bytes()[:60] if binary else b"1 2\n")
    files = model_files(tmp_path)
    assert files is not None
    with pytest.raises(InputError, match=rf"{path.name}: unreadable .*; export the model again"):
        read_model(*files)


@pytest.mark.parametrize(
    ("file", "content", "problem"),
    [
        ("images.txt", "", "lists no image"),
        ("images.txt", "1 1 0 0 0 0 0 0 9 a.png\n\n", "image a.png is of camera 9, which cameras.txt lacks"),
        ("images.txt", "1 0 0 0 0 0 0 0 1 a.png\n\n", "a pose is"),
        ("images.txt", "1 1 0 0 0 nan 0 0 1 a.png\n\n", "a pose is"),
    ],
)
def test_bad_values_are_named(tmp_path: Path, file: str, content: str, problem: str) -> None:
    layouts.colmap(False, ".")(tmp_path)
    (tmp_path / file).write_text(content)
    with pytest.raises(InputError, match=rf"{file}: {problem}"):
        read_model(tmp_path / "cameras.txt", tmp_path / "images.txt")


IMAGES = ["1 1 0 0 0 0 0 0 1 a.png", "2 1 0 0 0 1 0 0 1 b 1.png", "3 1 0 0 0 2 0 0 1 c", "4 1 0 0 0 3 0 0 1 0004"]
NAMES = ["0004", "a.png", "b 1.png", "c"]
POINTS = "10.5 20.5 -1 11 21 7"


@pytest.mark.parametrize(
    "points",
    [
        [""] * 4,
        [POINTS] * 4,
        [None] * 4,
        ["", POINTS, None, ""],
        [None, "", POINTS, None],
        ["  ", POINTS * 4000, None, ""],
    ],
)
@pytest.mark.parametrize("between", ["", "\n", "# a comment\n"])
def test_lines_of_points_may_be_empty_or_left_out(tmp_path: Path, points: list[str | None], between: str) -> None:
    layouts.colmap(False, ".")(tmp_path)
    lines = "# a comment\n\n"
    for image, own in zip(IMAGES, points, strict=True):
        lines += image + "\n" + ("" if own is None else own + "\n" + between)
    (tmp_path / "images.txt").write_text(lines)
    _, images = read_model(tmp_path / "cameras.txt", tmp_path / "images.txt")
    assert [image.name for image in images] == NAMES


def test_a_camera_that_is_there_twice_is_refused(tmp_path: Path) -> None:
    layouts.colmap(False, ".")(tmp_path)
    with (tmp_path / "cameras.txt").open("a") as opened:
        opened.write("1 PINHOLE 48 32 40 40 24 16\n")
    with pytest.raises(InputError, match=r"cameras\.txt: camera 1 is there twice; export the model again"):
        read_model(tmp_path / "cameras.txt", tmp_path / "images.txt")


def test_points_beyond_the_end_of_the_file_are_refused(tmp_path: Path) -> None:
    layouts.colmap(True, ".")(tmp_path)
    path = tmp_path / "images.bin"
    data = bytearray(path.read_bytes())
    data[-8:] = (2**60).to_bytes(8, "little")
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"images\.bin: unreadable \(it ends inside the points of an image\)"):
        read_model(tmp_path / "cameras.bin", path)
