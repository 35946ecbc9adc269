"""First views of small scenes with known movers."""

from __future__ import annotations

import dataclasses

import numpy as np

from hgs_core.fit.find_start_views import find_start_views
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats


def mover(places: np.ndarray) -> DynamicSplats[np.ndarray]:
    """Opaque red balls of 0.1 world units at rest, but dynamic."""
    count = len(places)
    empty = DynamicSplats.empty()
    motion = np.zeros((count, 4, 3), np.float32)
    motion[:, 0] = places
    rotation = np.zeros((count, 2, 4), np.float32)
    rotation[:, 0, 0] = 1
    return dataclasses.replace(
        empty,
        motion=motion,
        rotation=rotation,
        log_scales=np.full((count, 3), np.log(0.1), np.float32),
        opacity_logits=np.full(count, 5.0, np.float32),
        time_centers=np.full(count, 0.5, np.float32),
        time_log_precisions=np.full(count, -10.0, np.float32),
        rgb=np.tile(np.float32([1, 0, 0]), (count, 1)),
    )


def scene(*places: tuple[float, float, float]) -> HybridScene[np.ndarray]:
    dynamic = mover(np.array(places, np.float32)) if places else DynamicSplats.empty()
    return HybridScene(StaticSplats.empty(), (Segment(0.0, 1.0, dynamic),))


def camera(name: str, x: float, z: float) -> Camera:
    """A camera of 320 x 200 pixels that looks at the origin."""
    return Camera(name, 320, 200, 200.0, 200.0, 160.0, 100.0, looking_at((x, 0, z), (0, 0, 0)))


FRONT, SIDE = camera("front", 0.0, -4.0), camera("side", -4.0, 0.1)


def test_the_box_holds_what_moves() -> None:
    found = find_start_views(scene((-1, 0, 0), (1, 0.5, 0)), [FRONT])
    assert found is not None
    left, top, right, bottom = found.wide.box
    pixels, _ = FRONT.project(np.array([[-1, 0, 0], [1, 0.5, 0]]))
    assert (pixels >= (left, top)).all()
    assert (pixels <= (right, bottom)).all()
    assert right - left < 200 / 4 * 2.6  # two units, and little around them


def test_wide_screens_see_a_row_from_the_front_and_upright_ones_from_its_end() -> None:
    row = [(x, 0.0, 0.0) for x in (-1.5, 0.0, 1.5)]
    found = find_start_views(scene(*row), [FRONT, SIDE])
    assert found is not None
    assert (found.wide.camera, found.tall.camera) == ("front", "side")


def test_a_camera_that_has_a_mover_behind_it_is_not_taken() -> None:
    found = find_start_views(scene((0, 0, 0), (0, 0, -5)), [FRONT, camera("far", 0.5, -9.0)])
    assert found is not None
    assert found.wide.camera == found.tall.camera == "far"


def test_a_scene_at_rest_has_none() -> None:
    assert find_start_views(scene(), [FRONT]) is None


def test_movers_that_no_camera_shows_are_none() -> None:
    assert find_start_views(scene((0, 0, -50)), [FRONT]) is None
