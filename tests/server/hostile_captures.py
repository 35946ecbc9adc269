"""Captures made to end, fill or hold their reader, by name; each is written into an empty folder."""

from __future__ import annotations

import io
import json
import pickle
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

__all__ = ["HOSTILE", "write_still"]

DEEP = 100_000  # brackets
CAMERAS = 4
_NAMES = ("north", "east", "south", "west")

Writer = Callable[[Path], None]


def write_still(folder: Path, picture: bytes | None = None) -> None:
    """Write a capture of photographs; one of its pictures may be another."""
    transforms(folder, {})
    for number, name in enumerate(_NAMES):
        Image.new("RGB", (64, 48), (40 * number, 90, 160)).save(folder / f"{name}.png")
    if picture is not None:
        (folder / "south.png").write_bytes(picture)


def transforms(folder: Path, changes: dict[str, object], frame: dict[str, object] | None = None) -> None:
    frames = [
        {"file_path": f"{name}.png", "transform_matrix": _pose(k)} | (frame or {}) for k, name in enumerate(_NAMES)
    ]
    table = {"fl_x": 50, "w": 64, "h": 48, "frames": frames} | changes
    (folder / "transforms.json").write_text(json.dumps(table))


def _pose(camera: int) -> list[list[float]]:
    return [[1, 0, 0, camera], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def videos(content: Callable[[str], bytes], *, poses: bool = False) -> Writer:
    """Videos of such content, by their names."""

    def write(folder: Path) -> None:
        for number in range(CAMERAS):
            name = f"cam{number}.mp4"
            (folder / name).write_bytes(content(name))
        if poses:
            array = io.BytesIO()
            np.save(array, np.tile(np.arange(17.0), (CAMERAS, 1)))
            (folder / "poses_bounds.npy").write_bytes(array.getvalue())

    return write


def files(**contents: bytes) -> Writer:
    """Files with these contents beside pictures; "__" stands for a folder, "_DOT_" for a dot."""

    def write(folder: Path) -> None:
        write_still(folder)
        (folder / "transforms.json").unlink()
        for name, content in contents.items():
            path = folder / name.replace("__", "/").replace("_DOT_", ".")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)

    return write


def beside(name: str, content: bytes) -> Writer:
    """A capture that is well but for one file."""

    def write(folder: Path) -> None:
        write_still(folder)
        (folder / name).write_bytes(content)

    return write


def table(changes: dict[str, object], frame: dict[str, object] | None = None) -> Writer:
    def write(folder: Path) -> None:
        write_still(folder)
        transforms(folder, changes, frame)

    return write


def picture(content: bytes) -> Writer:
    return lambda folder: write_still(folder, content)


def text_table(text: str) -> Writer:
    return beside("transforms.json", text.encode())


def _png(width: int, height: int) -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = zlib.compress(b"\0" * 1000)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def _npy(header: str) -> bytes:
    text = header.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text


def _concat(of: str, lines: int) -> bytes:
    return b"ffconcat version 1.0\n" + f"file '{of}'\n".encode() * lines


class _Harm:
    def __reduce__(self) -> tuple[Callable[[str], object], tuple[str]]:
        return open, ("/tmp/hgs-hostile-pickle-was-run",)


_BOX = struct.pack(">I4sQ", 1, b"moov", 2**62)

