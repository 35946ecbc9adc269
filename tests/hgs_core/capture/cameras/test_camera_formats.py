from __future__ import annotations

from pathlib import Path

from hgs_core.capture.cameras.camera_formats import CAMERA_FORMATS, calibration


def test_every_format_has_a_name_and_files_of_its_own() -> None:
    assert len({camera_format.name for camera_format in CAMERA_FORMATS}) == len(CAMERA_FORMATS)
    assert all(camera_format.files for camera_format in CAMERA_FORMATS)


def test_of_two_calibrations_the_first_format_in_order_is_first(tmp_path: Path) -> None:
    (tmp_path / "transforms.json").touch()
    (tmp_path / "poses_bounds.npy").touch()
    assert [(found.name, file.name) for found, file in calibration(tmp_path)] == [
        (found.name, name)
        for found in CAMERA_FORMATS
        for name in ("poses_bounds.npy", "transforms.json")
        if found.find(tmp_path) == tmp_path / name
    ]
    assert len(list(calibration(tmp_path))) == 2
