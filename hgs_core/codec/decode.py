"""From the bytes of a chunk to float arrays, bit for bit as docs/format.md states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.codec import morton
from hgs_core.codec.attributes import ATTRIBUTES, BY_ID, FIFTH, LARGEST_FORM, MOTION_ORDERS, Attribute, Kind
from hgs_core.codec.chunk import VERSIONS, Bounds, Box, Container, Stream, unpack
from hgs_core.codec.errors import ChunkError
from hgs_core.codec.quantise import MAX_BITS, eased, unit_quats
from hgs_core.codec.streams import Transform, decompress, from_planes, undo_transform
from hgs_core.scene.motion import COEFFICIENTS
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = [
    "DecodedChunk",
    "arrays_of",
    "decode_chunk",
    "dynamic_splats",
    "logits",
    "rows_of",
    "static_splats",
    "time_exponents",
]

TABLE = 80  # byte at which the attribute table begins

# An opacity of 1 has no logit; alpha is clamped to 0.99, so this one cannot be told from it.
LARGEST_OPACITY = 1 - 1e-6

Floats = NDArray[np.float32]
Rows = Mapping[str, NDArray[np.intp] | int]


@dataclass(frozen=True)
class DecodedChunk:
    """What a chunk holds, float32. Static: means [N, 3], quats [N, 4]. Dynamic: motion [N, K, 3], rotation [N, 2, 4],
    time_centers [N], time_log_precisions [N]; K is 6 if a splat moves in the fifth order, else 4. Both:
    log_scales [N, 3], opacities [N] in [0, 1], rgb [N, 3].
    """

    kind: Kind
    count: int
    index: int
    time_range: tuple[float, float]  # seconds
    box: Box  # world units; holds the centre of every splat whenever it can be seen
    bounds: Bounds
    arrays: Mapping[str, Floats]
    version: int = VERSIONS[0]

    def static(self) -> StaticSplats[Floats]:
        """Return the splats of a static chunk."""
        return static_splats(self.arrays)

    def dynamic(self) -> DynamicSplats[Floats]:
        """Return the splats of a dynamic chunk, in the normalised time of `time_range`."""
        return dynamic_splats(self.arrays)


def static_splats(arrays: Mapping[str, Floats]) -> StaticSplats[Floats]:
    """Return static splats of arrays named as in `DecodedChunk`."""
    a = arrays
    return StaticSplats(a["means"], a["log_scales"], a["quats"], logits(a["opacities"]), a["rgb"])


def dynamic_splats(arrays: Mapping[str, Floats]) -> DynamicSplats[Floats]:
    """Return dynamic splats of arrays named as in `DecodedChunk`."""
    a = arrays
    return DynamicSplats(
        a["motion"],
        a["rotation"],
        a["log_scales"],
        logits(a["opacities"]),
        a["time_centers"],
        a["time_log_precisions"],
        a["rgb"],
    )


def logits(opacities: NDArray[np.floating[Any]]) -> Floats:
    """Return the logits [N] of opacities; those of 0 and 1 are about -14 and 17."""
    clipped = np.clip(opacities.astype(np.float64), 1e-6, LARGEST_OPACITY)
    return np.log(clipped / (1 - clipped)).astype(np.float32)


def decode_chunk(data: bytes) -> DecodedChunk:
    """Decode a chunk.

    Every size is checked before anything is allocated, so memory is bounded by the number of splats the container
    may state (`chunk.MAX_SPLATS`).

    Raises:
        ChunkError: the bytes are not a valid chunk.
    """
    with np.errstate(over="ignore"):  # once for all: what overflows is refused by name in the end
        return _decoded(unpack(data))


def _decoded(container: Container) -> DecodedChunk:
    streams: dict[str, Stream] = {}
    for stream in container.streams:
        attribute = BY_ID.get(stream.attribute)
        if attribute is None or (attribute.dynamic_only and container.kind == Kind.STATIC):
            continue  # of a later version of the format
        if attribute.version > container.version:
            continue
        _check_entry(stream, attribute)
        streams[attribute.name] = stream
    rows = _rows(container, streams)
    for name, attribute in ATTRIBUTES.items():
        if name in rows and name not in streams:
            raise ChunkError(TABLE, "attribute table", f"without {name}", f"attribute {attribute.id}")
        if name in streams and name != "form" and name not in rows:
            raise ChunkError(
                streams[name].at, f"attribute {attribute.id} ({name})", "there", "no row of it by the form"
            )
    values = {name: _decode_stream(streams[name], ATTRIBUTES[name], _length(rows[name])) for name in rows}
    arrays = arrays_of(container.kind, values, rows, container.count)
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise ChunkError(TABLE, f"{name} of splat {_first_bad(array)}", "not finite", "a finite number")
    return DecodedChunk(
        container.kind, container.count, container.index, container.time_range, container.box, container.bounds, arrays,
        container.version,
    )  # fmt: skip


def arrays_of(kind: Kind, values: Mapping[str, Floats], rows: Rows, count: int) -> dict[str, Floats]:
    """Return the arrays of `DecodedChunk` for the values [rows, C] of all attributes.

    Raises:
        ChunkError: a time_log_precision is not finite.
    """
    arrays = {
        "log_scales": values["log_scale"],
        "opacities": eased(values["opacity"][:, 0]).astype(np.float32),
        "rgb": values["rgb"],
    }
    if kind == Kind.STATIC:
        return arrays | {"means": values["position"], "quats": unit_quats(values["rotation"])}
    return arrays | _dynamic_arrays(values, rows, count)


def time_exponents(log_precisions: Floats) -> NDArray[np.int32]:
    """Return e [N], 0 to 20: about the reciprocal of the time for which a splat can be seen is 2^e.

    floor((ln s - 1.75) * 0.7213475204444817) in binary64, clamped; then sqrt(ln(255) / s) <= 1.02 * 2^-e.
    """
    exact = (log_precisions.astype(np.float64) - 1.75) * 0.7213475204444817
    return np.clip(np.floor(exact), 0, 20).astype(np.int32)


def _rows(container: Container, streams: Mapping[str, Stream]) -> dict[str, NDArray[np.intp] | int]:
    if container.kind == Kind.STATIC or "form" not in streams:
        return rows_of(container.kind, container.count, None)
    stream = streams["form"]
    codes = _codes(stream, ATTRIBUTES["form"], container.count)[0]
    largest = LARGEST_FORM[container.version]
    wrong = (codes > largest) | ((codes >= FIFTH) & ((codes & codes.dtype.type(3)) < 3))
    if wrong.any():
        splat = int(wrong.argmax())
        expected = f"at most {largest}, of order 3 below the fifth"
        raise ChunkError(stream.data_at[0], f"form of splat {splat}", codes[splat], expected)
    return rows_of(container.kind, container.count, codes)


def rows_of(
    kind: Kind, count: int, codes: NDArray[np.unsignedinteger[Any]] | None
) -> dict[str, NDArray[np.intp] | int]:
    """Return which attributes have rows: those of all splats as their number, sparse ones as indices of splats.

    `codes` [N] are the splats' forms, if they have some.
    """
    rows: dict[str, NDArray[np.intp] | int] = {
        name: count
        for name, a in ATTRIBUTES.items()
        if not a.rows_of and (kind == Kind.DYNAMIC or not a.dynamic_only) and name != "form"
    }
    if codes is None:
        return rows
    for name, attribute in ATTRIBUTES.items():
        if not attribute.rows_of:
            continue
        members = np.flatnonzero(attribute.among(codes))
        if len(members):
            rows[name] = members
    return rows


def _length(rows: NDArray[np.intp] | int) -> int:
    return rows if isinstance(rows, int) else len(rows)


def _dynamic_arrays(values: Mapping[str, Floats], rows: Rows, count: int) -> dict[str, Floats]:
    precisions = values["time_log_precision"][:, 0]
    if not np.isfinite(precisions).all():
        raise ChunkError(TABLE, f"time_log_precision of splat {_first_bad(precisions)}", "not finite", "finite")
    exponents = time_exponents(precisions)
    motion = np.zeros((count, COEFFICIENTS["crackle" in values], 3), np.float32)
    rotation = np.zeros((count, 2, 4), np.float32)
    motion[:, 0] = values["position"]
    rotation[:, 0] = unit_quats(values["rotation"])
    for array, names in ((motion, MOTION_ORDERS), (rotation, ("turning",))):
        for order, name in enumerate(names, start=1):
            if name in values:
                members = rows[name]
                array[members, order] = np.ldexp(values[name], order * exponents[members, None])
    return {
        "motion": motion,
        "rotation": rotation,
        "time_centers": np.ldexp(values["time_center"][:, 0], -exponents),
        "time_log_precisions": precisions,
    }


def _check_entry(stream: Stream, attribute: Attribute) -> None:
    """Check an attribute's row of the table against what the attribute must be."""
    record = f"attribute {attribute.id} ({attribute.name})"
    bits = stream.grid.bits
    if stream.components != attribute.components:
        raise ChunkError(stream.at + 1, f"{record} components", stream.components, attribute.components)
    if not 1 <= bits <= MAX_BITS:
        raise ChunkError(stream.at + 2, f"{record} bits", bits, f"1 to {MAX_BITS}")
    if stream.transform not in attribute.transforms:
        raise ChunkError(stream.at + 3, f"{record} transform", stream.transform, sorted(attribute.transforms))
    if len(stream.planes) != attribute.planes(bits):
        raise ChunkError(stream.at + 4, f"{record} planes", len(stream.planes), attribute.planes(bits))
    if not 0 < stream.grid.step < np.inf:
        raise ChunkError(stream.at + 5, f"{record} step", stream.grid.step, "above 0 and finite")


