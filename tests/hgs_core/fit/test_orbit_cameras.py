"""Where a scene without cameras is looked at from."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.codec.encoder.viewpoint import find_viewpoint
from hgs_core.fit.orbit_cameras import orbit_cameras
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.splats import joined


def cloud(means: np.ndarray) -> StaticSplats[np.ndarray]:
    count = len(means)
    arrays = means, np.full((count, 3), -4.0), np.tile([1.0, 0, 0, 0], (count, 1)), np.full(count, 2.0)
    return StaticSplats(*(array.astype(np.float32) for array in (*arrays, np.full((count, 3), 0.5))))


def pillar(count: int = 400) -> np.ndarray:
    """A body of one, tall and thin, with most splats in the middle and a few at both ends."""
    rng = np.random.default_rng(0)
    height = np.concatenate([rng.normal(0, 0.3, count - 20), np.repeat([-1.6, 1.6], 10)])
    return np.stack([rng.normal(5, 0.1, count), height, rng.normal(0, 0.1, count)], axis=1)


ROOM = np.array([3.0, 1.5, 4.0])  # half its sides


def box(count: int = 300) -> np.ndarray:
    return np.random.default_rng(1).uniform(-1, 1, (count, 3))


def walls(count: int) -> np.ndarray:
    """Places on the six sides of a cube from -1 to 1."""
    rng = np.random.default_rng(0)
    places = rng.uniform(-1, 1, (count, 3))
    places[np.arange(count), rng.integers(0, 3, count)] = rng.choice([-1.0, 1.0], count)
    return places


def still(means: np.ndarray) -> HybridScene[np.ndarray]:
    return HybridScene(cloud(means), (Segment(0.0, 0.0, DynamicSplats.empty()),))


def test_every_side_shows_the_whole() -> None:
    cameras = orbit_cameras(still(pillar())).whole
    for camera in cameras:
        pixels, depth = camera.project(pillar())
        assert (depth > camera.near).all()
        assert ((pixels > 0) & (pixels < (camera.width, camera.height))).all()
    pixels, _ = cameras[0].project(pillar())
    assert np.ptp(pixels[:, 1]) > 0.75 * cameras[0].height


def test_a_floater_far_away_does_not_make_the_rest_small() -> None:
    alone = orbit_cameras(still(pillar())).whole[0]
    beside = orbit_cameras(still(np.concatenate([pillar(), [[900.0, 0, 0]]]))).whole[0]
    np.testing.assert_allclose(beside.world_to_camera, alone.world_to_camera, atol=1e-6)


def test_the_closer_cameras_look_at_splats_wherever_they_are() -> None:
    given = orbit_cameras(still(pillar()))
    distance = float(np.linalg.norm(given.whole[0].position - [5, 0, 0]))
    targets = np.array([c.position + 0.5 * distance * c.world_to_camera[2, :3] for c in given.closer])
    away = np.linalg.norm(targets[:, None] - pillar()[None], axis=2).min(axis=1)
    assert away.max() < 0.2
    assert np.ptp(targets[:, 1]) > 1


def test_detail_is_looked_at_from_where_its_splats_have_two_pixels() -> None:
    """A pillar of fine splats beside one of coarse ones, in the same frame: the fine one is looked at from near."""
    fine, coarse = cloud(pillar()), cloud(pillar() + np.array([4.0, 0, 0]))
    fine.log_scales[:], coarse.log_scales[:] = np.log(0.002), np.log(0.012)
    scene = HybridScene(joined([fine, coarse]), (Segment(0.0, 0.0, DynamicSplats.empty()),))
    distances = {False: [], True: []}
    for camera in orbit_cameras(scene).detail:
        pixels, depth = camera.project(scene.static.means)
        ahead = np.linalg.norm(pixels - (camera.cx, camera.cy), axis=1)
        looked = int(np.where(depth > 0, ahead, np.inf).argmin())
        distances[bool(looked >= len(fine))].append(float(depth[looked]))
        size = np.exp(scene.static.log_scales[looked, 0]) * camera.fx / depth[looked]
        assert 1.5 < size < 2.6
    assert min(distances[True]) > 4 * max(distances[False]) > 0


def test_a_closed_room_is_looked_at_from_its_inside() -> None:
    """Six walls with paper on them, and a table: from outside each wall hides the rest."""
    room = cloud(np.concatenate([walls(3000), 0.95 * walls(3000), box() * [0.3, 0.03, 0.3] + [0, 0.5, 0]]) * ROOM)
    room.log_scales[:], room.opacity_logits[:] = np.log(0.15), 6.0
    scene = HybridScene(room, (Segment(0.0, 0.0, DynamicSplats.empty()),))
    found = orbit_cameras(scene)
    for camera in (*found.whole, *found.detail):
        assert (np.abs(camera.position) < ROOM).all()
    assert len(found.closer) == 20  # the outside


def test_a_hollow_thing_is_begun_with_from_outside_and_looked_at_from_inside_as_well() -> None:
    shell = cloud(walls(3000) * ROOM)
    shell.log_scales[:], shell.opacity_logits[:] = np.log(0.15), 6.0
    found = orbit_cameras(HybridScene(shell, (Segment(0.0, 0.0, DynamicSplats.empty()),)))
    assert all((np.abs(camera.position) > ROOM).any() for camera in found.whole)
    inside = [bool((np.abs(camera.position) < ROOM).all()) for camera in found.detail]
    assert inside.count(True) == inside.count(False) == 10


@pytest.mark.parametrize("side", [(-1, 0), (1, 0), (0, -1), (0, 1)])
def test_the_front_is_the_side_from_which_most_splats_are_seen(side: tuple[int, int]) -> None:
    """A wall of large splats that hide those behind, and on one side of it many more."""
    across = np.array([-side[1], side[0]])
    wall = np.linspace(-1, 1, 41)
    grid = np.array([[across[0] * a, y, across[1] * a] for a in wall for y in wall])
    detail = np.random.default_rng(0).uniform(-0.8, 0.8, (500, 2))
    before = np.array([[across[0] * a + 0.1 * side[0], y, across[1] * a + 0.1 * side[1]] for a, y in detail])
    splats = cloud(np.concatenate([grid, before]))
    splats.log_scales[: len(grid)] = -3.0
    splats.opacity_logits[: len(grid)] = 12.0
    scene = HybridScene(splats, (Segment(0.0, 0.0, DynamicSplats.empty()),))
    front = orbit_cameras(scene).whole[0]
    assert front.name == "front"
    toward = front.position / np.linalg.norm(front.position)
    assert toward[[0, 2]] @ side > 0.9
    assert front.world_to_camera[1, 1] > 0.9  # y points down in the picture


def test_viewers_turn_about_the_middle_and_keep_minus_y_up() -> None:
    cameras = orbit_cameras(still(pillar())).whole
    view = find_viewpoint(cameras, pillar())
    np.testing.assert_allclose(view.up, (0, -1, 0), atol=1e-6)
    np.testing.assert_allclose(view.center, (5, 0, 0), atol=0.3)


def test_what_moves_stays_in_the_pictures() -> None:
    """One that flies from x = 0 to 8."""
    motion = np.zeros((1, 4, 3), np.float32)
    motion[0, 0, 0], motion[0, 1, 0] = 4, 8
    turn = np.array([[[1, 0, 0, 0], [0, 0, 0, 0]]], np.float32)
    one = np.ones(1, np.float32)
    dynamic = DynamicSplats(
        motion, turn, np.full((1, 3), -4, np.float32), 3 * one, 0.5 * one, -20 * one, np.ones((1, 3))
    )
    scene = HybridScene(StaticSplats.empty(), (Segment(0.0, 1.0, dynamic),))
    for camera in orbit_cameras(scene).whole:
        pixels, depth = camera.project(np.array([[0.0, 0, 0], [8, 0, 0]]))
        assert ((pixels > 0) & (pixels < (camera.width, camera.height))).all()
        assert (depth > camera.near).all()
