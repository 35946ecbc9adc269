"""Pictures of other colour profiles show the colours that they were taken in."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageCms

from hgs_core.capture.pictures.colour_profile import colour_profile
from hgs_core.capture.pictures.picture_file import read_header, read_pixels
from hgs_core.capture.pictures.picture_sequence import PictureSequence

COLOUR = (220, 60, 40)
ADOBE_RGB = ((0.60974, 0.31111, 0.01947), (0.20528, 0.62567, 0.06087), (0.14919, 0.06322, 0.74457))
"""X, Y and Z of its primaries, adapted to D50."""
SRGB = np.array([[0.43607, 0.22249, 0.01392], [0.38515, 0.71687, 0.09708], [0.14307, 0.06061, 0.71410]])


def profile(primaries: tuple[tuple[float, ...], ...], gamma: float) -> bytes:
    """Return a matrix profile of ICC version 2, which needs three primaries, a white and a curve."""

    def xyz(values: tuple[float, ...]) -> bytes:
        return b"XYZ \0\0\0\0" + b"".join(struct.pack(">i", round(value * 65536)) for value in values)

    curve = b"curv\0\0\0\0" + struct.pack(">IHH", 1, round(gamma * 256), 0)
    text = b"desc\0\0\0\0" + struct.pack(">I", 5) + b"wide\0" + bytes(78)
    tags = [(b"desc", text + bytes(-len(text) % 4)), (b"wtpt", xyz((0.9642, 1.0, 0.8249)))]
    for channel, primary in zip(b"rgb", primaries, strict=True):
        tags += [(bytes([channel]) + b"XYZ", xyz(primary)), (bytes([channel]) + b"TRC", curve)]
    table, data, at = b"", b"", 132 + 12 * len(tags)
    for name, content in tags:
        table += name + struct.pack(">II", at + len(data), len(content))
        data += content
    head = struct.pack(
        ">I4sI4s4s4s12s4s", at + len(data), b"\0\0\0\0", 0x02100000, b"mntr", b"RGB ", b"XYZ ", bytes(12), b"acsp"
    )
    head += bytes(28) + struct.pack(">iii", 63190, 65536, 54061)
    return head.ljust(128, b"\0") + struct.pack(">I", len(tags)) + table + data


def store(path: Path, colour: tuple[int, ...], icc: bytes) -> Path:
    Image.new("RGB" if len(colour) == 3 else "RGBA", (8, 6), colour).save(path, icc_profile=icc)
    return path


@pytest.mark.parametrize("ending", ["png", "tiff", "webp"])
def test_colours_are_those_of_the_profile(tmp_path: Path, ending: str) -> None:
    linear = (np.array(COLOUR) / 255) ** 2.2
    wanted = np.linalg.inv(SRGB.T) @ np.array(ADOBE_RGB).T @ linear
    encoded = np.where(wanted > 0.0031308, 1.055 * wanted.clip(0) ** (1 / 2.4) - 0.055, 12.92 * wanted).clip(0, 1)
    path = tmp_path / f"a.{ending}"
    Image.new("RGB", (8, 6), COLOUR).save(
        path, icc_profile=profile(ADOBE_RGB, 2.2), **({"lossless": True} if ending == "webp" else {})
    )
    assert np.abs(read_pixels(path)[3, 3] - 255 * encoded).max() <= 3
    assert read_header(path).profile == "wide"


def test_transparency_stays(tmp_path: Path) -> None:
    path = store(tmp_path / "a.png", (*COLOUR, 0), profile(ADOBE_RGB, 2.2))
    assert read_pixels(path).max() == 0


def test_pictures_in_srgb_keep_their_bits(tmp_path: Path) -> None:
    same = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    path = store(tmp_path / "a.png", COLOUR, same)
    assert read_pixels(path)[0, 0].tolist() == list(COLOUR)
    assert read_header(path).profile == ""


def test_damaged_profiles_are_none(tmp_path: Path) -> None:
    whole = profile(ADOBE_RGB, 2.2)
    for damaged in (b"x", whole[:140], whole.replace(b"acsp", b"xxxx"), whole.replace(b"curv", b"text")):
        with Image.open(store(tmp_path / "a.png", COLOUR, damaged)) as image:
            assert colour_profile(image) is None
        assert read_pixels(tmp_path / "a.png")[0, 0].tolist() == list(COLOUR)


def test_it_is_said(tmp_path: Path) -> None:
    files = [store(tmp_path / f"{n}.png", COLOUR, profile(ADOBE_RGB, 2.2)) for n in range(2)]
    assert PictureSequence("a", files).notes == ["colours of the profile wide are brought to sRGB"]
