"""GLB, the binary container of glTF 2.0: a JSON document and one block of bytes (registry.khronos.org/glTF)."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.interchange.file_bytes import file_bytes

__all__ = ["glb_bytes", "read_glb"]

_HEADER = struct.Struct("<4sII")  # magic, version, length of the file
_CHUNK = struct.Struct("<I4s")  # length, type
_CURE = "give a .glb file of splats"


def glb_bytes(document: Mapping[str, Any], binary: bytes) -> bytes:
    """Return a GLB file; chunks are filled up to multiples of four bytes, JSON with spaces, the block with zeros."""
    text = json.dumps(document, separators=(",", ":")).encode()
    chunks = b""
    for kind, data, filler in ((b"JSON", text, b" "), (b"BIN\0", binary, b"\0")):
        data += filler * (-len(data) % 4)
        chunks += _CHUNK.pack(len(data), kind) + data
    return _HEADER.pack(b"glTF", 2, _HEADER.size + len(chunks)) + chunks


def read_glb(path: Path) -> tuple[dict[str, Any], bytes]:
    """Return the document of a GLB file and its block of bytes, empty if it has none.

    Raises:
        InputError: the file is missing, no GLB of version 2, or damaged.
    """
    data = file_bytes(path, "a .glb file of splats")
    if len(data) < _HEADER.size or data[:4] != b"glTF":
        raise InputError(path, "is not a GLB file: it does not begin with glTF", _CURE)
    _, version, length = _HEADER.unpack_from(data)
    if version != 2:
        raise InputError(path, f"is a GLB file of version {version}", "save it as glTF 2.0")
    if length > len(data):
        raise InputError(path, f"has {len(data)} bytes, its header says {length}", "copy it again")
    chunks: list[tuple[bytes, bytes]] = []
    at = _HEADER.size
    while at + _CHUNK.size <= length:
        size, kind = _CHUNK.unpack_from(data, at)
        at += _CHUNK.size
        if at + size > length:
            raise InputError(path, f"has a chunk of {size} bytes, of which {length - at} are there", "copy it again")
        chunks.append((kind, data[at : at + size]))
        at += size
    if not chunks or chunks[0][0] != b"JSON":
        raise InputError(path, "does not begin with a JSON chunk", _CURE)
    try:
        document = json.loads(chunks[0][1])
    except ValueError as error:
        raise InputError(path, f"holds no valid JSON ({error})", _CURE) from error
    if not isinstance(document, dict):
        raise InputError(path, "holds JSON that is no object", _CURE)
    return document, next((block for kind, block in chunks[1:] if kind == b"BIN\0"), b"")
