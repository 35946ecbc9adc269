"""From prepared splats to the bytes of one chunk, and the proof that they decode within the declared bounds."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hgs_core.codec import morton
from hgs_core.codec.attributes import ATTRIBUTES, MOTION_ORDERS, Attribute, Kind, Quantiser
from hgs_core.codec.chunk import Box, Container, Stream, pack
from hgs_core.codec.decode import DecodedChunk, decode_chunk
from hgs_core.codec.prepare import Prepared
from hgs_core.codec.quantise import Affine, achievable, fit, fit_rotation, float32_above, largest_component
from hgs_core.codec.settings import EncodeSettings
from hgs_core.codec.streams import Transform, compress, to_planes, transform
from hgs_core.scene.temporal import evaluate

__all__ = ["SegmentTime", "encode_dynamic_chunk", "encode_static_chunk"]

LARGEST_CENTER_ERROR = 0.01  # normalised time; a wider one would blur which slices a splat lives in
EXPONENT_RANGE = (-20, 20)
MOMENTS = 5  # at which the displacement of every splat is checked

Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class SegmentTime:
    """The clock of a segment, and how exactly its splats' time attributes are kept."""

    start: float  # seconds
    end: float  # seconds
    shown_until: float  # normalised time at which the next segment takes over
    center_error: float  # of time_center
    precision_error: float  # of time_log_precision
    opacity_error: float

    @staticmethod
    def of(start: float, end: float, shown_until: float, splats: Prepared, settings: EncodeSettings) -> SegmentTime:
        """Derive the bounds from `settings.fade_error`, half for the centre and half for the precision.

        The slope of sigma exp(-s d^2) is at most sigma sqrt(2 s / e) in d and sigma / e in ln s.
        """
        sigma = splats.values["opacity"]
        slope = sigma * np.sqrt(2 / math.e * np.exp(splats.values["time_log_precision"]))
        center = settings.fade_error / 2 / max(float(slope.max(initial=0.0)), 1e-9)
        center = min(center, LARGEST_CENTER_ERROR)
        precision = settings.fade_error / 2 * math.e
        if len(splats):
            center = achievable(splats.values["time_center"], center)
            precision = achievable(splats.values["time_log_precision"], precision)
        return SegmentTime(start, end, shown_until, center, precision, settings.opacity_error)

    def life(self, splats: Prepared) -> tuple[Doubles, Doubles]:
        """Return the first and last normalised time ([N], [N]) at which a splat can be seen, before or after coding.

        Every attribute is taken at the end of its error interval that makes the life longest; then the life is cut to
        when the segment is shown.
        """
        opacity = np.minimum(1.0, splats.values["opacity"][:, 0] + 2 * self.opacity_error)
        precision = np.exp(splats.values["time_log_precision"][:, 0] - 2 * self.precision_error)
        radius = np.sqrt(np.log(np.maximum(1.0, 255 * opacity)) / precision) + 2 * self.center_error
        center = splats.values["time_center"][:, 0]
        return np.clip(center - radius, 0.0, self.shown_until), np.clip(center + radius, 0.0, self.shown_until)


def encode_static_chunk(splats: Prepared, bound: float, settings: EncodeSettings, index: int) -> bytes:
    """Encode static splats with positions within `bound` per axis.

    Raises:
        RuntimeError: the chunk does not decode within its declared bounds (a fault of this program).
    """
    bounds = {**_common_bounds(settings), "position": bound}
    data, _ = _encode(Kind.STATIC, splats.values, bounds, (0.0, 0.0), None, settings, index)
    return data


