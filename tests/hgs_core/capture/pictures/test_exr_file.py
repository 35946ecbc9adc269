"""OpenEXR depth maps, written by FFmpeg, and by hand where FFmpeg has no such files."""

from __future__ import annotations

import contextlib
import struct
import zlib
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.exr_file import read_exr, read_exr_header

DEPTHS = (np.arange(37 * 21).reshape(21, 37) / 7 + 0.25).astype(np.float32)


def by_ffmpeg(path: Path, depths: np.ndarray, compression: str, kind: str) -> Path:
    encoder = av.CodecContext.create("exr", "w")
    encoder.width, encoder.height, encoder.pix_fmt = depths.shape[1], depths.shape[0], "grayf32le"
    encoder.time_base = Fraction(1, 25)
    encoder.options = {"compression": compression, "format": kind}
    frame = av.VideoFrame(depths.shape[1], depths.shape[0], "grayf32le")
    plane = np.frombuffer(frame.planes[0], np.float32).reshape(depths.shape[0], -1)
    plane[:, : depths.shape[1]] = depths
    frame.pts = 0
    path.write_bytes(b"".join(bytes(packet) for packet in [*encoder.encode(frame), *encoder.encode(None)]))
    return path


def by_hand(
    path: Path, channels: list[str], compression: int = 0, version: int = 2, block: bytes | None = None
) -> Path:
    """Write one row of two pixels; each channel holds its place and its place plus a half."""

    def field(name: str, kind: str, value: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    listed = b"".join(name.encode() + b"\0" + struct.pack("<iIii", 2, 0, 1, 1) for name in channels) + b"\0"
    head = b"\x76\x2f\x31\x01" + struct.pack("<I", version) + field("channels", "chlist", listed)
    head += field("compression", "compression", bytes([compression]))
    head += field("dataWindow", "box2i", struct.pack("<4i", 0, 5, 1, 5)) + b"\0"
    pixels = b"".join(struct.pack("<2f", place, place + 0.5) for place in range(len(channels)))
    block = pixels if block is None else block
    path.write_bytes(head + struct.pack("<Q", len(head) + 8) + struct.pack("<ii", 5, len(block)) + block)
    return path


@pytest.mark.parametrize("compression", ["none", "rle", "zip1", "zip16"])
@pytest.mark.parametrize(("kind", "error"), [("float", 0.0), ("half", 1e-3)])
def test_a_file_of_ffmpeg_keeps_its_depths(tmp_path: Path, compression: str, kind: str, error: float) -> None:
    path = by_ffmpeg(tmp_path / "map.exr", DEPTHS, compression, kind)
    assert read_exr_header(path).size == (37, 21)
    np.testing.assert_allclose(read_exr(path), DEPTHS, rtol=error)


def test_the_depth_channel_is_found_by_its_name(tmp_path: Path) -> None:
    path = by_hand(tmp_path / "map.exr", ["ViewLayer.Combined.B", "ViewLayer.Combined.R", "ViewLayer.Depth.Z"])
    np.testing.assert_array_equal(read_exr(path), [[2.0, 2.5]])


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"channels": ["A", "B"]}, r"has the channels 'A, B', none of which is a depth; call one Z"),
        ({"channels": ["Z"], "compression": 4}, r"has the compression number 4; store scan lines, deflated: oiiotool"),
        ({"channels": ["Z"], "version": 0x202}, r"has tiles, or several parts"),
        (
            {"channels": ["Z"], "compression": 3, "block": zlib.compress(bytes(1 << 20))},
            r"a block has 9 bytes, 8 belong",
        ),
        ({"channels": ["Z"], "compression": 3, "block": b"no zip!"}, r"a block is damaged"),
        ({"channels": ["Z"], "compression": 1, "block": b"\x7f"}, r"a block has 0 bytes, 8 belong there"),
    ],
)
def test_a_file_of_another_kind_is_refused_with_a_cure(tmp_path: Path, options: dict, problem: str) -> None:
    path = by_hand(tmp_path / "map.exr", **options)
    with pytest.raises(InputError, match=problem):
        read_exr(path)


def test_no_damage_raises_another_error(tmp_path: Path) -> None:
    """Cut short, or with any byte changed, a file is read or refused."""
    path = by_ffmpeg(tmp_path / "map.exr", DEPTHS[:4, :6], "zip1", "half")
    whole = path.read_bytes()
    random = np.random.default_rng(0)
    for turn in range(300):
        data = bytearray(whole)
        for place in random.integers(0, len(data), 1 + turn % 3):
            data[place] = random.integers(256)
        path.write_bytes(bytes(data[: random.integers(len(data))] if turn % 4 == 0 else data))
        with contextlib.suppress(InputError):
            read_exr(path)
