"""The scene after encoding and decoding, without the bytes: for the search of settings."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.base.cores import core_pool
from hgs_core.codec.encoder.chunking import dynamic_layers, slice_limits, static_layers
from hgs_core.codec.encoder.encode_chunk import Numbers, static_numbers
from hgs_core.codec.encoder.encode_dynamic import SegmentTime, dynamic_numbers
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.prepare import PreparedDynamics, PreparedStatics, prepare_dynamic, prepare_static
from hgs_core.codec.encoder.segment_times import frame_interval, shown_segments
from hgs_core.codec.encoder.steps import Steps
from hgs_core.codec.encoder.utility import Utility
from hgs_core.codec.format.attributes import Kind
from hgs_core.codec.format.decode import arrays_of, dynamic_splats, logits, rows_of, static_splats
from hgs_core.scene.camera import Camera
from hgs_core.scene.rotations import product
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats, joined

__all__ = ["Quantised", "decoded_arrays", "quantised_scene"]

HALF_TURNS = np.eye(4)  # about no axis, x, y and z: what they do to an ellipsoid does not show


@dataclass(frozen=True)
class Quantised:
    """The splats that an encoding keeps, before and after quantisation, in one order."""

    exact: HybridScene[Floats]  # their axes named as those of `decoded` are
    decoded: HybridScene[Floats]
    static_rows: NDArray[np.intp]  # [N] which of the scene's splats each of them was
    dynamic_rows: tuple[NDArray[np.intp], ...]  # [M] for each segment


def quantised_scene(
    scene: HybridScene[Floats],
    cameras: Sequence[Camera],
    times: NDArray[np.float64],
    utility: Utility,
    settings: EncodeSettings,
) -> Quantised:
    """Return the splats that `encode_scene` with these arguments would write, to the bit, in another order.

    Raises:
        InputError: as `encode_scene`.
    """
    splats = prepare_static(scene.static, cameras, utility.static, settings, antialiased=scene.antialiased)
    parts = [splats.take(layer.index) for layer in static_layers(splats, settings)]

    def of_static(part: PreparedStatics) -> StaticSplats[Floats]:
        return static_splats(decoded_arrays(Kind.STATIC, static_numbers(part, Steps.of(part, settings))))

    with core_pool() as pool:
        decoded = list(pool.map(of_static, parts))
    static = joined([StaticSplats.empty(), *decoded])
    exact = joined([StaticSplats.empty(), *(_static(part) for part in parts)])
    settings = settings.of_dynamic
    before, after, rows = [], [], []
    for shown in shown_segments(scene, frame_interval(times)):
        time, segment = shown.time, shown.segment
        known = utility.dynamic[shown.number]
        moving = prepare_dynamic(
            segment.dynamic, time.shown_until, shown.frame, cameras, known, settings, antialiased=scene.antialiased
        )
        limits = slice_limits(time, shown.until, settings)[1]
        pieces = [moving.take(layer.index) for layer in dynamic_layers(moving, time, limits, settings)]
        with core_pool() as pool:
            sets = list(pool.map(partial(_decoded_dynamic, time=time, settings=settings), pieces))
        originals = [_dynamic(piece, coded) for piece, coded in zip(pieces, sets, strict=True)]
        none = DynamicSplats.empty(segment.dynamic.motion.shape[1])  # all that is trained together has its coefficients
        before.append(Segment(segment.start, segment.end, joined([none, *originals])))
        after.append(Segment(segment.start, segment.end, joined([none, *sets])))
        rows.append(_rows(pieces))
    return Quantised(
        dataclasses.replace(scene, static=exact, segments=tuple(before)),
        dataclasses.replace(scene, static=static, segments=tuple(after)),
        _rows(parts),
        tuple(rows),
    )


def _decoded_dynamic(piece: PreparedDynamics, time: SegmentTime, settings: EncodeSettings) -> DynamicSplats[Floats]:
    numbers = dynamic_numbers(piece, time, Steps.of(piece, settings))[0]
    return dynamic_splats(decoded_arrays(Kind.DYNAMIC, numbers))


def _rows(parts: Sequence[PreparedStatics]) -> NDArray[np.intp]:
    return np.concatenate([np.zeros(0, np.intp), *(part.row[:, 0].astype(np.intp) for part in parts)])


def _static(part: PreparedStatics) -> StaticSplats[Floats]:
    arrays = part.position, part.log_scale, part.rotation, logits(part.opacity[:, 0]), part.rgb
    return StaticSplats(*(array.astype(np.float32) for array in arrays))


def _dynamic(part: PreparedDynamics, coded: DynamicSplats[Floats]) -> DynamicSplats[Floats]:
    """Return the splats with their axes turned round as those of `coded` are."""
    turns = product(part.rotation[:, None], HALF_TURNS)  # [N, 4, 4]
    likeness = (turns * coded.rotation[:, :1]).sum(axis=2)
    best = np.abs(likeness).argmax(axis=1)
    sign = np.sign(np.take_along_axis(likeness, best[:, None], axis=1))
    rotation = np.stack([part.rotation, part.turning], axis=1)
    arrays = (
        part.motion,
        product(rotation, HALF_TURNS[best][:, None]) * sign[..., None],
        part.log_scale,
        logits(part.opacity[:, 0]),
        part.time_center[:, 0],
        part.time_log_precision[:, 0],
        part.rgb,
    )
    return DynamicSplats(*(array.astype(np.float32) for array in arrays))


def decoded_arrays(kind: Kind, numbers: Numbers) -> dict[str, Floats]:
    """Return the decoded values of numbers (code - zero): the product with the step is rounded once."""
    count = len(numbers["position"][0])
    values = {name: (number * step).astype(np.float32) for name, (number, step) in numbers.items()}
    form = numbers["form"][0][:, 0].astype(np.uint32) if "form" in numbers else None
    return arrays_of(kind, values, rows_of(kind, count, form), count)
