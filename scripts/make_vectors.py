"""Write tests/vectors: chunks, their decoded splats, and damaged ones with the required error.

The Python and the TypeScript decoder are both tested against these files. Run it after a change of the format, or to
add a case:

    .venv/bin/python scripts/make_vectors.py

Valid chunks that are there are kept: which numbers a chunk holds is the encoder's choice and no part of the format, so
every improvement of the encoder would change them all. Everything else follows from them, so while the format stays as
it is, so do the files. Only damaged chunks whose frames are compressed here may differ in their bytes with another
version of zstd. `--encode` encodes the valid chunks anew, as is needed once they can no longer be decoded.
"""

from __future__ import annotations

import argparse
import base64
import dataclasses
import json
import struct
import sys
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.codec.encoder.encode_chunk import encode_static_chunk
from hgs_core.codec.encoder.encode_dynamic import SegmentTime, encode_dynamic_chunk
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.prepare import prepare_dynamic, prepare_static
from hgs_core.codec.format.chunk import ENTRY, HEADER, Stream, pack, unpack, varint
from hgs_core.codec.format.decode import decode_chunk
from hgs_core.codec.format.format_error import ChunkError
from hgs_core.codec.format.quantise import Grid
from hgs_core.codec.format.streams import compress
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats

OUT = Path(__file__).resolve().parent.parent / "tests" / "vectors"
SETTINGS = EncodeSettings()
CAMERA = Camera("cam00", 640, 360, 500.0, 501.0, 320.0, 180.0, np.eye(4))

Floats = NDArray[np.float32]


def statics(count: int, seed: int, spread: float = 2.0) -> StaticSplats[Floats]:
    rng = np.random.default_rng(seed)
    return StaticSplats(
        rng.normal(0, spread, (count, 3)).astype(np.float32),
        rng.normal(-4, 1, (count, 3)).astype(np.float32),
        rng.normal(0, 1, (count, 4)).astype(np.float32),
        rng.normal(1, 2, count).astype(np.float32),
        rng.uniform(0, 1, (count, 3)).astype(np.float32),
    )


def dynamics(count: int, seed: int, motion: float = 0.3, order: int = 3) -> DynamicSplats[Floats]:
    rng = np.random.default_rng(seed)
    still = statics(count, seed)
    coefficients = rng.normal(0, motion, (count, order + 1, 3)).astype(np.float32)
    coefficients[:, 0] = still.means
    rotation = np.stack([still.quats, rng.normal(0, motion, (count, 4)).astype(np.float32)], axis=1)
    return DynamicSplats(
        coefficients,
        rotation,
        still.log_scales,
        still.opacity_logits,
        rng.uniform(-0.1, 1.1, count).astype(np.float32),
        rng.normal(4, 2, count).astype(np.float32),
        still.rgb,
    )


def static_chunk(splats: StaticSplats[Floats], settings: EncodeSettings = SETTINGS) -> bytes:
    return encode_static_chunk(prepare_static(splats, [CAMERA], None, settings), settings, 0)[0]


def dynamic_chunk(splats: DynamicSplats[Floats]) -> bytes:
    prepared = prepare_dynamic(splats, 1.0, 0.02, [CAMERA], None, SETTINGS)
    return encode_dynamic_chunk(prepared, SegmentTime(2.0, 3.5, 1.0), SETTINGS, 7)[0]


def with_unknown_attribute(data: bytes) -> bytes:
    """Add an attribute of a later version of the format: its number, quantiser and content mean nothing yet."""
    container = unpack(data)
    grid = Grid(float("nan"), (5, -3), 99)
    unknown = Stream(attribute=200, components=2, transform=77, grid=grid, planes=(memoryview(b"later"),))
    return pack(dataclasses.replace(container, streams=(unknown, *container.streams)))


def sealed(data: bytes | bytearray) -> bytes:
    """Make the checksum right again, so that the fault behind it is met."""
    body = bytes(data[:-4])
    return body + struct.pack("<I", zlib.crc32(body))


def poke(data: bytes, at: int, fmt: str, value: object) -> bytes:
    changed = bytearray(data)
    struct.pack_into("<" + fmt, changed, at, value)
    return sealed(changed)


