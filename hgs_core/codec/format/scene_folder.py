"""Reading a scene folder: manifest.json, chunks/<sha256>, thumbnail.jpg."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Container, Iterator
from pathlib import Path
from typing import Any

from hgs_core.base.arrays import Floats
from hgs_core.base.errors import InputError
from hgs_core.codec.format.attributes import Kind
from hgs_core.codec.format.audio import AudioPiece, CodedAudio
from hgs_core.codec.format.decode import DecodedChunk, decode_chunk
from hgs_core.codec.format.format_error import ChunkError
from hgs_core.codec.format.manifest import ChunkEntry, Manifest, SegmentEntry
from hgs_core.codec.format.manifest_reading import read_manifest
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats, joined

__all__ = [
    "CHUNKS",
    "ENCODE_AGAIN",
    "MANIFEST",
    "THUMBNAIL",
    "checked_chunks",
    "chunk_bytes",
    "chunk_id",
    "decode_scene",
    "load_manifest",
    "read_audio",
    "read_chunk",
    "stored_sizes",
]

MANIFEST = "manifest.json"
CHUNKS = "chunks"
THUMBNAIL = "thumbnail.jpg"

ENCODE_AGAIN = "encode the scene again: hgs encode RUN"
"""The cure for a damaged scene folder."""


def load_manifest(path: Path) -> Manifest:
    """Read a manifest; `path` is the file or its folder.

    Raises:
        InputError: it is missing, not JSON, or a field is wrong; names the file and the field.

    Example:
        >>> import hgs_core as hgs
        >>> from pathlib import Path
        >>> manifest = hgs.load_manifest(Path("run/scene"))
        >>> manifest.cameras[0].width, manifest.cameras[0].height, len(manifest.segments)
        (64, 48, 1)
    """
    file = path / MANIFEST if path.is_dir() else path
    try:
        document: Any = json.loads(file.read_bytes())
    except OSError as error:
        raise InputError(
            file, f"cannot be read ({error.strerror})", "give a scene folder or its manifest.json"
        ) from error
    except (ValueError, RecursionError) as error:
        raise InputError(file, f"is not JSON ({error})", ENCODE_AGAIN) from error
    return read_manifest(document, f"{file}: manifest")


def chunk_id(data: bytes) -> str:
    """Return the name of a chunk: the SHA-256 of its bytes, as 64 lower-case hexadecimal digits."""
    return hashlib.sha256(data).hexdigest()


def chunk_bytes(folder: Path, entry: ChunkEntry | AudioPiece) -> bytes:
    """Return the bytes of a chunk of a scene folder.

    Raises:
        InputError: the file is missing, or its length or SHA-256 is not the manifest's.
    """
    file = folder / CHUNKS / entry.id
    try:
        size = file.stat().st_size
        if size != entry.bytes:
            raise InputError(file, f"has {size} bytes, the manifest says {entry.bytes}", ENCODE_AGAIN)
        data = file.read_bytes()
    except OSError as error:
        raise InputError(file, f"cannot be read ({error.strerror})", ENCODE_AGAIN) from error
    actual = chunk_id(data)
    if actual != entry.id:
        raise InputError(file, f"has the SHA-256 {actual}, the manifest says {entry.id}", ENCODE_AGAIN)
    return data


def read_chunk(folder: Path, entry: ChunkEntry) -> DecodedChunk:
    """Read and decode a chunk of a scene folder.

    Raises:
        InputError: as `chunk_bytes`, or it is not a valid chunk.
    """
    return _decoded(folder, entry, chunk_bytes(folder, entry))


def stored_sizes(manifest: Manifest) -> dict[str, int]:
    """Return the bytes of every file in `CHUNKS` by its id: the chunks of splats in order, then those of sound."""
    sounds = {} if manifest.audio is None else manifest.audio.sizes
    return {entry.id: entry.bytes for entry in manifest.chunks} | sounds


def read_audio(folder: Path, manifest: Manifest) -> CodedAudio | None:
    """Read the sound of a scene folder, if it has any.

    Raises:
        InputError: as `chunk_bytes`.
    """
    if manifest.audio is None:
        return None
    return CodedAudio(manifest.audio, {piece.id: chunk_bytes(folder, piece) for piece in manifest.audio.pieces})


def checked_chunks(
    folder: Path, manifest: Manifest, known: Container[str] = ()
) -> Iterator[tuple[ChunkEntry | AudioPiece, bytes]]:
    """Yield the chunks of a scene folder as `stored_sizes` has them, with their bytes; read once, or never if `known`.

    Before a chunk of splats is yielded it has been decoded, so what it holds is known to be what the manifest says of
    it. Of sound the length and the SHA-256 are checked.

    Raises:
        InputError: a chunk is missing or wrong; names its file.
    """
    for entry in manifest.static:
        if entry.id not in known:
            yield entry, _in_place(folder, entry, None)[0]
    for piece in manifest.slices:
        for entry in (entry for entry in piece.chunks if entry.id not in known):
            yield entry, _in_place(folder, entry, manifest.segments[piece.segment])[0]
    if manifest.audio is not None:
        for sound in {piece.id: piece for piece in manifest.audio.pieces if piece.id not in known}.values():
            yield sound, chunk_bytes(folder, sound)


def decode_scene(path: Path) -> HybridScene[Floats]:
    """Decode a whole scene folder; every chunk's SHA-256 is checked.

    Raises:
        InputError: the manifest or a chunk is missing or wrong.

    Example:
        >>> import hgs_core as hgs
        >>> from pathlib import Path
        >>> scene = hgs.decode_scene(Path("run/scene"))
        >>> scene.static.rgb.shape[1], scene.start <= scene.end  # numpy, float32; seconds
        (3, True)
    """
    manifest = load_manifest(path)
    folder = path if path.is_dir() else path.parent
    static = [_in_place(folder, entry, None)[1].static() for entry in manifest.static]
    dynamic: list[list[DynamicSplats[Floats]]] = [[] for _ in manifest.segments]
    for piece in manifest.slices:
        segment = manifest.segments[piece.segment]
        for entry in piece.chunks:
            dynamic[piece.segment].append(_in_place(folder, entry, segment)[1].dynamic())
    segments = tuple(
        Segment(segment.start, segment.end, joined([DynamicSplats.empty(), *sets]))
        for segment, sets in zip(manifest.segments, dynamic, strict=True)
    )
    static_set = joined([StaticSplats.empty(), *static])
    return HybridScene(static_set, segments, manifest.background, manifest.antialiased)


def _in_place(folder: Path, entry: ChunkEntry, segment: SegmentEntry | None) -> tuple[bytes, DecodedChunk]:
    """Read and decode a chunk that the manifest lists as static (segment None) or as one of a segment."""
    data, file = chunk_bytes(folder, entry), folder / CHUNKS / entry.id
    chunk = _decoded(folder, entry, data)
    if chunk.kind != (Kind.STATIC if segment is None else Kind.DYNAMIC):
        raise InputError(file, f"is a {chunk.kind.name.lower()} chunk, listed as the other kind", ENCODE_AGAIN)
    if segment is not None and chunk.time_range != (segment.start, segment.end):
        raise InputError(
            file,
            f"is of the time {chunk.time_range}, its segment of {(segment.start, segment.end)}",
            ENCODE_AGAIN,
        )
    return data, chunk


def _decoded(folder: Path, entry: ChunkEntry, data: bytes) -> DecodedChunk:
    file = folder / CHUNKS / entry.id
    try:
        chunk = decode_chunk(data)
    except ChunkError as error:
        raise InputError(file, f"cannot be decoded ({error})", ENCODE_AGAIN) from error
    if chunk.count != entry.splats:
        raise InputError(file, f"has {chunk.count} splats, the manifest says {entry.splats}", ENCODE_AGAIN)
    return chunk
