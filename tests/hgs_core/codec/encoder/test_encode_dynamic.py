"""Motion: paths, orders and their cost."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np

from hgs_core.codec import decode_scene
from hgs_core.scene import DynamicSplats, Segment
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import joined
from tests.hgs_core.codec.scenes import check_dynamics, chunks_of, dynamics, encode, important, scene, swinging


def test_motion_of_the_fifth_order_makes_version_3_and_only_where_it_is_needed(
    tmp_path: Path, cameras: list[Camera]
) -> None:
    base = scene(dynamic=60)
    given = dataclasses.replace(
        base, segments=(dataclasses.replace(base.segments[0], dynamic=swinging(20)), base.segments[1])
    )
    manifest = encode(given, tmp_path, cameras, utility=important(given))
    assert json.loads((tmp_path / "manifest.json").read_text())["version"] == manifest.version == 3
    fifth = {chunk.time_range[0] for chunk in chunks_of(tmp_path) if chunk.version == 3}
    assert fifth == {0.0}
    after = decode_scene(tmp_path).segments
    assert [segment.dynamic.motion.shape[1] for segment in after] == [6, 4]
    assert after[0].dynamic.motion[:, 5].any(axis=1).all()
    check_dynamics(given.segments[0].dynamic, tmp_path, 0, 30 / 29, 1 / 29)


def test_a_path_far_from_its_centre_in_time_is_kept(tmp_path: Path, cameras: list[Camera]) -> None:
    count, base = 40, scene(dynamic=20)
    far = dataclasses.replace(
        dynamics(count, 4),
        opacity_logits=np.full(count, 6, np.float32),
        time_centers=np.linspace(-4, -2, count, dtype=np.float32),
        time_log_precisions=np.full(count, -3.2, np.float32),
        rotation=np.tile(np.eye(4, dtype=np.float32)[:1], (count, 1, 1)).repeat(2, 1) * (np.arange(2) == 0)[:, None],
    )
    from_first = np.polynomial.polynomial.polyfromroots([3.2, 3.7, 4.3])[:, None] * (
        20.0,
        -3.0,
        1.0,
    )  # shifted to t = 0
    far = dataclasses.replace(
        far, motion=(from_first + (np.arange(4) == 0)[:, None]).astype(np.float32)[None].repeat(count, 0)
    )
    given = dataclasses.replace(base, segments=(dataclasses.replace(base.segments[0], dynamic=far), base.segments[1]))
    encode(given, tmp_path, cameras, utility=important(given))
    check_dynamics(far, tmp_path, 0, 30 / 29, 1 / 29)


def test_coefficients_of_zero_cost_nothing(tmp_path: Path, cameras: list[Camera]) -> None:
    given = scene()
    fifth = DynamicSplats.empty(6)
    wider = tuple(Segment(s.start, s.end, joined([fifth, s.dynamic])) for s in given.segments)
    narrow = encode(given, tmp_path / "4", cameras)
    wide = encode(dataclasses.replace(given, segments=wider), tmp_path / "6", cameras)
    assert wide.version == narrow.version == 2
    assert sum(chunk.bytes for chunk in wide.chunks) <= 1.02 * sum(chunk.bytes for chunk in narrow.chunks)
