"""SOG files: parts that are missing, torn or of another version. One of another program is in test_compressed_ply."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.interchange import import_scene
from hgs_core.interchange.sog_file import read_sog
from tests.hgs_core.interchange.gltf.test_gaussian_glb import VECTORS

GIVEN = VECTORS / "splat_transform.sog"


def parts() -> dict[str, bytes]:
    with zipfile.ZipFile(GIVEN) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def zipped(path: Path, files: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return path


def changed(**meta: Any) -> dict[str, bytes]:
    files = parts()
    return files | {"meta.json": json.dumps(json.loads(files["meta.json"]) | meta).encode()}


def picture(width: int, height: int) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(np.zeros((height, width, 4), np.uint8)).save(buffer, "WEBP", lossless=True)
    return buffer.getvalue()


def test_a_folder_of_parts_is_the_same_scene(tmp_path: Path) -> None:
    for name, data in parts().items():
        (tmp_path / name).write_bytes(data)
    zipped_one = read_sog(GIVEN).static
    for path in (tmp_path, tmp_path / "meta.json"):
        found = import_scene(path).scene
        assert (len(found.static), found.end) == (12, 0.0)
        np.testing.assert_array_equal(found.static.means, zipped_one.means)


@pytest.mark.parametrize("said", [True, False, None, "yes"])
def test_the_file_may_say_how_it_is_drawn(tmp_path: Path, said: object) -> None:
    found = read_sog(zipped(tmp_path / "x.sog", changed(antialias=said)))
    assert found.antialiased is (said if isinstance(said, bool) else None)


def test_harmonics_are_left_out_and_told(tmp_path: Path) -> None:
    (change,) = read_sog(zipped(tmp_path / "x.sog", changed(shN={"count": 1}))).changes
    assert (change.what, change.count) == ("view-dependent colour", 12)


@pytest.mark.parametrize(
    ("files", "problem"),
    [
        (lambda: {"a": b""}, "holds no meta.json"),
        (lambda: parts() | {"meta.json": b"{"}, "has a meta.json that is no JSON"),
        (lambda: parts() | {"meta.json": b"[]"}, "is SOG of version none"),
        (
            lambda: changed(version=3),
            r"is SOG of version 3.*splat-transform x.sog x.ply, and import that",
        ),
        (lambda: changed(count=-1), "says that it holds -1 splats"),
        (lambda: changed(count=10**12), "says that it holds 1000000000000 splats"),
        (lambda: changed(count=5000), "has means_l.webp of 4 x 4 pixels for 5000 splats"),
        (lambda: changed(means={"files": [1, 2], "mins": [0] * 3, "maxs": [1] * 3}), "has no part 1"),
        (lambda: changed(means={}), "has a meta.json without what splats need"),
        (lambda: changed(scales={"codebook": [1, 2], "files": ["scales.webp"]}), "a codebook has not 256 numbers"),
        (lambda: {name: data for name, data in parts().items() if name != "quats.webp"}, "has no part quats.webp"),
        (lambda: parts() | {"quats.webp": b"RIFF"}, "has quats.webp, which is no whole WebP picture"),
        (lambda: parts() | {"sh0.webp": picture(2, 2)}, "has sh0.webp of 2 x 2 pixels for 12 splats"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path: Path, files: Callable[[], dict[str, bytes]], problem: str) -> None:
    with pytest.raises(InputError, match=problem) as caught:
        read_sog(zipped(tmp_path / "x.sog", files()))
    assert "\n" not in str(caught.value)


def test_a_torn_zip_is_refused(tmp_path: Path) -> None:
    data = GIVEN.read_bytes()
    for cut in (0, 10, len(data) // 2, len(data) - 5):
        (tmp_path / "x.sog").write_bytes(data[:cut])
        with pytest.raises(InputError, match=r"x\.sog: is no \.sog file that can be unpacked"):
            read_sog(tmp_path / "x.sog")
