"""With any bytes in its files, a capture is read or refused in one line: never another exception."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture
from tests.hgs_core.capture import layouts
from tests.hgs_core.capture.layouts import CAMERAS, PICTURES
from tests.hgs_core.capture.strange_files import changed

_LONGEST = 5000  # characters of a refusal, of which a path may be half
_PATTERN = "images/{camera}/{frame:04d}.png"


def _timed(root: Path) -> None:
    layouts.transforms(layouts.frames_of_pictures(_PATTERN, lambda frame: frame * 33.3))(root)


def _sync(root: Path) -> None:
    CAMERAS["COLMAP text"](root)
    (root / "sync.json").write_text('{"seconds": {"cam02": 0.0167, "cam03": 0}, "rate": 30.0, "by": "hand"}')


def _table(root: Path) -> None:
    CAMERAS["COLMAP text"](root)
    rows = [f"{name};{1000 + frame / 30:.6f}" for frame in range(layouts.FRAMES) for name in layouts.NAMES]
    (root / "timestamps.csv").write_text("\n".join(["Cam ID;Frame Time", *rows]) + "\n")


WRITERS: dict[str, tuple[Callable[[Path], None], tuple[str, ...]]] = {
    "COLMAP text": (CAMERAS["COLMAP text"], ("sparse/0/cameras.txt", "sparse/0/images.txt")),
    "COLMAP binary": (CAMERAS["COLMAP binary"], ("sparse/0/cameras.bin", "sparse/0/images.bin")),
    "LLFF": (layouts.llff, ("poses_bounds.npy",)),
    "easymocap": (layouts.easymocap, ("intri.yml", "extri.yml")),
    "caliscope": (layouts.caliscope, ("camera_array.toml",)),
    "Pose2Sim": (layouts.pose2sim, ("calibration/Calib_scene.toml",)),
    "OpenCV": (layouts.opencv_files, ("cameras/cam02.yml",)),
    "transforms.json": (CAMERAS["transforms.json"], ("transforms.json",)),
    "transforms.json with times": (_timed, ("transforms.json",)),
    "immersive": (layouts.immersive, ("models.json",)),
    "panoptic": (layouts.panoptic, ("train_meta.json",)),
    "sync.json": (_sync, ("sync.json",)),
    "timestamps.csv": (_table, ("timestamps.csv",)),
}


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("pictures")
    PICTURES["folders"](root)
    shutil.copytree(root / "images", root / "ims")
    return root


@pytest.mark.parametrize("name", WRITERS)
def test_a_changed_file_is_read_or_refused_in_one_line(name: str, pictures: Path) -> None:
    write, files = WRITERS[name]
    before = set(pictures.rglob("*"))
    write(pictures)
    read = 0
    try:
        for file in files:
            path = pictures / file
            good = path.read_bytes()
            assert len(open_capture(pictures).cameras) == len(layouts.NAMES)
            for change, data in changed(good, f"{name} {file}", 40):
                path.write_bytes(data)
                read += _is_read(pictures, f"{file}, {change}")
            path.write_bytes(good)
    finally:
        for path in sorted(set(pictures.rglob("*")) - before, reverse=True):
            path.rmdir() if path.is_dir() else path.unlink()
    assert read > 0  # byte order marks are


def _is_read(root: Path, change: str) -> bool:
    try:
        capture = open_capture(root)
    except InputError as error:
        text = str(error)
        assert text.isprintable(), f"{change}: {text!r}"
        assert len(text) < _LONGEST, change
        return False
    except Exception as error:
        raise AssertionError(f"{change}: {error!r}") from error
    assert capture.cameras, change
    assert len(capture.times), change
    assert all(np.isfinite(camera.world_to_camera).all() for camera in capture.cameras), change
    return True