def _codes(stream: Stream, attribute: Attribute, rows: int) -> list[NDArray[np.unsignedinteger[Any]]]:
    """Return the codes of each component, [rows] each."""
    bits = stream.grid.bits
    record = f"attribute {attribute.id} ({attribute.name})"
    planes: list[NDArray[np.uint8]] = []
    for p, (frame, at) in enumerate(zip(stream.planes, stream.data_at, strict=True)):
        try:
            planes.append(decompress(frame, rows))
        except ValueError as error:
            raise ChunkError(at, f"{record} plane {p}", error, f"a zstd frame of {rows} bytes") from error
    if attribute.morton:
        try:
            return morton.grid_points(planes, bits)
        except ValueError as error:
            raise ChunkError(stream.data_at[0], f"{record} codes", error, f"below 2^{3 * bits}") from error
    codes = from_planes(planes, bits)
    if bits % 8:
        for c, component in enumerate(codes):
            if component.max() >> bits:
                splat = int(component.argmax())
                at = stream.data_at[c * ((bits + 7) // 8)]
                raise ChunkError(at, f"{record} code of row {splat}", component[splat], f"below 2^{bits}")
    return undo_transform(codes, bits, Transform(stream.transform))


def _decode_stream(stream: Stream, attribute: Attribute, rows: int) -> Floats:
    """Return the values [rows, C] of one attribute."""
    components = _codes(stream, attribute, rows)  # first, so that nothing is allocated for rows that are not there
    values = np.empty((rows, attribute.components), np.float32)
    for c, codes in enumerate(components):
        values[:, c] = stream.grid.decode(codes, c)
    return values


def _first_bad(array: Floats) -> int:
    return int(np.argmin(np.isfinite(array).reshape(len(array), -1).all(axis=1)))
