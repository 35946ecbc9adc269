"""intri.yml and extri.yml. test_layout.py reads whole captures."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.easymocap import EASYMOCAP
from hgs_core.capture.cameras.rig import Rig
from hgs_core.capture.lenses.lens import opencv_lens
from tests.hgs_core.capture import layouts


def read(root: Path) -> Rig:
    file = EASYMOCAP.find(root)
    assert file is not None
    return EASYMOCAP.read(root, file)


@pytest.fixture
def root(tmp_path: Path) -> Path:
    layouts.easymocap(tmp_path)
    return tmp_path


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_distortion_and_size_are_read_where_they_are(root: Path) -> None:
    bent = layouts.opencv_matrix([[0.1, 0.02, 0.003, 0.004, 0.0005]])
    edit(
        root / "intri.yml",
        f"dist_cam02: {layouts.opencv_matrix([[0.0] * 5])}",
        f"D_cam02: {bent}\nH_cam02: 64\nW_cam02: 96",
    )
    camera = read(root).cameras[1]
    assert camera.lens == opencv_lens([0.1, 0.02, 0.003, 0.004, 0.0005], False)
    assert camera.size == (96, 64)
    assert read(root).cameras[0].size is None


def test_a_vector_will_do_for_the_rotation(root: Path) -> None:
    before = read(root).cameras[0].world_to_camera
    edit(root / "extri.yml", "Rot_", "Unused_")
    assert read(root).cameras[0].world_to_camera == pytest.approx(before, abs=1e-9)


def test_without_a_list_of_names_the_matrices_name_the_cameras(root: Path) -> None:
    for file in ("intri.yml", "extri.yml"):
        edit(root / file, "names:", "unnamed:")
    assert [camera.names for camera in read(root).cameras] == [(name,) for name in layouts.NAMES]


@pytest.mark.parametrize(
    ("file", "old", "new", "problem"),
    [
        ("intri.yml", "K_cam02", "L_cam02", "intri.yml, K_cam02: is missing"),
        ("extri.yml", "T_cam02", "U_cam02", "extri.yml, T_cam02: is missing"),
        ("intri.yml", "data: [ 4.e+01, 0.e+00", "data: [ 4.e+01, 9.e+00", "camera cam01: K_cam01 has a skew of 9"),
    ],
)
def test_bad_values_are_named(root: Path, file: str, old: str, new: str, problem: str) -> None:
    edit(root / file, old, new)
    with pytest.raises(InputError, match=problem):
        read(root)


def test_intrinsics_without_poses_are_refused(root: Path) -> None:
    (root / "extri.yml").unlink()
    with pytest.raises(InputError, match=r"there is intri\.yml but no extri\.yml; put the cameras' poses beside it"):
        read(root)


def test_a_file_without_cameras_is_refused(root: Path) -> None:
    (root / "intri.yml").write_text("%YAML:1.0\n---\n")
    with pytest.raises(InputError, match=r"intri\.yml: lists no camera"):
        read(root)
