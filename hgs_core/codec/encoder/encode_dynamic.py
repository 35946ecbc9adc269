"""From prepared dynamic splats of one segment to the bytes of a chunk, checked over all their visible lives."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles
from hgs_core.codec.encoder.appearance import appearance_numbers
from hgs_core.codec.encoder.encode_chunk import Numbers, declare, outward, write_chunk
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.motion_coding import Path, highest_order, motion_numbers, turning_numbers
from hgs_core.codec.encoder.prepare import PreparedDynamics
from hgs_core.codec.encoder.rate_distortion import choose, neighbours
from hgs_core.codec.encoder.rotation_coding import shape_error
from hgs_core.codec.encoder.steps import (
    CENTER_STEP,
    LARGEST_CENTER_STEP,
    LARGEST_PRECISION_STEP,
    PRECISION_STEP,
    Steps,
)
from hgs_core.codec.encoder.utility import grades
from hgs_core.codec.format.attributes import FIFTH, TURNS, Kind
from hgs_core.codec.format.chunk import Bounds, pack
from hgs_core.codec.format.decode import DecodedChunk, decode_chunk, time_exponents
from hgs_core.codec.format.quantise import float32_below
from hgs_core.scene.temporal import evaluate, lifetime

__all__ = ["SegmentTime", "dynamic_numbers", "encode_dynamic_chunk", "reach"]

LARGEST_ROUNDING = 1.5 + 1e-3  # steps by which a number may be off its value
LEAST_OFF = 1e-5


@dataclass(frozen=True)
class SegmentTime:
    """The clock of a segment."""

    start: float  # seconds
    end: float  # seconds
    shown_until: float  # normalised time at which the next segment takes over

    def life(self, splats: PreparedDynamics, settings: EncodeSettings) -> tuple[Doubles, Doubles]:
        """Return the first and last normalised time ([N], [N]) at which a splat can be seen, as it will be coded.

        Every attribute is taken at the end of its error interval that makes the life longest, in a chunk with the step
        that a splat of its grade and of medium opacity has; then the life is cut to when the segment is shown.
        """
        width = settings.coarseness * np.exp2(-grades(splats.utility[:, 0]).astype(np.float64))
        step = np.minimum(settings.opacity_step * width, settings.largest_opacity_step)
        opacity = np.minimum(1.0, splats.opacity[:, 0] + LARGEST_ROUNDING * np.maximum(step, LEAST_OFF))
        precision = splats.time_log_precision[:, 0]
        precision = precision - LARGEST_ROUNDING * np.minimum(PRECISION_STEP * step, LARGEST_PRECISION_STEP)
        longest = np.exp2(-np.clip(np.floor((precision - 1.75) / math.log(4)), 0, 20))
        radius = np.sqrt(np.log(np.maximum(1.0, 255 * opacity)) / np.exp(precision))
        radius += np.minimum(CENTER_STEP * step, LARGEST_CENTER_STEP) * longest
        center = splats.time_center[:, 0]
        return np.clip(center - radius, 0.0, self.shown_until), np.clip(center + radius, 0.0, self.shown_until)


def encode_dynamic_chunk(
    splats: PreparedDynamics, time: SegmentTime, settings: EncodeSettings, index: int
) -> tuple[bytes, DecodedChunk]:
    """Encode dynamic splats of one segment.

    Raises:
        RuntimeError: a splat does not decode within the limits of the chunk's steps (a fault of this program).
    """
    steps = Steps.of(splats, settings)
    numbers, path = dynamic_numbers(splats, time, steps)
    container, order = write_chunk(Kind.DYNAMIC, numbers, (time.start, time.end), settings, index)
    chunk = decode_chunk(pack(container))
    splats = splats.take(order)
    path = Path(*(getattr(path, field.name)[order] for field in dataclasses.fields(path)))
    bounds = _measured(splats, path, chunk, steps)
    box = outward(*reach(chunk, time))
    data = pack(dataclasses.replace(container, box=box, bounds=declare(bounds, steps)))
    return data, decode_chunk(data)


def dynamic_numbers(splats: PreparedDynamics, time: SegmentTime, steps: Steps) -> tuple[Numbers, Path]:
    """Return the numbers of dynamic splats, in the order given, and the paths that they stand for.

    Rows of sparse attributes are those of the splats that have them by "form", which is absent if no splat has any.
    """
    numbers: dict[str, tuple[NDArray[np.int64], float]] = {}
    centers, precisions = _time_numbers(splats, steps, numbers)
    exponents = time_exponents(precisions.astype(np.float32))
    start, end = _visible(splats, time)
    path = Path.of(splats, start, end)
    offsets = (path.times - centers[:, None]) * np.exp2(exponents.astype(np.float64))[:, None]
    moving, orders = motion_numbers(path, offsets, steps, highest_order(splats))
    shift = centers[:, None] - splats.time_center
    turning, turns = turning_numbers(splats, path, offsets, shift, exponents, steps)
    look = appearance_numbers(splats, steps)
    numbers |= moving | turning
    numbers |= {
        name: (look[name], step)
        for name, step in (("log_scale", steps.shape), ("opacity", steps.opacity), ("rgb", steps.rgb))
    }
    if orders.any() or turns.any():
        numbers["form"] = (np.minimum(orders, 3) + TURNS * turns + FIFTH * (orders > 3))[:, None], 1.0
    return numbers, path


def _visible(splats: PreparedDynamics, time: SegmentTime) -> tuple[Doubles, Doubles]:
    """Return when the splats [N] are seen, cut to when the segment is shown."""
    radius = np.sqrt(np.log(np.maximum(1.0, 255 * splats.opacity[:, 0])) / np.exp(splats.time_log_precision[:, 0]))
    center = splats.time_center[:, 0]
    return np.clip(center - radius, 0.0, time.shown_until), np.clip(center + radius, 0.0, time.shown_until)


def _time_numbers(
    splats: PreparedDynamics, steps: Steps, numbers: dict[str, tuple[NDArray[np.int64], float]]
) -> tuple[Doubles, Doubles]:
    """Add time_center and time_log_precision to `numbers`; return both [N] as they will decode."""
    step = float32_below(min(PRECISION_STEP * steps.opacity, LARGEST_PRECISION_STEP))
    exact = splats.time_log_precision / step
    candidates = neighbours(exact)
    cost = ((candidates - exact[:, None])[..., 0] * (steps.opacity / steps.own_opacity)[:, None]) ** 2
    chosen = choose(candidates, cost)
    numbers["time_log_precision"] = chosen, step
    precisions = (chosen[:, 0] * step).astype(np.float32)
    power = np.exp2(time_exponents(precisions).astype(np.float64))
    step = float32_below(min(CENTER_STEP * steps.opacity, LARGEST_CENTER_STEP))
    centers = np.rint(splats.time_center * power[:, None] / step).astype(np.int64)
    numbers["time_center"] = centers, step
    decoded = np.ldexp((centers[:, 0] * step).astype(np.float32), -time_exponents(precisions))
    return decoded.astype(np.float64), precisions.astype(np.float64)


def _measured(splats: PreparedDynamics, path: Path, chunk: DecodedChunk, steps: Steps) -> Bounds:
    """Return the largest errors of the splats, in the chunk's order, at the moments of their paths."""
    decoded = chunk.dynamic()
    sigma = splats.opacity[:, 0]
    position = shape = opacity = 0.0
    scales = chunk.arrays["log_scales"].astype(np.float64)
    for j in range(path.times.shape[1]):
        places, quats, seen = evaluate(decoded, path.times[:, j])
        shift = np.abs(places - path.positions[:, j]).max(axis=1) * path.fade[:, j]
        position = max(position, float(shift.max()))
        opacity = max(opacity, float(np.abs(seen - sigma * path.fade[:, j]).max()))
        error = shape_error(path.quats[:, j], splats.log_scale, quats, scales, steps.blur)
        shape = max(shape, float((error * path.fade[:, j]).max()))
    rgb = float(np.abs(chunk.arrays["rgb"] - splats.rgb).max())
    return Bounds(position, steps.blur, shape, opacity, rgb)


def reach(chunk: DecodedChunk, time: SegmentTime) -> tuple[Doubles, Doubles]:
    """Return the corners of a box that holds every decoded centre whenever it can be seen."""
    decoded = chunk.dynamic()
    start, end = (np.clip(t, 0.0, time.shown_until) for t in lifetime(decoded))
    center = chunk.arrays["time_centers"].astype(np.float64)
    reach = np.maximum(np.abs(start - center), np.abs(end - center))[:, None]
    motion = np.abs(chunk.arrays["motion"].astype(np.float64))
    swing = sum(motion[:, k] * reach**k for k in range(1, motion.shape[1]))
    slack = 1e-6 * (np.abs(motion[:, 0]) + swing)
    middle = chunk.arrays["motion"][:, 0].astype(np.float64)
    return (middle - swing - slack).min(axis=0), (middle + swing + slack).max(axis=0)
