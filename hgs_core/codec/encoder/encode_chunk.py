"""From whole numbers to the bytes of a chunk, and the proof that they decode within the bounds they declare."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hgs_core.base import morton
from hgs_core.base.arrays import Doubles, Whole
from hgs_core.codec.encoder.appearance import appearance_numbers, rotation_numbers
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.prepare import PreparedStatics
from hgs_core.codec.encoder.rotation_coding import shape_error
from hgs_core.codec.encoder.steps import Steps
from hgs_core.codec.format.attributes import ATTRIBUTES, Attribute, Kind
from hgs_core.codec.format.chunk import Bounds, Box, Container, Stream, pack
from hgs_core.codec.format.decode import DecodedChunk, decode_chunk
from hgs_core.codec.format.quantise import Grid, fitting_grid, float32_above
from hgs_core.codec.format.streams import compress, to_planes, transform

__all__ = [
    "LIMITS",
    "Numbers",
    "declare",
    "encode_static_chunk",
    "outward",
    "static_numbers",
    "stream_of",
    "write_chunk",
]

# How many of a chunk's steps an error may reach; an encoder whose choices go beyond is at fault. Shapes have no such
# limit: how far a turn by a step goes depends on how long and thin a splat is.
LIMITS = {"position": 8.0, "opacity": 10.0, "rgb": 4.0}

Numbers = Mapping[str, tuple[Whole, float]]
"""Whole numbers [rows, C] by attribute name, and the step (float32) that they are multiples of."""


def encode_static_chunk(splats: PreparedStatics, settings: EncodeSettings, index: int) -> tuple[bytes, DecodedChunk]:
    """Encode static splats; `index` is the chunk's place in its scene.

    Raises:
        RuntimeError: a splat does not decode within the limits of the chunk's steps (a fault of this program).
    """
    steps = Steps.of(splats, settings)
    numbers = static_numbers(splats, steps)
    container, order = write_chunk(Kind.STATIC, numbers, (0.0, 0.0), settings, index)
    chunk = decode_chunk(pack(container))
    means = chunk.arrays["means"].astype(np.float64)
    splats = splats.take(order)
    bounds = Bounds(
        position=float(np.abs(means - splats.position).max()),
        blur=steps.blur,
        shape=float(
            shape_error(
                splats.rotation,
                splats.log_scale,
                _unit(chunk.arrays["quats"]),
                chunk.arrays["log_scales"].astype(np.float64),
                steps.blur,
            ).max()
        ),
        opacity=float(np.abs(chunk.arrays["opacities"][:, None] - splats.opacity).max()),
        rgb=float(np.abs(chunk.arrays["rgb"] - splats.rgb).max()),
    )
    box = outward(means.min(axis=0), means.max(axis=0))
    data = pack(dataclasses.replace(container, box=box, bounds=declare(bounds, steps)))
    return data, decode_chunk(data)


def static_numbers(splats: PreparedStatics, steps: Steps) -> Numbers:
    """Return the numbers of static splats, in the order given."""
    look = appearance_numbers(splats, steps)
    return {
        "position": (np.rint(splats.position / steps.position).astype(np.int64), steps.position),
        "log_scale": (look["log_scale"], steps.shape),
        "rotation": (rotation_numbers(splats, splats.rotation, steps), steps.rotation),
        "opacity": (look["opacity"], steps.opacity),
        "rgb": (look["rgb"], steps.rgb),
    }


def declare(measured: Bounds, steps: Steps) -> Bounds:
    """Return the measured errors rounded up to float32, if each is within its limit.

    Raises:
        RuntimeError: one is not.
    """
    for name, limit in LIMITS.items():
        error, step = getattr(measured, name), getattr(steps, name)
        if not error <= limit * step:
            raise RuntimeError(f"an error of {name} of {error:.4g} is more than {limit:.3g} steps of {step:.4g}")
    return Bounds(*(float32_above(error) for error in measured))


def write_chunk(
    kind: Kind, numbers: Numbers, time_range: tuple[float, float], settings: EncodeSettings, index: int
) -> tuple[Container, NDArray[np.intp]]:
    """Sort splats by their place and compress every attribute; return the chunk and the order of its splats.

    Rows of sparse attributes belong to the splats that "form" says, in the order given. Box and bounds are yet unset.
    """
    grid, codes = fitting_grid(*numbers["position"])
    limbs = morton.interleave(codes)
    order = morton.order(limbs)
    form = numbers["form"][0][:, 0] if "form" in numbers else np.zeros(len(order), np.int64)
    streams: list[Stream] = []
    for name, attribute in ATTRIBUTES.items():
        if name == "position":
            planes = morton.to_planes(morton.differences(limbs[order]), grid.bits)
            streams.append(stream_of(attribute, 0, grid, planes, settings))
        elif name in numbers:
            values, step = numbers[name]
            streams.append(_smallest(attribute, values[_row_order(attribute, form, order)], step, settings))
    nowhere = ((0.0,) * 3, (0.0,) * 3)
    unset = Bounds(0.0, 0.0, 0.0, 0.0, 0.0)
    version = max(ATTRIBUTES[name].version for name in numbers)
    return Container(kind, len(order), index, time_range, nowhere, unset, tuple(streams), version), order


def _row_order(attribute: Attribute, form: Whole, order: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return which of an attribute's rows belong to the splats in their new order."""
    if not attribute.rows_of:
        return order
    has = attribute.among(form)
    row = np.cumsum(has) - 1
    return np.asarray(row[order[has[order]]])


def _smallest(attribute: Attribute, numbers: Whole, step: float, settings: EncodeSettings) -> Stream:
    """Compress one attribute with the transform that makes it smallest."""
    if attribute.name == "form":
        grid, codes = Grid(step, (0,), max(1, int(numbers.max()).bit_length())), numbers.astype(np.uint32)
    else:
        grid, codes = fitting_grid(numbers, step, common=attribute.name in ("log_scale", "rgb"))
    candidates = [
        stream_of(attribute, kind, grid, to_planes(transform(codes, grid.bits, kind), grid.bits), settings)
        for kind in attribute.transforms
    ]
    return min(candidates, key=lambda stream: sum(map(len, stream.planes)))


def stream_of(attribute: Attribute, kind: int, grid: Grid, planes: list[bytes], settings: EncodeSettings) -> Stream:
    """Return the stream of planes, which are compressed; `kind` is the transform of their codes."""
    frames = tuple(memoryview(compress(plane, settings.compression_level)) for plane in planes)
    return Stream(attribute.id, attribute.components, kind, grid, frames)


def _unit(quats: NDArray[np.float32]) -> Doubles:
    exact = quats.astype(np.float64)
    return np.asarray(exact / np.linalg.norm(exact, axis=1, keepdims=True))


def outward(low: Doubles, high: Doubles) -> Box:
    """Round the corners [3] of a box to float32 numbers that still contain it."""
    below, above = low.astype(np.float32), high.astype(np.float32)
    below = np.where(below > low, np.nextafter(below, np.float32(-np.inf)), below)
    above = np.where(above < high, np.nextafter(above, np.float32(np.inf)), above)
    x, y, z = (float(v) for v in below)
    X, Y, Z = (float(v) for v in above)
    return (x, y, z), (X, Y, Z)
