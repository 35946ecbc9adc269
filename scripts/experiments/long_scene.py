"""A long scene of real pictures: an encoded scene, again and again.

    python scripts/experiments/long_scene.py SCENE OUT --minutes 60

SCENE is a scene folder, OUT a new one. The chunks that move are written anew for every time that the scene is shown.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import json
import struct
import zlib
from pathlib import Path

from hgs_core.codec.format.manifest import SegmentEntry, SliceEntry
from hgs_core.codec.format.scene_folder import CHUNKS, MANIFEST, chunk_bytes, load_manifest

__all__: list[str] = []

INDEX_AT, TIME_AT = 12, 44  # bytes of a chunk's header (docs/format.md, "Container")


def at(chunk: bytes, segment: SegmentEntry, index: int) -> bytes:
    """Return a chunk as one of another segment, and at another place."""
    data = bytearray(chunk)
    struct.pack_into("<I", data, INDEX_AT, index)
    struct.pack_into("<dd", data, TIME_AT, segment.start, segment.end)
    struct.pack_into("<I", data, len(data) - 4, zlib.crc32(data[:-4]))
    return bytes(data)


def main() -> None:
    """Write the long scene."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--minutes", type=float, default=60.0)
    options = parser.parse_args()
    short = load_manifest(options.scene)
    (options.out / CHUNKS).mkdir(parents=True)

    def write(data: bytes) -> str:
        name = hashlib.sha256(data).hexdigest()
        (options.out / CHUNKS / name).write_bytes(data)
        return name

    for entry in short.static:
        write(chunk_bytes(options.scene, entry))
    moving = {entry.id: chunk_bytes(options.scene, entry) for piece in short.slices for entry in piece.chunks}
    duration = short.end - short.start
    times = max(1, round(60 * options.minutes / duration))
    segments: list[SegmentEntry] = []
    slices: list[SliceEntry] = []
    for time in range(times):
        later, first = time * duration, len(segments)
        segments += [SegmentEntry(one.start + later, one.end + later) for one in short.segments]
        names: dict[str, str] = {}
        for piece in short.slices:
            for entry in piece.chunks:
                index = len(short.static) + time * len(moving) + len(names)
                names[entry.id] = write(at(moving[entry.id], segments[first + piece.segment], index))
            chunks = tuple(dataclasses.replace(entry, id=names[entry.id]) for entry in piece.chunks)
            needs = tuple(names[name] for name in piece.needs)
            slices.append(SliceEntry(first + piece.segment, piece.start + later, piece.end + later, chunks, needs))
    long = dataclasses.replace(
        short, end=short.start + times * duration, segments=tuple(segments), slices=tuple(slices), thumbnail=False
    )
    (options.out / MANIFEST).write_text(json.dumps(long.to_json(), separators=(",", ":")))


if __name__ == "__main__":
    main()
