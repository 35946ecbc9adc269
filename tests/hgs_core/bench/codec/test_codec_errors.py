"""Errors of known size: rounding to steps, which leaves a step over the root of 12, and turns by known angles."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.bench.codec.codec_errors import coded_errors, spz_errors
from hgs_core.codec import EncodeSettings, SetUtility, Utility
from hgs_core.interchange.spz.spz_file import spz_file
from hgs_core.scene import StaticSplats
from hgs_core.scene.rotations import product
from tests.synthetic import ring_of_cameras

COUNT = 2000


@pytest.fixture(scope="module")
def splats() -> StaticSplats[np.ndarray]:
    rng = np.random.default_rng(0)
    quats = rng.normal(size=(COUNT, 4))
    quats /= np.linalg.norm(quats, axis=1, keepdims=True)
    arrays = rng.normal(0, 1, (COUNT, 3)), rng.uniform(-4, -2, (COUNT, 3)), quats, rng.normal(1, 1, COUNT)
    return StaticSplats(*(a.astype(np.float32) for a in (*arrays, rng.uniform(0.2, 0.8, (COUNT, 3)))))


def test_errors_of_an_spz_file_are_those_of_rounding_to_its_steps(splats: StaticSplats[np.ndarray]) -> None:
    found = spz_errors(splats, spz_file(splats).data)
    steps = {"position": 1 / 4096, "log_scale": 1 / 16, "opacity": 1 / 255, "rgb": 0.28209479 / 0.15 / 255}
    for name, step in steps.items():
        assert getattr(found, name) == pytest.approx(step / 12**0.5, rel=0.05), name


def test_rotations_of_version_2_are_coarser(splats: StaticSplats[np.ndarray]) -> None:
    fine, coarse = (spz_errors(splats, spz_file(splats, version=version).data).rotation for version in (3, 2))
    assert fine < coarse / 2


def test_the_error_of_a_rotation_is_its_angle_about_each_axis(splats: StaticSplats[np.ndarray]) -> None:
    turn = np.array([np.cos(0.05), 0, np.sin(0.05), 0])  # 0.1 rad about y
    turned = dataclasses.replace(splats, quats=product(splats.quats, turn).astype(np.float32))
    assert spz_errors(splats, spz_file(turned).data).rotation == pytest.approx(0.1 / 3**0.5, rel=0.02)


def test_coded_places_are_rounded_to_the_steps_that_utility_and_coarseness_give(
    splats: StaticSplats[np.ndarray],
) -> None:
    """Balls of one size a known distance from one camera: their step is a share of their radius, half where they show
    four times as much, as every other one does; the two kinds lie in chunks of their own."""
    ahead = np.random.default_rng(1).uniform(-0.3, 0.3, (COUNT, 3)).astype(np.float32)
    balls = dataclasses.replace(splats, means=ahead, log_scales=np.full((COUNT, 3), np.log(0.05), np.float32))
    utility = Utility(SetUtility(np.where(np.arange(COUNT) % 2, 4.0, 1.0), np.full(COUNT, np.inf)), ())
    cameras = ring_of_cameras(1, 64, 48)
    found = [
        coded_errors(
            balls, cameras, utility, EncodeSettings(coarseness=c, small_chunk_splats=500), antialiased=False
        ).position
        for c in (0.5, 1.0)
    ]
    radius = np.sqrt(0.05**2 + 0.3 / (1.2 * 64 / 3) ** 2)  # the cameras are 3 away
    assert found[1] == pytest.approx(EncodeSettings().position_step * radius * (5 / 8) ** 0.5 / 12**0.5, rel=0.05)
    assert found[0] == pytest.approx(found[1] / 2, rel=0.05)
