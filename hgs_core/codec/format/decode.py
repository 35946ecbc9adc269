"""From the bytes of a chunk to float arrays, bit for bit as docs/format.md states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.codec.format.attributes import ATTRIBUTES, BY_ID, FIFTH, LARGEST_FORM, MOTION_ORDERS, Kind
from hgs_core.codec.format.chunk import VERSIONS, Bounds, Box, Container, Stream, unpack
from hgs_core.codec.format.format_error import ChunkError
from hgs_core.codec.format.quantise import eased, unit_quats
from hgs_core.codec.format.values import check_entry, read_codes, read_values
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

MAX_EXPONENT = 20

# 2^(20 k), by which the largest exponent takes a value in the order k; 2^100 takes none below it beyond binary32.
SURELY_FINITE = 2.0**27
POWERS = np.ldexp(np.float32(1), np.arange(MAX_EXPONENT + 1) * np.arange(6)[:, None])  # [6, 21]: 2^(k e)
INVERSES = np.ldexp(np.float32(1), -np.arange(MAX_EXPONENT + 1))

# An opacity of 1 has no logit; alpha is clamped to 0.99, so this one cannot be told from it.
LARGEST_OPACITY = 1 - 1e-6

# The attributes of which every splat has a row, by kind of chunk, and those of which only some have one.
DENSE = {
    kind: [
        name
        for name, a in ATTRIBUTES.items()
        if not a.rows_of and (kind == Kind.DYNAMIC or not a.dynamic_only) and name != "form"
    ]
    for kind in Kind
}
SPARSE = {name: a for name, a in ATTRIBUTES.items() if a.rows_of}

Rows = Mapping[str, NDArray[np.intp] | int]


@dataclass(frozen=True)
class DecodedChunk:
    """The decoded content of a chunk, float32.

    Static: means [N, 3], quats [N, 4]. Dynamic: motion [N, K, 3], rotation [N, 2, 4], time_centers [N],
    time_log_precisions [N]; K is 6 if a splat moves in the fifth order, else 4. Both: log_scales [N, 3], opacities [N]
    in [0, 1], rgb [N, 3].
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
    """Return the logits [N] of opacities; those of 0 and 1 are about -14 and 14."""
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
            continue  # a later version's attribute
        if attribute.version > container.version:
            continue
        check_entry(stream, attribute)
        streams[attribute.name] = stream
    rows = _rows(container, streams)
    for name, attribute in ATTRIBUTES.items():
        if name in rows and name not in streams:
            raise ChunkError(TABLE, "attribute table", f"without {name}", f"attribute {attribute.id}")
        if name in streams and name != "form" and name not in rows:
            raise ChunkError(
                streams[name].at, f"attribute {attribute.id} ({name})", "there", "no row of it by the form"
            )
    values = {name: read_values(streams[name], ATTRIBUTES[name], _length(rows[name])) for name in rows}
    arrays = arrays_of(container.kind, values, rows, container.count)
    # Of grids that cannot give it, infinity is not looked for.
    if not all(stream.grid.step * stream.grid.largest() < SURELY_FINITE for stream in streams.values()):
        for name, array in arrays.items():
            if not np.isfinite(array).all():
                raise ChunkError(TABLE, f"{name} of splat {_first_bad(array)}", "not finite", "a finite number")
    return DecodedChunk(
        container.kind,
        container.count,
        container.index,
        container.time_range,
        container.box,
        container.bounds,
        arrays,
        container.version,
    )


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
    np.floor(exact, out=exact)
    return np.minimum(np.maximum(exact, 0.0), MAX_EXPONENT).astype(np.int32)


def _rows(container: Container, streams: Mapping[str, Stream]) -> dict[str, NDArray[np.intp] | int]:
    if container.kind == Kind.STATIC or "form" not in streams:
        return rows_of(container.kind, container.count, None)
    stream = streams["form"]
    codes = read_codes(stream, ATTRIBUTES["form"], container.count)[0]
    if codes.max() >= FIFTH:  # below it, every form is right
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
    rows: dict[str, NDArray[np.intp] | int] = dict.fromkeys(DENSE[kind], count)
    if codes is None:
        return rows
    members: dict[int, NDArray[np.intp]] = {}  # requirement -> splats; two attributes may have the same
    for name, attribute in SPARSE.items():
        wanted = attribute.rows_of
        if wanted not in members:
            members[wanted] = np.flatnonzero(attribute.among(codes))
        if len(members[wanted]):
            rows[name] = members[wanted]
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
    _place(motion, 0, None, values["position"])
    unit_quats(values["rotation"], out=rotation[:, 0])
    for array, names in ((motion, MOTION_ORDERS), (rotation, ("turning",))):
        for order, name in enumerate(names, start=1):
            if name in values:
                members = rows[name]
                powers = POWERS[order].take(exponents).take(members)
                _place(array, order, members, values[name] * powers[:, None])
    return {
        "motion": motion,
        "rotation": rotation,
        "time_centers": values["time_center"][:, 0] * INVERSES[exponents],
        "time_log_precisions": precisions,
    }


def _place(array: Floats, order: int, members: NDArray[np.intp] | int | None, values: Floats) -> None:
    """Write values [R, C] to array [N, K, C] as the coefficients of an order, of these splats or of all."""
    # A row as one item of 4 C bytes is copied whole: many times as fast as numpy's loops over three or four numbers.
    item = np.dtype((np.void, 4 * array.shape[2]))
    items, rows = array.view(item)[..., 0], values.view(item)[:, 0]
    if members is None:
        items[:, order] = rows
    else:
        np.put(items, members * array.shape[1] + order, rows)


def _first_bad(array: Floats) -> int:
    return int(np.argmin(np.isfinite(array).reshape(len(array), -1).all(axis=1)))
