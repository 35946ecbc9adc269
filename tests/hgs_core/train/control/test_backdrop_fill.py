"""Holes of a backdrop and the splats that fill them, in the colours around."""

from __future__ import annotations

import numpy as np
import torch

from hgs_core.points.backdrop import Backdrop
from hgs_core.points.point_cloud import PointCloud
from hgs_core.scene.splats import Segment, StaticSplats
from hgs_core.train.control.backdrop_fill import BackdropFill, unseen_parts
from hgs_core.train.initial_splats import initial_splats
from hgs_core.train.train_config import TrainConfig
from tests.hgs_core.train.conftest import Apply, state_of
from tests.synthetic import synthetic_scene

BACKDROP = Backdrop((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), 3.0)
CLOCK = Segment(0.0, 1.0, None)
RED, BLUE = (0.9, 0.1, 0.1), (0.1, 0.1, 0.9)


def surface(hole: bool) -> StaticSplats[torch.Tensor]:
    """Splats all over the backdrop, red where x is negative and blue elsewhere; `hole`: but for a part of the blue."""
    i = np.arange(6000) + 0.5
    polar, around = np.arccos(1 - 2 * i / 6000), np.pi * (1 + 5**0.5) * i
    rays = np.stack([np.sin(polar) * np.cos(around), np.cos(polar), np.sin(polar) * np.sin(around)], 1)
    eye = np.array((0.0, 0.1, 0.0))
    xyz = eye + BACKDROP.depths(eye, rays)[:, None] * rays
    if hole:
        xyz = xyz[np.linalg.norm(xyz - (2.6, -0.5, 0.0), axis=1) > 0.7]
    rgb = np.where(xyz[:, :1] < 0, RED, BLUE).astype(np.float32)
    none = np.zeros(len(xyz), np.float32)
    normals = BACKDROP.nearest(xyz)[1].astype(np.float32)
    spacing = np.full(len(xyz), 0.15, np.float32)
    points = PointCloud(xyz.astype(np.float32), rgb, none, none, spacing, np.zeros((len(xyz), 3), np.float32), normals)
    return initial_splats(points, CLOCK, 2, opacity=0.99)[0]


def test_a_hole_is_filled_with_the_colour_around_it_and_nothing_else_is() -> None:
    found = unseen_parts(BACKDROP, surface(hole=True), antialiased=True)
    assert len(found) > 20
    assert (np.linalg.norm(found.xyz - (2.6, -0.5, 0.0), axis=1) < 1.0).all()
    np.testing.assert_allclose(found.rgb, np.broadcast_to(BLUE, found.rgb.shape), atol=0.1)
    np.testing.assert_allclose(found.xyz, BACKDROP.nearest(found.xyz.astype(np.float64))[0], atol=1e-5)
    assert len(unseen_parts(BACKDROP, surface(hole=False), antialiased=True)) == 0


def test_nothing_to_go_on_from_adds_nothing() -> None:
    none = surface(hole=False).take(slice(0, 0))
    assert len(unseen_parts(BACKDROP, none, antialiased=True)) == 0


def test_a_round_adds_them_once(applied: Apply) -> None:
    config = TrainConfig(iterations=100)
    control = BackdropFill(config, BACKDROP)
    assert [i for i in range(100) if control.due(i)] == [87]
    static = surface(hole=True)
    state = state_of(static.map(torch.clone), synthetic_scene()[1].map(torch.clone))
    applied(control, state)
    assert len(state.static) > len(static)
    assert torch.equal(state.static.means[: len(static)], static.means)
    assert (torch.sigmoid(state.static.opacity_logits[len(static) :]) > 0.9).all()