def without(data: bytes, attribute: int) -> bytes:
    container = unpack(data)
    streams = tuple(stream for stream in container.streams if stream.attribute != attribute)
    return pack(dataclasses.replace(container, streams=streams))


def with_planes(data: bytes, attribute: int, planes: list[bytes]) -> bytes:
    """Replace the planes of an attribute, given before compression."""
    container = unpack(data)
    frames = tuple(memoryview(compress(plane, 3)) for plane in planes)
    streams = [s._replace(planes=frames) if s.attribute == attribute else s for s in container.streams]
    return pack(dataclasses.replace(container, streams=tuple(streams)))


def of_version(data: bytes, version: int) -> bytes:
    return pack(dataclasses.replace(unpack(data), version=version))


def invalid(static: bytes, dynamic: bytes, fifth: bytes) -> dict[str, bytes]:
    entry = HEADER.size
    container = unpack(static)
    first, second = container.streams[:2]
    lengths = entry + ENTRY.size + sum(len(varint(2 * abs(zero))) for zero in first.grid.zeros)
    flipped = bytearray(static)
    flipped[len(static) // 2] ^= 0x10
    frame = bytearray(static)
    frame[first.data_at[0]] ^= 0xFF
    count = container.count
    other_count = {"box": container.box, "count": count - 1}
    forms = unpack(dynamic).count
    return {
        "empty": b"",
        "truncated_header": static[:40],
        "truncated_data": static[:-20],
        "extended": static + b"\0",
        "flipped_bit": bytes(flipped),
        "wrong_magic": b"PLY\n" + static[4:],
        "earlier_version": poke(static, 4, "B", 1),
        "later_version": poke(static, 4, "B", 4),
        "unknown_kind": poke(static, 5, "B", 2),
        "too_many_attributes": poke(static, 6, "B", 255),
        "reserved_byte": poke(static, 7, "B", 1),
        "no_splats": poke(static, 8, "I", 0),
        "lying_count": poke(static, 8, "I", 1 << 20),
        "count_one_less": pack(dataclasses.replace(container, **other_count)),
        "count_beyond_limit": poke(static, 8, "I", 1 << 31),
        "box_not_a_number": poke(static, 20, "f", float("nan")),
        "box_inside_out": poke(static, 20, "f", 1e9),
        "endless_time": poke(static, 52, "d", float("inf")),
        "bound_not_a_number": poke(static, 64, "f", float("nan")),
        "negative_bound": poke(static, 60, "f", -1.0),
        "repeated_attribute": poke(static, second.at, "B", 1),
        "missing_attribute": poke(static, entry, "B", 99),
        "wrong_components": poke(static, entry + 1, "B", 2),
        "no_bits": poke(static, entry + 2, "B", 0),
        "too_many_bits": poke(static, entry + 2, "B", 25),
        "fewer_bits": poke(static, second.at + 2, "B", 1),
        "wrong_transform": poke(static, entry + 3, "B", 1),
        "unknown_transform": poke(static, second.at + 3, "B", 3),
        "wrong_planes": poke(static, entry + 4, "B", 3),
        "endless_planes": poke(static, entry + 4, "B", 255),
        "step_of_zero": poke(static, entry + 5, "f", 0.0),
        "step_not_finite": poke(static, entry + 5, "f", float("inf")),
        "step_overflows": poke(static, second.at + 5, "f", 3e38),
        "endless_number": poke(static, entry + 9, "I", 0xFFFFFFFF),
        "zero_beyond_limit": poke(static, entry + 9, "Q", 0x0FFFFFFFFF),
        "length_beyond_end": poke(static, lengths, "H", 0x7FFF),
        "frame_damaged": sealed(frame),
        "frame_of_other_length": with_planes(static, 4, [bytes(count + 1)]),
        "frame_of_a_billion": with_planes(static, 4, [bytes(1 << 26)]),
        "codes_beyond_the_grid": with_planes(static, 1, [b"\xff" * count] * len(first.planes)),
        "static_called_dynamic": poke(static, 5, "B", 1),
        "dynamic_truncated": dynamic[: len(dynamic) // 2],
        "form_unknown": with_planes(dynamic, 18, [b"\x08" * forms]),
        "form_without_rows": with_planes(dynamic, 18, [bytes(forms)]),
        "rows_without_form": without(dynamic, 18),
        "form_without_attribute": without(dynamic, 19),
        "form_of_fewer_rows": with_planes(dynamic, 18, [b"\x07" * forms]),
        "form_beyond_the_version": of_version(fifth, 2),
        "form_beyond_the_fifth": with_planes(fifth, 18, [b"\x10" * unpack(fifth).count]),
        "form_of_fifth_without_third": with_planes(fifth, 18, [b"\x0a" * unpack(fifth).count]),
        "fifth_without_attribute": without(fifth, 24),
        "fourth_without_rows": with_planes(fifth, 18, [b"\x07" * unpack(fifth).count]),
    }


def expected(data: bytes) -> dict[str, object]:
    chunk = decode_chunk(data)
    return {
        "kind": chunk.kind.name.lower(),
        "count": chunk.count,
        "time_range": chunk.time_range,
        "box": chunk.box,
        "bounds": chunk.bounds._asdict(),
        "float32": {name: base64.b64encode(array.tobytes()).decode() for name, array in chunk.arrays.items()},
    }


def error_of(data: bytes) -> dict[str, object]:
    try:
        decode_chunk(data)
    except ChunkError as error:
        return {"byte": error.byte, "record": error.record}
    raise AssertionError("a damaged chunk decodes")


def manifest() -> dict[str, object]:
    """A small manifest with two segments, a chunk that is needed later, and a field of a later version."""

    def chunk(number: int, splats: int) -> dict[str, object]:
        return {"id": f"{number:064x}", "bytes": 100 * number, "splats": splats, "box": [[-1, 0, 1], [1.5, 2, 3]]}

    camera = Camera("cam00", 640, 360, 500.0, 501.0, 320.0, 180.0, np.eye(4))
    times = [(0, 0.0, 0.5), (0, 0.5, 1.0), (1, 1.0, 2.0)]
    chunks = [[chunk(3, 30)], [], [chunk(4, 40)]]
    needs = [[], [f"{3:064x}"], []]
    return {
        "format": "hgs-scene",
        "version": 2,
        "title": "Two segments",
        "start": 0.0,
        "end": 2.0,
        "frame_rate": 30.0,
        "background": [0, 0, 0],
        "up": [0, -1, 0],
        "center": [0, 0, 2],
        "extent": 2.5,
        "cameras": [camera.to_json()],
        "segments": [{"start": 0.0, "end": 1.0}, {"start": 1.0, "end": 2.0}],
        "static": [chunk(1, 10), chunk(2, 20)],
        "slices": [
            {"segment": segment, "start": start, "end": end, "chunks": new, "needs": old}
            for (segment, start, end), new, old in zip(times, chunks, needs, strict=True)
        ],
        "totals": {"splats_static": 30, "splats_dynamic": 70, "bytes_static": 300, "bytes_dynamic": 700},
        "thumbnail": True,
        "training": {"psnr": 31.5},
        "antialiased": True,
        "later": "ignored",
        "metres_per_unit": 0.5,
        "captured_space": {
            "front": [0, 0, -1],
            "azimuth": 0.7,
            "elevation": [-0.25, 0.3],
            "distance": [1.0, 2.5],
        },
    }


def captured_spaces() -> list[dict[str, object]]:
    """Spaces with places inside and outside, placed so that their numbers are known."""
    worlds = (  # center, up, front, and what points to azimuth 90 degrees
        ((1.0, 2.0, 3.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((0.0, 0.5, -2.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),
        ((-4.0, 0.0, 1.0), (0.6, 0.8, 0.0), (-0.8, 0.6, 0.0), (0.0, 0.0, 1.0)),
    )
    arc = {"azimuth": 0.7, "elevation": [-0.25, 0.3], "distance": [1.0, 2.5]}
    dome = {"elevation": [-0.5, 1.2], "distance": [0.5, 4.0]}
    places = (  # azimuth, elevation, distance, inside the arc, inside the dome
        (0.0, 0.0, 2.0, True, True),
        (0.65, 0.29, 1.01, True, True),
        (-0.69, -0.24, 2.49, True, True),
        (0.75, 0.0, 2.0, False, True),
        (-0.75, 0.0, 2.0, False, True),
        (3.0, 0.1, 2.0, False, True),
        (-3.0, 0.1, 2.0, False, True),
        (0.1, 0.35, 2.0, False, True),
        (0.1, -0.3, 2.0, False, True),
        (0.1, -0.6, 2.0, False, False),
        (0.1, 1.25, 2.0, False, False),
        (0.1, 0.1, 0.9, False, True),
        (0.1, 0.1, 2.6, False, True),
        (0.1, 0.1, 0.4, False, False),
        (0.1, 0.1, 5.0, False, False),
    )
    found: list[dict[str, object]] = []
    for center, up, front, side in worlds:
        for space, column in ((arc, 3), (dome, 4)):
            rows = []
            for place in places:
                azimuth, elevation, distance = place[:3]
                ahead, aside = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)
                direction = ahead * np.array(front) + aside * np.array(side) + np.sin(elevation) * np.array(up)
                eye = np.array(center) + distance * direction
                rows.append(
                    {
                        "eye": eye.tolist(),
                        "azimuth": azimuth,
                        "elevation": elevation,
                        "distance": distance,
                        "inside": place[column],
                    }
                )
            found.append({"center": center, "up": up, "captured_space": {"front": front} | space, "places": rows})
    return found + [_with_seen(case) for case in found[:2]]


SEEN = {
    "elevation": [[-0.2, 0.1], [-0.25, 0.3], [0.05, 0.05]],
    "distance": [
        [[1.0, 1.5], [1.0, 2.5]],
        [[1.2, 2.0], [1.0, 2.5]],
        [[1.5, 1.5], [1.4, 1.8]],
    ],
}
"""Limits for either space: columns of two rows."""


def _with_seen(case: dict[str, Any]) -> dict[str, object]:
    """The same places and more in the same space with narrower limits, which numpy interpolates."""
    space = case["captured_space"] | {"seen": SEEN}
    if "azimuth" in space:
        space["seen"] = SEEN | {"azimuth": [-0.68, 0.5]}
    up, front = np.array(case["up"]), np.array(space["front"])
    half, low, high = space.get("azimuth"), *space["elevation"]
    count = len(SEEN["elevation"])
    at = np.linspace(-half, half, count) if half else np.arange(count) / count * 2 * np.pi
    period = None if half else 2 * np.pi
    rows = []
    for azimuth in (-0.69, -0.67, 0.1, 0.6, 2.5, -3.0):
        inside = not half or -0.68 <= azimuth <= 0.5

        def mixed(column: list[list[float]], azimuth: float = azimuth) -> list[float]:
            return [float(np.interp(azimuth, at, ends, period=period)) for ends in np.transpose(column)]

        lowest, highest = mixed(SEEN["elevation"])
        for elevation in (lowest - 0.01, (lowest + highest) / 2, highest - 1e-6):
            pairs = [mixed([column[row] for column in SEEN["distance"]]) for row in (0, 1)]
            nearest, farthest = (float(np.interp(elevation, [low, high], ends)) for ends in np.transpose(pairs))
            for distance in (nearest - 0.01, (nearest + farthest) / 2, farthest + 0.01):
                ahead, aside = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)
                direction = ahead * front + aside * np.cross(up, front) + np.sin(elevation) * up
                rows.append(
                    {
                        "eye": (np.array(case["center"]) + distance * direction).tolist(),
                        "azimuth": azimuth,
                        "elevation": float(elevation),
                        "distance": distance,
                        "inside": bool(inside and lowest <= elevation <= highest and nearest <= distance <= farthest),
                    }
                )
    return {"center": case["center"], "up": case["up"], "captured_space": space, "places": rows}


WRONG_SEEN: list[tuple[list[Any], Any, str]] = [
    (["azimuth"], [0.5, -0.68], "seen.azimuth"),
    (["azimuth"], [-0.68, 0.71], "seen.azimuth"),
    (["azimuth"], 0.5, "seen.azimuth"),
    (["elevation"], None, "seen.elevation"),
    (["elevation"], [[0.0, 0.1]], "seen.elevation"),
    (["elevation", 1], [0.3, -0.25], "seen.elevation[1]"),
    (["elevation", 1], [-0.25, 0.31], "seen.elevation[1]"),
    (["elevation", 2, 0], "low", "seen.elevation[2][0]"),
    (["distance"], [[[1.0, 1.5], [1.0, 2.5]]], "seen.distance"),
    (["distance", 1], [], "seen.distance[1]"),
    (["distance", 2], [[1.5, 1.5], [1.4, 1.8], [1.4, 1.8]], "seen.distance[2]"),
    (["distance", 0, 0], [0.9, 1.5], "seen.distance[0][0]"),
    (["distance", 0, 1], [2.5, 1.0], "seen.distance[0][1]"),
    (["distance", 0, 1], [1.0, 2.5, 2.5], "seen.distance[0][1]"),
]
"""Changes to the limits of the first space that has them, and the field that is wrong then."""


def audio() -> dict[str, object]:
    """The sound that this manifest may have, with a silence between two pieces of equal content."""
    pieces = [
        {"id": f"{name:064x}", "bytes": size, "start": start, "end": end}
        for name, size, start, end in (
            (16, 9000, -0.013, 0.987),
            (17, 700, 0.987, 1.5),
            (18, 650, 1.5, 1.7),
            (18, 650, 1.9, 2.1),
        )
    ]
    return {"codec": "opus", "sample_rate": 48000, "channels": 2, "pieces": pieces}


# What is put where in that sound, and the field that the error must name. A value of None removes the field.
INVALID_AUDIO: list[tuple[list[str | int], object, str]] = [
    (["codec"], 3, "audio.codec"),
    (["codec"], None, "audio.codec"),
    (["sample_rate"], 0, "audio.sample_rate"),
    (["channels"], 1.5, "audio.channels"),
    (["pieces"], [], "audio.pieces"),
    (["pieces", 0, "id"], "../../secret", "audio.pieces[0].id"),
    (["pieces", 0, "bytes"], 0, "audio.pieces[0].bytes"),
    (["pieces", 3, "bytes"], 651, "audio.pieces[3].bytes"),
    (["pieces", 1, "end"], 0.987, "audio.pieces[1].end"),
    (["pieces", 1, "start"], -0.013, "audio.pieces[1].start"),
    (["pieces", 2, "start"], None, "audio.pieces[2].start"),
]


# What is put where in that manifest, and the field that the error must name. A value of None removes the field.
WRONG_FIELDS: list[tuple[list[str | int], object, str]] = [
    (["format"], "ply", "manifest.format"),
    (["version"], 1, "manifest.version"),
    (["version"], 4, "manifest.version"),
    (["title"], 3, "manifest.title"),
    (["title"], None, "manifest.title"),
    (["end"], -1.0, "manifest.end"),
    (["frame_rate"], 0, "manifest.frame_rate"),
    (["background"], [0, 0], "manifest.background"),
    (["up", 1], "down", "manifest.up[1]"),
    (["extent"], -2, "manifest.extent"),
    (["cameras"], [], "manifest.cameras"),
    (["segments"], {}, "manifest.segments"),
    (["segments", 1, "start"], -1.0, "manifest.segments[1].start"),
    (["static", 0, "id"], "../../secret", "manifest.static[0].id"),
    (["static", 1, "id"], f"{1:064x}", "manifest.static"),
    (["static", 0, "bytes"], 0, "manifest.static[0].bytes"),
    (["static", 0, "splats"], 1.5, "manifest.static[0].splats"),
    (["static", 0, "box", 0, 0], 2, "manifest.static[0].box"),
    (["slices", 0, "segment"], 2, "manifest.slices[0].segment"),
    (["slices", 1, "start"], -0.5, "manifest.slices[1].start"),
    (["slices", 2, "needs"], [f"{3:064x}"], "manifest.slices[2].needs[0]"),
    (["slices", 2, "chunks", 0, "id"], f"{3:064x}", "manifest.slices[2].chunks[0].id"),
    (["totals", "bytes_static"], 301, "manifest.totals.bytes_static"),
    (["thumbnail"], "yes", "manifest.thumbnail"),
    (["training"], [], "manifest.training"),
    (["antialiased"], 1, "manifest.antialiased"),
    (["metres_per_unit"], 0, "manifest.metres_per_unit"),
    (["metres_per_unit"], "1", "manifest.metres_per_unit"),
    (["live"], 0, "manifest.live"),
    (["live"], True, "manifest.live"),
    (["captured_space"], [], "manifest.captured_space"),
    (["captured_space", "front"], None, "manifest.captured_space.front"),
    (["captured_space", "front", 2], "ahead", "manifest.captured_space.front[2]"),
    (["captured_space", "azimuth"], 0, "manifest.captured_space.azimuth"),
    (["captured_space", "azimuth"], 3.1416, "manifest.captured_space.azimuth"),
    (["captured_space", "elevation"], [0.2, 0.1], "manifest.captured_space.elevation"),
    (["captured_space", "elevation"], None, "manifest.captured_space.elevation"),
    (["captured_space", "distance"], [0, 1], "manifest.captured_space.distance"),
    (["captured_space", "distance"], [2.0], "manifest.captured_space.distance"),
]


ENCODED: dict[str, Callable[[], bytes]] = {
    "static": lambda: static_chunk(statics(40, 1)),
    "static_one": lambda: static_chunk(statics(1, 3)),
    "static_wide": lambda: static_chunk(statics(30, 4, spread=3000.0)),
    "dynamic": lambda: dynamic_chunk(dynamics(40, 2)),
    # Of motions so large that splats of the fifth order lie among splats of lower ones.
    "dynamic_fifth_order": lambda: dynamic_chunk(dynamics(40, 6, motion=30.0, order=5)),
    "dynamic_still": lambda: dynamic_chunk(dynamics(20, 5, motion=0.0)),
}


def encoded(name: str, *, anew: bool) -> bytes:
    """Return a chunk of `ENCODED`: the one that is there, unless there is none or it shall be another."""
    file = OUT / f"{name}.chunk"
    if anew or not file.exists():
        return ENCODED[name]()
    data = file.read_bytes()
    try:
        decode_chunk(data)
    except ChunkError as error:
        sys.exit(f"{file}: cannot be decoded any more ({error}); encode the chunks anew with --encode")
    return data


def main() -> None:
    parser = argparse.ArgumentParser(description="Write tests/vectors.")
    parser.add_argument("--encode", action="store_true", help="encode the valid chunks anew, though they are there")
    options = parser.parse_args()
    (OUT / "invalid").mkdir(parents=True, exist_ok=True)
    valid = {name: encoded(name, anew=options.encode) for name in ENCODED}
    static, dynamic, fifth = (valid[name] for name in ("static", "dynamic", "dynamic_fifth_order"))
    valid["static_unknown_attribute"] = with_unknown_attribute(static)
    valid["dynamic_version_3"] = of_version(dynamic, 3)
    for name, data in valid.items():
        (OUT / f"{name}.chunk").write_bytes(data)
        (OUT / f"{name}.json").write_text(json.dumps(expected(data), indent=1) + "\n")
    errors: dict[str, object] = {}
    for name, data in invalid(static, dynamic, fifth).items():
        (OUT / "invalid" / f"{name}.chunk").write_bytes(data)
        errors[name] = error_of(data)
    (OUT / "invalid.json").write_text(json.dumps(errors, indent=1) + "\n")
    (OUT / "manifest.json").write_text(json.dumps(manifest(), indent=1) + "\n")
    (OUT / "captured_space.json").write_text(json.dumps(captured_spaces(), indent=1) + "\n")
    wrong = [{"at": at, "value": value, "field": field} for at, value, field in WRONG_SEEN]
    (OUT / "invalid_seen.json").write_text(json.dumps(wrong, indent=1) + "\n")
    wrong = [{"at": at, "value": value, "field": field} for at, value, field in WRONG_FIELDS]
    (OUT / "invalid_manifest.json").write_text(json.dumps(wrong, indent=1) + "\n")
    wrong = [{"at": at, "value": value, "field": field} for at, value, field in INVALID_AUDIO]
    (OUT / "audio.json").write_text(json.dumps({"audio": audio(), "invalid": wrong}, indent=1) + "\n")


if __name__ == "__main__":
    main()
