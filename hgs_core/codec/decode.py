"""From the bytes of a chunk to float arrays, bit for bit as docs/format.md states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hgs_core.codec import morton
from hgs_core.codec.attributes import ATTRIBUTES, BY_ID, MOTION_ORDERS, Attribute, Kind, Quantiser
from hgs_core.codec.chunk import Box, Stream, unpack
from hgs_core.codec.errors import ChunkError
from hgs_core.codec.quantise import MAX_BITS, quats_from_smallest_three
from hgs_core.codec.streams import Transform, decompress, from_planes, undo_transform
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["DecodedChunk", "decode_chunk"]

MAX_EXPONENT = 40  # of 2, either sign

# An opacity of 1 has no logit; alpha is clamped to 0.99, so this one cannot be told from it.
LARGEST_OPACITY = 1 - 1e-6

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class DecodedChunk:
    """What a chunk holds, float32. Static: means [N, 3], quats [N, 4]. Dynamic: motion [N, 4, 3], rotation [N, 2, 4],
    time_centers [N], time_log_precisions [N]. Both: log_scales [N, 3], opacities [N] in [0, 1], rgb [N, 3].
    """

    kind: Kind
    count: int
    index: int
    time_range: tuple[float, float]  # seconds
    box: Box  # world units; holds the centre of every splat whenever it can be seen
    arrays: Mapping[str, Floats]
    bounds: Mapping[str, float]  # declared error per attribute (names of `ATTRIBUTES`)
    attributes: Mapping[str, Floats]  # [N, C] as stored, before powers of two are applied

    def static(self) -> StaticSplats[Floats]:
        """Return the splats of a static chunk."""
        a = self.arrays
        return StaticSplats(a["means"], a["log_scales"], a["quats"], _logits(a["opacities"]), a["rgb"])

    def dynamic(self) -> DynamicSplats[Floats]:
        """Return the splats of a dynamic chunk, in the normalised time of `time_range`."""
        a = self.arrays
        return DynamicSplats(
            a["motion"],
            a["rotation"],
            a["log_scales"],
            _logits(a["opacities"]),
            a["time_centers"],
            a["time_log_precisions"],
            a["rgb"],
        )


def decode_chunk(data: bytes) -> DecodedChunk:
    """Decode a chunk.

    Every size is checked before anything is allocated, so memory is bounded by the number of splats the container
    may state (`chunk.MAX_SPLATS`).

    Raises:
        ChunkError: the bytes are not a valid chunk.
    """
    container = unpack(data)
    count = container.count
    values: dict[str, Floats] = {}
    bounds: dict[str, float] = {}
    for stream in container.streams:
        attribute = BY_ID.get(stream.attribute)
        if attribute is None or (attribute.dynamic_only and container.kind == Kind.STATIC):
            continue  # of a later version of the format
        values[attribute.name] = _decode_stream(stream, attribute, count)
        bounds[attribute.name] = stream.grid.bound
    for attribute in ATTRIBUTES.values():
        if attribute.name in values or (attribute.dynamic_only and container.kind == Kind.STATIC):
            continue
        if not attribute.optional:
            raise ChunkError(64, "attribute table", f"without {attribute.name}", f"attribute {attribute.id}")
    arrays = {
        "log_scales": values["log_scale"],
        "opacities": np.clip(values["opacity"][:, 0], np.float32(0), np.float32(1)),
        "rgb": values["rgb"],
    }
    if container.kind == Kind.STATIC:
        arrays |= {"means": values["position"], "quats": values["rotation"]}
    else:
        arrays |= _dynamic_arrays(values, count)
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise ChunkError(64, f"{name} of splat {_first_bad(array)}", "not finite", "a finite number")
    return DecodedChunk(
        container.kind, count, container.index, container.time_range, container.box, arrays, bounds, values
    )


def _dynamic_arrays(values: Mapping[str, Floats], count: int) -> dict[str, Floats]:
    exponents = values["time_exponent"][:, 0]
    whole = (np.abs(exponents) <= MAX_EXPONENT) & (exponents == np.rint(exponents))
    if not whole.all():
        splat = int(np.argmin(whole))
        raise ChunkError(64, f"time_exponent of splat {splat}", exponents[splat], f"a whole number to {MAX_EXPONENT}")
    power = np.ldexp(1.0, exponents.astype(np.int32))[:, None]  # float64: exact
    motion = np.zeros((count, 4, 3), np.float32)
    rotation = np.zeros((count, 2, 4), np.float32)
    motion[:, 0] = values["position"]
    rotation[:, 0] = values["rotation"]
    with np.errstate(over="ignore"):
        for order, name in enumerate(MOTION_ORDERS, start=1):
            if name in values:
                motion[:, order] = (values[name].astype(np.float64) * power**order).astype(np.float32)
        if "turning" in values:
            rotation[:, 1] = (values["turning"].astype(np.float64) * power).astype(np.float32)
    return {
        "motion": motion,
        "rotation": rotation,
        "time_centers": values["time_center"][:, 0],
        "time_log_precisions": values["time_log_precision"][:, 0],
    }


def _decode_stream(stream: Stream, attribute: Attribute, count: int) -> Floats:
    """Return the values [N, C] of one attribute; C is 4 for rotations."""
    record = f"attribute {stream.attribute} ({attribute.name})"
    bits = stream.grid.bits
    for offset, field, found, expected in (
        (1, "quantiser", stream.quantiser, attribute.quantiser.value),
        (3, "components", stream.components, attribute.components),
    ):
        if found != expected:
            raise ChunkError(stream.at + offset, f"{record} {field}", found, expected)
    green = attribute.name == "rgb"
    if stream.transform > Transform.GREEN or (stream.transform == Transform.GREEN and not green):
        raise ChunkError(stream.at + 2, f"{record} transform", stream.transform, "0, 1, or 2 for rgb")
    if attribute.quantiser == Quantiser.MORTON and stream.transform != Transform.NONE:
        raise ChunkError(stream.at + 2, f"{record} transform", stream.transform, 0)
    if not 1 <= bits <= MAX_BITS:
        raise ChunkError(stream.at + 4, f"{record} bits", bits, f"1 to {MAX_BITS}")
    if not stream.grid.step > 0:
        raise ChunkError(stream.at + 24, f"{record} step", stream.grid.step, "above 0")
    planes = planes_of(attribute, bits)
    if stream.raw_bytes != planes * count:
        raise ChunkError(stream.at + 16, f"{record} raw length", stream.raw_bytes, f"{planes} x {count} splats")
    try:
        raw = decompress(stream.data, stream.raw_bytes)
    except ValueError as error:
        raise ChunkError(
            stream.data_at, f"{record} data", error, f"a zstd frame of {stream.raw_bytes} bytes"
        ) from error
    if attribute.quantiser == Quantiser.MORTON:
        return stream.grid.decode(_grid_points(raw, count, bits, stream, record))
    index = np.zeros(count, np.uint32)
    if attribute.quantiser == Quantiser.SMALLEST_THREE:
        index = np.frombuffer(raw, np.uint8)[-count:].astype(np.uint32)
        _check_codes(index[:, None], 2, stream, f"{record} index")
        raw = raw[:-count]
    codes = from_planes(raw, count, attribute.components, bits)
    _check_codes(codes, bits, stream, record)
    values = stream.grid.decode(undo_transform(codes, bits, Transform(stream.transform)))
    return quats_from_smallest_three(index, values) if attribute.quantiser == Quantiser.SMALLEST_THREE else values


def planes_of(attribute: Attribute, bits: int) -> int:
    """Return how many bytes per splat an attribute of `bits` has before compression."""
    if attribute.quantiser == Quantiser.MORTON:
        return (3 * bits + 7) // 8
    planes = attribute.components * ((bits + 7) // 8)
    return planes + 1 if attribute.quantiser == Quantiser.SMALLEST_THREE else planes


def _grid_points(raw: bytes, count: int, bits: int, stream: Stream, record: str) -> NDArray[np.uint32]:
    """Return the grid points [N, 3] of a Morton stream."""
    planes = np.frombuffer(raw, np.uint8).reshape(-1, count)
    steps = np.zeros((count, morton.LIMBS), np.uint64)
    for p, plane in enumerate(planes):
        steps[:, p // 3] |= plane.astype(np.uint64) << np.uint64(8 * (p % 3))
    grid_codes = morton.accumulate(steps)
    # The codes ascend, so the last one shows whether any is too large.
    last = sum(int(x) << morton.LIMB_BITS * i for i, x in enumerate(grid_codes[-1]))
    if last >> (3 * bits):
        raise ChunkError(stream.data_at, f"{record} codes", "beyond the grid", f"below 2^{3 * bits}")
    return morton.deinterleave(grid_codes)


def _check_codes(codes: NDArray[np.uint32], bits: int, stream: Stream, record: str) -> None:
    if (codes >> np.uint32(bits)).any():
        splat = int(np.argmax((codes >> np.uint32(bits)).any(axis=1)))
        raise ChunkError(stream.data_at, f"{record} code of splat {splat}", codes[splat].max(), f"below 2^{bits}")


def _first_bad(array: Floats) -> int:
    return int(np.argmin(np.isfinite(array).reshape(len(array), -1).all(axis=1)))


def _logits(opacities: Floats) -> Floats:
    clipped = np.clip(opacities.astype(np.float64), 1e-6, LARGEST_OPACITY)
    return np.log(clipped / (1 - clipped)).astype(np.float32)
