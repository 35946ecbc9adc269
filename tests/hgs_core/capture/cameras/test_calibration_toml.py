"""TOML of caliscope and Pose2Sim. test_layout.py reads whole captures."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.calibration_toml import CALIBRATION_TOML
from hgs_core.capture.cameras.rig import Rig
from hgs_core.capture.lenses.lens import Polynomial
from tests.hgs_core.capture import layouts
from tests.hgs_core.capture.layouts import calibration_tables


def read(root: Path) -> Rig:
    file = CALIBRATION_TOML.find(root)
    assert file is not None
    return CALIBRATION_TOML.read(root, file)


@pytest.mark.parametrize(
    "file", ["camera_array.toml", "Calib_scene.toml", "calibration/Calib.toml", "Calibration/calib.TOML"]
)
def test_the_file_is_found_where_tools_put_it(tmp_path: Path, file: str) -> None:
    (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / file).write_text(calibration_tables(""))
    assert [camera.names[0] for camera in read(tmp_path).cameras] == list(layouts.NAMES)


def test_opencv_s_centres_of_pixels_lie_half_a_pixel_further(tmp_path: Path) -> None:
    """OpenCV's middle of 48 pixels is 23.5, ours is 24."""
    layouts.caliscope(tmp_path)
    assert "23.5" in (tmp_path / "camera_array.toml").read_text()
    assert read(tmp_path).cameras[0].centre == (24.0, 16.0)


def test_a_fisheye_has_four_coefficients_of_the_angle(tmp_path: Path) -> None:
    (tmp_path / "camera_array.toml").write_text(calibration_tables("cameras.", (0.1, 0.02, 0.0, 0.0), fisheye=True))
    assert read(tmp_path).cameras[0].lens == Polynomial(radial=(0.1, 0.02), fisheye=True)


def test_cameras_to_be_ignored_are_left_out_and_said(tmp_path: Path) -> None:
    text = calibration_tables("cameras.").replace("name = 'cam02'", "ignore = true")
    (tmp_path / "camera_array.toml").write_text(text)
    rig = read(tmp_path)
    assert [camera.names[0] for camera in rig.cameras] == ["cam01", "cam03", "cam10"]
    assert rig.notes == ("camera_array.toml says that cam02 is to be left out",)


def test_two_calibrations_beside_each_other_are_refused(tmp_path: Path) -> None:
    layouts.pose2sim(tmp_path)
    (tmp_path / "calibration" / "Calib_old.toml").write_text("")
    with pytest.raises(InputError, match=r"Calib_old\.toml: Calib_scene\.toml lies beside it; keep the calibration"):
        read(tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("rotation = ", "turn = ", r"cam01: the field 'rotation' is missing; calibrate where the cameras stand"),
        ("size = [48, 32]", "size = [48]", r"cam01: size is \[48\.0\]; it is 2 finite numbers"),
        ("distortions = [0.0, 0.0, 0.0, 0.0, 0.0]", f"distortions = {[0.1] * 14}", "cam01: distortions: the sensor is"),
        ("[cameras.", "[cameras.cameras.", "lists no camera"),
        ("[cameras.cam01]", "[cameras.cam01", "unreadable"),
    ],
)
def test_bad_values_are_named(tmp_path: Path, old: str, new: str, problem: str) -> None:
    text = calibration_tables("cameras.")
    assert old in text
    (tmp_path / "camera_array.toml").write_text(text.replace(old, new))
    with pytest.raises(InputError, match=rf"camera_array\.toml(, |: ){problem}"):
        read(tmp_path)