def encode_dynamic_chunk(
    splats: Prepared, time: SegmentTime, bound: float, settings: EncodeSettings, index: int
) -> tuple[bytes, DecodedChunk]:
    """Encode dynamic splats of one segment with positions within `bound` per axis all their life.

    Raises:
        RuntimeError: the chunk does not decode within its declared bounds (a fault of this program).
    """
    start, end = time.life(splats)
    center = splats.values["time_center"]
    coded_center = fit(center, time.center_error)
    new_center = coded_center.decode(coded_center.encode(center)).astype(np.float64)
    shifted = _recentred(splats.values, new_center - center)
    reach = np.maximum(np.abs(start - new_center[:, 0]), np.abs(end - new_center[:, 0]))
    with np.errstate(divide="ignore"):
        exponent = np.clip(np.floor(-np.log2(reach)), *EXPONENT_RANGE)[:, None]
    scaled = dict(shifted)
    for k, name in enumerate(MOTION_ORDERS, start=1):
        scaled[name] = shifted[name] * np.exp2(-k * exponent)
    scaled["turning"] = shifted["turning"] * np.exp2(-exponent)
    scaled["time_exponent"] = exponent

    bounds = {
        **_common_bounds(settings),
        "time_center": time.center_error,
        "time_log_precision": time.precision_error,
        "turning": settings.rotation_error,
        "time_exponent": 0.0,
    }
    bounds |= _motion_bounds(scaled, bound)
    unsent = 0.0
    for name in (*MOTION_ORDERS, "turning"):
        size = float(np.abs(scaled[name]).max())
        if name not in bounds or size <= bounds[name]:
            del scaled[name]
            unsent += size if name in MOTION_ORDERS else 0.0

    span = np.abs(shifted["position"])
    swing = sum(np.abs(shifted[n]) * reach[:, None] ** k for k, n in enumerate(MOTION_ORDERS, start=1)) + bound
    slack = 1e-6 * span + 4 * float(achievable(shifted["position"], bound))
    corners = ((shifted["position"] - swing - slack).min(axis=0), (shifted["position"] + swing + slack).max(axis=0))
    data, order = _encode(Kind.DYNAMIC, scaled, bounds, (time.start, time.end), corners, settings, index, unsent)
    decoded = decode_chunk(data)
    _verify_motion(splats.take(order), start[order], end[order], decoded)
    return data, decoded


def _common_bounds(settings: EncodeSettings) -> dict[str, float]:
    return {
        "log_scale": settings.log_scale_error,
        "rotation": settings.rotation_error,
        "opacity": settings.opacity_error,
        "rgb": settings.rgb_error,
    }


def _recentred(values: Mapping[str, Doubles], shift: Doubles) -> dict[str, Doubles]:
    """Expand the polynomials about a centre that lies `shift` [N, 1] later; they stay the same functions of time."""
    m0, m1, m2, m3 = (values[name] for name in ("position", *MOTION_ORDERS))
    rotation = values["rotation"] + shift * values["turning"]
    norm = np.linalg.norm(rotation, axis=1, keepdims=True)
    safe = norm > 1e-6
    return {
        **values,
        "position": m0 + shift * (m1 + shift * (m2 + shift * m3)),
        "velocity": m1 + shift * (2 * m2 + shift * 3 * m3),
        "acceleration": m2 + shift * 3 * m3,
        "jerk": m3,
        "rotation": np.where(safe, rotation / np.where(safe, norm, 1.0), values["rotation"]),
        "turning": np.where(safe, values["turning"] / np.where(safe, norm, 1.0), values["turning"]),
    }


def _motion_bounds(scaled: Mapping[str, Doubles], bound: float) -> dict[str, float]:
    """Share the position bound among the orders of motion that matter; the others are left out at their full size.

    A coefficient is stored times 2^(-k e) and |2^e d| <= 1 while the splat lives, so that the bounds add up to
    the displacement's.
    """
    sizes = {name: float(np.abs(scaled[name]).max()) for name in MOTION_ORDERS}
    present = [name for name in MOTION_ORDERS if sizes[name] > bound / 64]
    left = bound - sum(size for name, size in sizes.items() if name not in present)
    return {name: left / (1 + len(present)) for name in ("position", *present)}


def _encode(
    kind: Kind,
    values: Mapping[str, Doubles],
    bounds: Mapping[str, float],
    time_range: tuple[float, float],
    corners: tuple[Doubles, Doubles] | None,
    settings: EncodeSettings,
    index: int,
    unsent: float = 0.0,
) -> tuple[bytes, NDArray[np.intp]]:
    """Sort, quantise, compress and check; return the bytes and the order in which the splats are stored.

    `unsent` is how far the orders of motion that are left out move a splat; the position's declared bound includes it.
    """
    grid = fit(values["position"], bounds["position"])
    grid = dataclasses.replace(grid, bound=float32_above(grid.bound + unsent))
    limbs = morton.interleave(grid.encode(values["position"]))
    order = morton.order(limbs)
    streams: list[Stream] = []
    for name, attribute in ATTRIBUTES.items():
        if name not in values:
            continue
        if attribute.quantiser == Quantiser.MORTON:
            streams.append(_morton_stream(attribute, grid, limbs[order], settings))
        else:
            streams.append(_stream(attribute, values[name][order], bounds[name], settings))
    if corners is None:
        means = grid.decode(grid.encode(values["position"])).astype(np.float64)
        corners = (means.min(axis=0), means.max(axis=0))
    data = pack(Container(kind, len(order), index, time_range, _outward(corners), tuple(streams)))
    _verify({name: array[order] for name, array in values.items()}, decode_chunk(data))
    return data, order


