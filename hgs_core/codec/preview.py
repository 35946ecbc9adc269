"""What a scene would be after encoding and decoding, without the bytes: to look for settings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hgs_core.camera import Camera
from hgs_core.codec.attributes import Kind
from hgs_core.codec.decode import arrays_of, dynamic_splats, rows_of, static_splats
from hgs_core.codec.encode_chunk import Numbers, static_numbers
from hgs_core.codec.encode_dynamic import dynamic_numbers
from hgs_core.codec.layers import dynamic_layers, slice_limits, static_layers
from hgs_core.codec.prepare import prepare_dynamic, prepare_static
from hgs_core.codec.settings import EncodeSettings
from hgs_core.codec.shown import frame_interval, shown_segments
from hgs_core.codec.steps import Steps
from hgs_core.codec.weights import Utility
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats, joined

__all__ = ["decoded_arrays", "quantised_scene"]

Floats = NDArray[np.float32]


def quantised_scene(
    scene: HybridScene[Floats],
    cameras: Sequence[Camera],
    times: NDArray[np.float64],
    utility: Utility,
    settings: EncodeSettings,
    *,
    antialiased: bool,
) -> HybridScene[Floats]:
    """Return the splats that `encode_scene` with these arguments would write, to the bit, in another order.

    Raises:
        InputError: as `encode_scene`.
    """
    splats = prepare_static(scene.static, cameras, utility.static, settings, antialiased=antialiased)
    parts = [splats.take(layer.index) for layer in static_layers(splats, settings)]
    static = [
        static_splats(decoded_arrays(Kind.STATIC, static_numbers(part, Steps.of(part, settings)))) for part in parts
    ]
    segments = []
    for shown in shown_segments(scene, frame_interval(times)):
        time, segment = shown.time, shown.segment
        known = utility.dynamic[shown.number]
        moving = prepare_dynamic(
            segment.dynamic, time.shown_until, shown.frame, cameras, known, settings, antialiased=antialiased
        )
        limits = slice_limits(time, shown.until, settings)[1]
        parts = [moving.take(layer.index) for layer in dynamic_layers(moving, time, limits, settings)]
        sets = [
            dynamic_splats(decoded_arrays(Kind.DYNAMIC, dynamic_numbers(part, time, Steps.of(part, settings))[0]))
            for part in parts
        ]
        segments.append(Segment(segment.start, segment.end, joined([DynamicSplats.empty(), *sets])))
    return HybridScene(joined([StaticSplats.empty(), *static]), tuple(segments))


def decoded_arrays(kind: Kind, numbers: Numbers) -> dict[str, Floats]:
    """Return what a decoder gives for these numbers, each (code - zero): the product with the step is rounded once."""
    count = len(numbers["position"][0])
    values = {name: (number * step).astype(np.float32) for name, (number, step) in numbers.items()}
    form = numbers["form"][0][:, 0].astype(np.uint32) if "form" in numbers else None
    return arrays_of(kind, values, rows_of(kind, count, form), count)
