"""One file of OpenCV's for each camera. test_layout.py reads whole captures."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.opencv_files import OPENCV_FILES
from hgs_core.capture.cameras.rig import Rig
from tests.hgs_core.capture import layouts


def read(root: Path) -> Rig:
    file = OPENCV_FILES.find(root)
    assert file is not None
    return OPENCV_FILES.read(root, file)


@pytest.fixture
def root(tmp_path: Path) -> Path:
    layouts.opencv_files(tmp_path)
    return tmp_path


def edit(path: Path, *changes: tuple[str, str]) -> None:
    text = path.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)


def test_cameras_are_called_like_their_files(root: Path) -> None:
    rig = read(root)
    assert [camera.names for camera in rig.cameras] == [(name,) for name in layouts.NAMES]
    assert len(rig.files) == 4
    assert rig.cameras[0].centre == (24.0, 16.0)  # half a pixel more than OpenCV has


def test_fields_have_several_names(root: Path) -> None:
    before = read(root).cameras[0]
    edit(
        root / "cameras" / "cam01.yml", ("camera_matrix:", "K:"), ("T:", "tvec:"), ("R:", "rvec:"), ("image_width", "w")
    )
    after = read(root).cameras[0]
    assert (after.focal, after.centre) == (before.focal, before.centre)
    assert after.world_to_camera == pytest.approx(before.world_to_camera)
    assert after.size is None


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("camera_matrix:", "matrix:", "there is no camera_matrix; add it; it may also be called cameraMatrix, K"),
        ("R:", "turn:", "there is no R; add it"),
        ("rows: 3\n   cols: 3", "rows: 3\n   cols: 2", "9 numbers for 3 rows of 2"),
    ],
)
def test_bad_files_are_named(root: Path, old: str, new: str, problem: str) -> None:
    edit(root / "cameras" / "cam02.yml", (old, new))
    with pytest.raises(InputError, match=rf"cam02\.yml.*: .*{problem}"):
        read(root)


def test_other_files_of_yaml_are_no_cameras(tmp_path: Path) -> None:
    (tmp_path / "docker-compose.yml").write_text("services: {}\n")
    layouts.easymocap(tmp_path)
    assert OPENCV_FILES.find(tmp_path) is None
