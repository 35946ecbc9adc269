"""GLB files, packed and unpacked by hand as glTF 2.0 describes them (4.4, GLB file format)."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.gltf.glb_container import glb_bytes, read_glb
from tests.hgs_core.interchange.scenes import Write

TEXT = b'{"a":1} '
PACKED = struct.pack("<III", 0x46546C67, 2, 12 + 8 + 8 + 8 + 4) + struct.pack("<II", 8, 0x4E4F534A) + TEXT
PACKED += struct.pack("<II", 4, 0x004E4942) + b"xyz\0"


def test_a_document_and_its_bytes_are_the_chunks_of_the_description_filled_to_four_bytes() -> None:
    assert glb_bytes({"a": 1}, b"xyz") == PACKED


def test_a_file_is_read_back_and_chunks_of_other_kinds_are_passed_over(written: Write) -> None:
    assert read_glb(written("x.glb", PACKED)) == ({"a": 1}, b"xyz\0")
    other = struct.pack("<II", 4, 0x12345678) + b"????"
    data = struct.pack("<III", 0x46546C67, 2, len(PACKED) + len(other)) + PACKED[12:28] + other + PACKED[28:]
    assert read_glb(written("y.glb", data)) == ({"a": 1}, b"xyz\0")


def test_a_file_without_a_block_of_bytes_has_an_empty_one(written: Write) -> None:
    assert read_glb(written("x.glb", struct.pack("<III", 0x46546C67, 2, 28) + PACKED[12:28])) == ({"a": 1}, b"")


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"glTF", "is not a GLB file"),
        (b"ply\n" + PACKED[4:], "is not a GLB file"),
        (PACKED[:4] + b"\1\0\0\0" + PACKED[8:], "is a GLB file of version 1; save it as glTF 2.0"),
        (PACKED[:-1], "has 39 bytes, its header says 40; copy it again"),
        (PACKED[:12] + struct.pack("<I", 99) + PACKED[16:], "has a chunk of 99 bytes, of which 20 are there"),
        (PACKED[:16] + b"BIN\0" + PACKED[20:], "does not begin with a JSON chunk"),
        (PACKED.replace(TEXT, b'{"a":1]}'), "holds no valid JSON"),
        (PACKED.replace(TEXT, b"[1, 2]  "), "holds JSON that is no object"),
        (None, "cannot be read"),
    ],
)
def test_a_file_that_is_none_is_named(tmp_path: Path, data: bytes | None, problem: str) -> None:
    path = tmp_path / "x.glb"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_glb(path)
    assert str(caught.value).startswith(f"{path}: {problem}")
