from __future__ import annotations

import torch

from hgs_core.render.rasterize import rasterize
from hgs_core.render.scene_picture import pixels_of, scene_picture
from hgs_core.scene.splats import HybridScene, Segment
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats


def test_a_scene_is_drawn_at_a_second_as_it_asks_for() -> None:
    static, dynamic = static_splats(20), dynamic_splats(20)
    scene = HybridScene(static, (Segment(2.0, 4.0, dynamic),), (0.1, 0.2, 0.3), antialiased=True)
    rig = [camera().scaled(0.5)]
    found = scene_picture(scene, camera(), 2.5, rig=rig, depth=True)
    expected = rasterize(
        static,
        dynamic,
        camera(),
        0.25,
        background=(0.1, 0.2, 0.3),
        antialiased=True,
        gradients="none",
        depth=True,
        rig=rig,
    )
    assert torch.equal(found.rgb, expected.rgb)
    assert found.depth is not None
    assert expected.depth is not None
    assert torch.equal(found.depth, expected.depth)


def test_planes_are_rounded_to_bytes() -> None:
    planes = torch.tensor([0.0, 0.5, 1.0]).reshape(3, 1, 1).expand(3, 2, 4)
    assert (pixels_of(planes) == (0, 128, 255)).all()
    assert pixels_of(planes).shape == (2, 4, 3)
