"""Decoded splats lie within the bounds stated by their chunk."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hgs_core.codec import decode_scene
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from hgs_core.scene.camera import Camera
from tests.hgs_core.codec.scenes import (
    check_dynamics,
    check_statics,
    dynamics,
    encode,
    important,
    nearest,
    scene,
    statics,
)

extreme = st.sampled_from([-np.inf, -1e30, -20.0, -5.54, 0.0, 3.0, 20.0, 1e30, np.inf])


@pytest.mark.parametrize("coefficients", [4, 6])
def test_every_splat_decodes_within_the_bounds_of_its_chunk(
    tmp_path: Path, cameras: list[Camera], coefficients: int
) -> None:
    given = scene(coefficients=coefficients)
    manifest = encode(given, tmp_path, cameras, utility=important(given))
    assert check_statics(given.static, tmp_path) == manifest.totals.splats_static
    after = decode_scene(tmp_path)
    assert [(s.start, s.end) for s in after.segments] == [(s.start, s.end) for s in given.segments]
    found = 0
    for number, (segment, until) in enumerate(zip(given.segments, (30 / 29, 1.0), strict=True)):
        found += check_dynamics(segment.dynamic, tmp_path, number, until, 1 / 29)
    assert found == manifest.totals.splats_dynamic > 250


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    count=st.sampled_from([0, 1, 2, 70]),
    seed=st.integers(0, 1000),
    logits=st.lists(extreme, min_size=70, max_size=70),
    precisions=st.lists(extreme, min_size=70, max_size=70),
    still=st.booleans(),
    coefficients=st.sampled_from([4, 6]),
    scale=st.sampled_from([-np.inf, -50.0, -4.0, 2.0]),
)
def test_extreme_scenes_decode_within_their_bounds(
    tmp_path: Path,
    cameras: list[Camera],
    count: int,
    seed: int,
    logits: list[float],
    precisions: list[float],
    still: bool,
    coefficients: int,
    scale: float,
) -> None:
    static, dynamic = statics(count, seed), dynamics(count, seed + 1, coefficients)
    opacities = np.array(logits[:count], np.float32)
    static.log_scales[: count // 2] = scale
    static.quats[: count // 3] = 0
    dynamic.rotation[: count // 3, 0] = 0
    if still:
        dynamic.motion[:, 1:] = 0
    given = HybridScene(
        dataclasses.replace(static, opacity_logits=opacities),
        (
            Segment(
                0.0,
                29 / 30,
                dataclasses.replace(
                    dynamic,
                    opacity_logits=opacities[::-1].copy(),
                    time_log_precisions=np.array(precisions[:count], np.float32),
                ),
            ),
        ),
    )
    encode(given, tmp_path, cameras, utility=important(given))
    check_statics(given.static, tmp_path)
    check_dynamics(given.segments[0].dynamic, tmp_path, 0, 1.0, 1 / 29)


@pytest.mark.parametrize("size", [1e-20, 1e3, 1e8, 1e20])
def test_coordinates_of_any_size_are_kept_in_proportion(tmp_path: Path, cameras: list[Camera], size: float) -> None:
    given = HybridScene(statics(100, 3, spread=size), (Segment(0.0, 0.0, DynamicSplats.empty()),))
    encode(given, tmp_path, cameras)
    after = decode_scene(tmp_path).static.means.astype(np.float64)
    before = given.static.means.astype(np.float64)
    error = np.abs(after - before[nearest(after / size, before / size)]).max(axis=1)
    assert (error <= 0.02 + 2e-3 * np.linalg.norm(after, axis=1)).all()
