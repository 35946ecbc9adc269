"""Manifests as they are read: every field checked, then the order of time, references between lists, and totals."""

from __future__ import annotations

import json
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.codec.format.audio import AudioEntry
from hgs_core.codec.format.captured_space import CapturedSpace
from hgs_core.codec.format.chunk import MAX_CHUNK_BYTES, MAX_SPLATS, VERSIONS
from hgs_core.codec.format.json_fields import Field, field_of
from hgs_core.codec.format.manifest import FORMAT, ChunkEntry, Manifest, SegmentEntry, SliceEntry
from hgs_core.codec.format.start_views import StartViews
from hgs_core.scene.camera import Camera

__all__ = ["parse_manifest", "read_manifest"]


def parse_manifest(data: bytes, where: object = "manifest") -> tuple[dict[str, Any], Manifest]:
    """Return the bytes of a manifest as plain JSON and as a checked manifest.

    Raises:
        InputError: they are not JSON, or as `read_manifest`.
    """
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError(where, f"is not JSON: {error}") from error
    return document, read_manifest(document, where)


def read_manifest(value: Any, where: object = "manifest") -> Manifest:
    """Read and check the JSON document of a manifest; unknown fields are left alone.

    Raises:
        InputError: names the field (after `where`), the value and what it should be.
    """
    root = field_of(value, where)
    if root["format"].text() != FORMAT:
        raise root["format"].error(f"is {root['format'].value!r}, expected {FORMAT!r}")
    version = root["version"].whole(1)
    if version not in VERSIONS:
        known = " or ".join(map(str, VERSIONS))
        raise root["version"].error(f"is {version}, expected {known}", "use a newer version of this program")
    cameras = tuple(_camera(field) for field in root["cameras"].items())
    manifest = Manifest(
        title=root["title"].text(),
        start=root["start"].number(),
        end=root["end"].number(low=root["start"].number()),
        frame_rate=root["frame_rate"].number(above=0),
        background=_triple(root["background"].numbers(3)),
        up=_triple(root["up"].numbers(3)),
        center=_triple(root["center"].numbers(3)),
        extent=root["extent"].number(above=0),
        cameras=cameras,
        segments=tuple(
            SegmentEntry(field["start"].number(), field["end"].number(low=field["start"].number()))
            for field in root["segments"].items()
        ),
        static=tuple(_chunk(field) for field in root["static"].items()),
        slices=tuple(_slice(field) for field in root["slices"].items()),
        thumbnail=root["thumbnail"].flag(),
        training=root["training"].mapping(),
        antialiased="antialiased" in root.mapping() and root["antialiased"].flag(),
        # Earlier manifests lack the field; only photographs give a captured space.
        photographed=(
            root["photographed"].flag() if "photographed" in root.mapping() else "captured_space" in root.mapping()
        ),
        start_views=(
            StartViews.read(root["start_views"], {camera.name for camera in cameras})
            if "start_views" in root.mapping()
            else None
        ),
        captured_space=CapturedSpace.read(root["captured_space"]) if "captured_space" in root.mapping() else None,
        metres_per_unit=root["metres_per_unit"].number(above=0) if "metres_per_unit" in root.mapping() else None,
        audio=AudioEntry.read(root["audio"]) if "audio" in root.mapping() else None,
        version=version,
        live=root["live"].whole(1) if "live" in root.mapping() else None,
    )
    _check_references(manifest, root)
    return manifest


def _chunk(field: Field) -> ChunkEntry:
    box = field["box"].items(2)
    low, high = (corner.numbers(3) for corner in box)
    if any(a > b for a, b in zip(low, high, strict=True)):
        raise field["box"].error(f"{field['box'].value!r} has a first corner beyond its second")
    return ChunkEntry(
        field["id"].hash(),
        field["bytes"].whole(1, MAX_CHUNK_BYTES),
        field["splats"].whole(1, MAX_SPLATS),
        (_triple(low), _triple(high)),
    )


def _camera(field: Field) -> Camera:
    try:
        return Camera.from_json(dict(field.mapping()))
    except InputError as error:
        raise field.error(str(error)) from error


def _slice(field: Field) -> SliceEntry:
    return SliceEntry(
        field["segment"].whole(0),
        field["start"].number(),
        field["end"].number(low=field["start"].number()),
        tuple(_chunk(chunk) for chunk in field["chunks"].items()),
        tuple(item.hash() for item in field["needs"].items()),
    )


def _triple(numbers: tuple[float, ...]) -> tuple[float, float, float]:
    x, y, z = numbers
    return x, y, z


def _check_references(manifest: Manifest, root: Field) -> None:
    """Check that the lists agree; `root` is the document that the manifest was read from.

    Raises:
        InputError: names the field, what it is and what it should be.
    """
    for name in ("segments", "slices", "cameras"):
        if not getattr(manifest, name):
            raise root[name].error("is empty, expected at least one")
    for name, entries in (("segments", manifest.segments), ("slices", manifest.slices)):
        starts = [entry.start for entry in entries]
        for i in range(1, len(starts)):
            if starts[i] < starts[i - 1]:
                raise root[name].items()[i]["start"].error(f"is {starts[i]}, before the one that precedes it")
    known: set[str] = {chunk.id for chunk in manifest.static}
    if len(known) < len(manifest.static):
        raise root["static"].error("lists a chunk twice")
    earlier: dict[str, int] = {}  # chunk -> segment
    for piece, field in zip(manifest.slices, root["slices"].items(), strict=True):
        if piece.segment >= len(manifest.segments):
            raise field["segment"].error(f"is {piece.segment}, expected below {len(manifest.segments)}")
        for need, item in zip(piece.needs, field["needs"].items(), strict=True):
            if earlier.get(need) != piece.segment:
                raise item.error(f"{need} is not a chunk of an earlier slice of the segment")
        for chunk, item in zip(piece.chunks, field["chunks"].items(), strict=True):
            if chunk.id in known:
                raise item["id"].error(f"{chunk.id} is listed twice")
            known.add(chunk.id)
            earlier[chunk.id] = piece.segment
    for number, sound in enumerate(manifest.audio.pieces if manifest.audio else ()):
        if sound.id in known:
            raise root["audio"]["pieces"].items()[number]["id"].error(f"{sound.id} is a chunk of splats")
    for name, total in vars(manifest.totals).items():
        stated = root["totals"][name].whole(0)
        if stated != total:
            raise root["totals"][name].error(f"is {stated}, but the chunks add up to {total}")