def _morton_stream(attribute: Attribute, grid: Affine, limbs: NDArray[np.uint64], settings: EncodeSettings) -> Stream:
    steps = morton.differences(limbs)
    planes = [steps[:, p // 3] >> np.uint64(8 * (p % 3)) for p in range((3 * grid.bits + 7) // 8)]
    raw = np.stack(planes).astype(np.uint8).tobytes()
    data = compress(raw, settings.compression_level)
    return Stream(attribute.id, attribute.quantiser, Transform.NONE, attribute.components, grid, len(raw), data)


def _stream(attribute: Attribute, values: Doubles, bound: float, settings: EncodeSettings) -> Stream:
    """Quantise one attribute and keep the transform that compresses best."""
    index = b""
    if attribute.quantiser == Quantiser.SMALLEST_THREE:
        largest, values = largest_component(values)
        index = largest.astype(np.uint8).tobytes()
        grid = fit_rotation(bound)
    elif bound == 0:  # whole numbers
        low = float(values.min())
        grid = Affine(1.0, (low,), max(1, int(values.max() - low).bit_length()), 0.0)
    else:
        zero = attribute.name in (*MOTION_ORDERS, "turning", "rgb", "opacity")
        grid = fit(values, bound, zero=zero)
    codes = grid.encode(values)
    candidates: list[Stream] = []
    for kind in attribute.transforms:
        raw = to_planes(transform(codes, grid.bits, kind), grid.bits) + index
        data = compress(raw, settings.compression_level)
        candidates.append(Stream(attribute.id, attribute.quantiser, kind, attribute.components, grid, len(raw), data))
    return min(candidates, key=lambda stream: len(stream.data))


def _outward(corners: tuple[Doubles, Doubles]) -> Box:
    """Round a box to float32 numbers that still contain it."""
    low, high = corners[0].astype(np.float32), corners[1].astype(np.float32)
    low = np.where(low > corners[0], np.nextafter(low, np.float32(-np.inf)), low)
    high = np.where(high < corners[1], np.nextafter(high, np.float32(np.inf)), high)
    x, y, z = (float(v) for v in low)
    X, Y, Z = (float(v) for v in high)
    return (x, y, z), (X, Y, Z)


def _verify(targets: Mapping[str, Doubles], decoded: DecodedChunk) -> None:
    for name, bound in decoded.bounds.items():
        value = decoded.attributes[name].astype(np.float64)
        if name == "rotation":
            same, opposite = (np.linalg.norm(value - sign * targets[name], axis=1) for sign in (1, -1))
            error = np.minimum(same, opposite)
        else:
            error = np.abs(value - targets[name]).max(axis=1)
        if not (error <= bound).all():
            splat = int(np.argmax(error))
            raise RuntimeError(f"{name} of splat {splat} is off by {error[splat]:.4g}, declared bound {bound:.4g}")


def _verify_motion(splats: Prepared, start: Doubles, end: Doubles, decoded: DecodedChunk) -> None:
    """Compare the positions of original and decoded splats over their lives."""
    bound = sum(decoded.bounds.get(name, 0.0) for name in ("position", *MOTION_ORDERS))
    m0, m1, m2, m3 = (splats.values[name] for name in ("position", *MOTION_ORDERS))
    for share in np.linspace(0.0, 1.0, MOMENTS):
        moment = start + share * (end - start)
        d = moment[:, None] - splats.values["time_center"]
        expected = m0 + d * (m1 + d * (m2 + d * m3))
        size = np.abs(m0) + np.abs(d * m1) + np.abs(d * d * m2) + np.abs(d**3 * m3)
        error = (np.abs(evaluate(decoded.dynamic(), moment)[0] - expected) - 1e-12 * size).max(axis=1)
        if not (error <= bound).all():
            splat = int(np.argmax(error))
            raise RuntimeError(f"splat {splat} is displaced by {error[splat]:.4g}, declared bound {bound:.4g}")
