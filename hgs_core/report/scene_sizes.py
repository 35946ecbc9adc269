"""Where the bytes of a scene are: every stream of every chunk, from the chunks' own tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hgs_core.base.errors import InputError
from hgs_core.codec import Manifest
from hgs_core.codec.format.attributes import BY_ID, Kind
from hgs_core.codec.format.chunk import unpack
from hgs_core.codec.format.format_error import ChunkError
from hgs_core.codec.format.scene_folder import CHUNKS, ENCODE_AGAIN
from hgs_core.runs.run_folder import RunFolder

__all__ = ["CONTAINER", "ChunkSize", "chunk_sizes"]

CONTAINER = "container"
"""The name under which headers, tables and checksums are counted."""


@dataclass(frozen=True)
class ChunkSize:
    """One chunk."""

    kind: Kind
    slice: int  # number of a dynamic chunk's slice; -1 for a static one
    splats: int
    streams: Mapping[str, int]  # bytes by attribute, in the chunk's order, and of the container; the sum is the file's


def chunk_sizes(folder: RunFolder, manifest: Manifest) -> list[ChunkSize]:
    """Return all chunks, the static ones first.

    Raises:
        InputError: a chunk is missing or damaged.
    """
    listed = [(-1, entry) for entry in manifest.static]
    listed += [(number, entry) for number, piece in enumerate(manifest.slices) for entry in piece.chunks]
    sizes = []
    for number, entry in listed:
        file = folder.scene / CHUNKS / entry.id
        try:
            data = file.read_bytes()
            chunk = unpack(data)
        except OSError as error:
            raise InputError(file, f"cannot be read ({error.strerror})", ENCODE_AGAIN) from error
        except ChunkError as error:
            raise InputError(file, str(error), ENCODE_AGAIN) from error
        streams = {_name(stream.attribute): sum(map(len, stream.planes)) for stream in chunk.streams}
        rest = len(data) - sum(streams.values())
        sizes.append(ChunkSize(chunk.kind, number, chunk.count, streams | {CONTAINER: rest}))
    return sizes


def _name(attribute: int) -> str:
    known = BY_ID.get(attribute)
    return known.name if known else f"attribute {attribute}"