HOSTILE: dict[str, Writer] = {
    "concat of itself": videos(lambda name: _concat(name, 1)),
    "concat of itself with poses": videos(lambda name: _concat(name, 1), poses=True),
    "concat of each other": videos(lambda name: _concat(f"cam{(int(name[3]) + 1) % CAMERAS}.mp4", 2)),
    "concat of 20,000 lines": videos(lambda name: _concat("cam1.mp4", 20_000)),
    "concat of a device": videos(lambda name: _concat("/dev/zero", 1)),
    "hls of itself": videos(lambda name: f"#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\n{name}\n".encode()),
    "hls of 20,000 lines": videos(lambda name: b"#EXTM3U\n#EXT-X-TARGETDURATION:9\n" + b"#EXTINF:9,\na.ts\n" * 20_000),
    "hls of another machine": videos(lambda name: b"#EXTM3U\n#EXTINF:9,\nhttp://127.0.0.1:1/a.ts\n"),
    "dash": videos(lambda name: b'<?xml version="1.0"?><MPD><Period><BaseURL>file:///etc/</BaseURL></Period></MPD>'),
    "sdp": videos(lambda name: b"v=0\nc=IN IP4 127.0.0.1\nm=video 9 RTP/AVP 96\na=rtpmap:96 H264/90000\n"),
    "video of a box of 2^62 bytes": videos(lambda name: struct.pack(">I8s", 16, b"ftypisom") + b"\0\0\0\0" + _BOX),
    "video of nothing": videos(lambda name: b""),
    "video of zeros": videos(lambda name: bytes(1 << 16), poses=True),
    "video that is a picture": videos(lambda name: _png(60_000, 60_000)),
    "video that is a git-lfs pointer": videos(lambda name: b"version https://git-lfs.github.com/spec/v1\nsize 5\n"),
    "y4m of 60,000^2": videos(lambda name: b"YUV4MPEG2 W60000 H60000 F30:1\nFRAME\n"),
    "npy of 1e9 rows": files(
        poses_bounds_DOT_npy=_npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000, 17), }")
    ),
    "npy of a negative shape": files(
        poses_bounds_DOT_npy=_npy("{'descr': '<f8', 'fortran_order': False, 'shape': (-1, 17), }")
    ),
    "npy whose header is code": files(poses_bounds_DOT_npy=_npy("__import__('os').abort()")),
    "npy of objects": files(poses_bounds_DOT_npy=_npy("{'descr': '|O', 'fortran_order': False, 'shape': (4,), }")),
    "pickle": files(poses_bounds_DOT_npy=pickle.dumps(_Harm())),
    "npy of nothing": files(poses_bounds_DOT_npy=b""),
    "lists 100,000 deep": text_table("[" * DEEP + "]" * DEEP),
    "objects 100,000 deep": text_table('{"a":' * DEEP + "1" + "}" * DEEP),
    "frames 100,000 deep": text_table('{"frames":' + "[" * DEEP + "]" * DEEP + "}"),
    "60 MB of numbers": text_table('{"frames":[' + "1," * 30_000_000 + "1]}"),
    "a number of 100,000 digits": text_table('{"fl_x":' + "9" * DEEP + ',"frames":[]}'),
    "infinite focal length": table({"fl_x": float("inf")}),
    "pictures of 10^18 pixels": table({"w": 10**9, "h": 10**9}),
    "frames of another kind": table({"frames": {"0": None}}),
    "poses of another kind": table({}, {"transform_matrix": "ones"}),
    "pictures above the capture": table({}, {"file_path": "../../../../../../etc/passwd"}),
    "pictures elsewhere": table({}, {"file_path": "/etc/passwd"}),
    "pictures with NUL in their names": table({}, {"file_path": "a\0b.png"}),
    "pictures with half a character": table({}, {"file_path": "\ud800.png"}),
    "sync 100,000 deep": beside("sync.json", b"[" * DEEP + b"]" * DEEP),
    "toml 100,000 deep": files(camera_array_DOT_toml=b"a = " + b"[" * DEEP + b"]" * DEEP),
    "toml tables 30,000 deep": files(camera_array_DOT_toml=b"[" + b"a." * 30_000 + b"a]\n"),
    "yaml of python": files(intri_DOT_yml=b"!!python/object/apply:os.abort []\n", extri_DOT_yml=b"%YAML:1.0\n"),
    "yaml of a billion laughs": files(
        intri_DOT_yml=b"%YAML:1.0\na: &a [x,x]\nb: &b [*a,*a,*a,*a]\nc: [*b,*b]\n", extri_DOT_yml=b"%YAML:1.0\n"
    ),
    "yaml 9,000 deep": files(intri_DOT_yml=b"%YAML:1.0\nnames: " + b"[" * 9000, extri_DOT_yml=b"%YAML:1.0\n"),
    "models 100,000 deep": files(models_DOT_json=b"[" * DEEP + b"]" * DEEP),
    "train_meta of another kind": files(train_meta_DOT_json=b'{"w": [], "k": 3, "fn": {"a": 1}}'),
    "train_meta 100,000 deep": files(train_meta_DOT_json=b'{"fn":' * DEEP + b"1" + b"}" * DEEP),
    "colmap of 2^64 cameras": files(
        sparse__0__cameras_DOT_bin=struct.pack("<Q", 2**64 - 1), sparse__0__images_DOT_bin=struct.pack("<Q", 2**64 - 1)
    ),
    "colmap cut off": files(
        sparse__0__cameras_DOT_bin=struct.pack("<Q", 1), sparse__0__images_DOT_bin=struct.pack("<Q", 1) + b"\0" * 60
    ),
    "colmap of one line of 8 MB": files(
        sparse__0__cameras_DOT_txt=b"1 PINHOLE 64 48 " + b"9" * (8 << 20), sparse__0__images_DOT_txt=b"1\n"
    ),
    "picture of 60,000^2": picture(_png(60_000, 60_000)),
    "picture of (2^31-1)^2": picture(_png(2**31 - 1, 2**31 - 1)),
    "picture of nothing": picture(b""),
    "picture that is cut off": picture(_png(64, 48)[:40]),
    "picture that is a playlist": picture(_concat("south.png", 3)),
}
"""Each is refused with 422, of code `capture-invalid`: none of them can be trained."""
