"""An encoded scene without some of its splats: all others decode to the same bits."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hgs_core.base import morton
from hgs_core.base.arrays import Mask
from hgs_core.codec.encoder.encode_chunk import outward, stream_of
from hgs_core.codec.encoder.encode_dynamic import SegmentTime, reach
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.scene_chunks import CodedChunk, SceneChunks
from hgs_core.codec.encoder.segment_times import shown_segments
from hgs_core.codec.format.attributes import BY_ID, Attribute
from hgs_core.codec.format.chunk import Stream, pack, unpack
from hgs_core.codec.format.decode import DecodedChunk, decode_chunk
from hgs_core.codec.format.manifest import Manifest
from hgs_core.codec.format.scene_folder import chunk_bytes, load_manifest
from hgs_core.codec.format.streams import Transform, to_planes, transform
from hgs_core.codec.format.values import read_codes
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats

__all__ = ["chunk_of_kept", "kept_chunks"]


def kept_chunks(folder: Path, static: Mask, moving: Sequence[Mask]) -> SceneChunks:
    """Return the chunks of a scene folder with only the splats of these masks: [N], and [M] for each segment.

    Raises:
        InputError: the folder is damaged.
    """
    manifest = load_manifest(folder)
    times = _times(manifest)
    made: dict[str, CodedChunk] = {}

    def keep(entry_id: str, mask: Mask, time: SegmentTime | None) -> None:
        if mask.any():
            made[entry_id] = CodedChunk.of(*chunk_of_kept(stored[entry_id], mask, time))

    stored = {entry.id: chunk_bytes(folder, entry) for entry in manifest.chunks}
    start = 0
    for entry in manifest.static:
        keep(entry.id, static[start : start + entry.splats], None)
        start += entry.splats
    done = [0] * len(moving)
    for piece in manifest.slices:
        for entry in piece.chunks:
            first = done[piece.segment]
            done[piece.segment] = last = first + entry.splats
            keep(entry.id, moving[piece.segment][first:last], times[piece.segment])
    slices = tuple(
        dataclasses.replace(
            piece,
            chunks=tuple(made[entry.id].entry for entry in piece.chunks if entry.id in made),
            needs=tuple(made[one].entry.id for one in piece.needs if one in made),
        )
        for piece in manifest.slices
    )
    return SceneChunks(
        tuple(made[entry.id] for entry in manifest.static if entry.id in made),
        tuple(made[entry.id] for piece in manifest.slices for entry in piece.chunks if entry.id in made),
        slices,
    )


def chunk_of_kept(data: bytes, keep: Mask, time: SegmentTime | None) -> tuple[bytes, DecodedChunk]:
    """Return a chunk with only the splats that `keep` [N] says, at least one; `time` is that of a dynamic chunk.

    Grids and codes stay as they are, so the bounds that the chunk declares hold, too.
    """
    container = unpack(data)
    known = [(stream, BY_ID[stream.attribute]) for stream in container.streams if stream.attribute in BY_ID]
    forms = next((read_codes(s, a, container.count)[0] for s, a in known if a.name == "form"), None)
    streams: list[Stream] = []
    for stream, attribute in known:
        has = np.ones(container.count, np.bool_) if forms is None else attribute.among(forms)
        rows = keep[has]
        if rows.any():
            streams.append(_stream_of_kept(stream, attribute, rows))
    kept = dataclasses.replace(container, count=int(keep.sum()), streams=tuple(streams))
    decoded = decode_chunk(pack(kept))
    if time is None:
        means = decoded.arrays["means"].astype(np.float64)
        box = outward(means.min(axis=0), means.max(axis=0))
    else:
        box = outward(*reach(decoded, time))
    data = pack(dataclasses.replace(kept, box=box))
    return data, decode_chunk(data)


def _stream_of_kept(stream: Stream, attribute: Attribute, rows: Mask) -> Stream:
    bits, kind = stream.grid.bits, Transform(stream.transform)
    codes = read_codes(stream, attribute, len(rows)).T[rows].astype(np.uint32)
    if attribute.morton:
        planes = morton.to_planes(morton.differences(morton.interleave(codes)), bits)
    else:
        planes = to_planes(transform(codes, bits, kind), bits)
    return stream_of(attribute, kind, stream.grid, planes, EncodeSettings())


def _times(manifest: Manifest) -> list[SegmentTime]:
    """Return the clock of every segment."""
    segments = tuple(Segment(entry.start, entry.end, DynamicSplats.empty()) for entry in manifest.segments)
    return [shown.time for shown in shown_segments(HybridScene(StaticSplats.empty(), segments), 1.0)]
