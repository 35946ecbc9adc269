"""The scripts behind docs/experiments/, on cases with a known answer."""

from __future__ import annotations

import numpy as np
import torch

from hgs_core.render.lens_falloff import falloff_gain
from hgs_core.scene import StaticSplats
from hgs_core.scene.camera import Camera
from hgs_core.train.colour_correction import CameraColours
from scripts.experiments.gauss_newton import probed
from scripts.experiments.near_duplicates import has_duplicate
from scripts.experiments.one_mover import thawed
from scripts.experiments.outside_views import degrees_outside
from scripts.experiments.splat_budgets import taken
from scripts.experiments.unseen_pixels import times_seen
from scripts.experiments.useful_dynamics import held_by_the_best, sums_of_cells


def camera_at(x: float) -> Camera:
    """A camera of 8x6 pixels at (x, 0, 0) that looks along z."""
    pose = np.eye(4)
    pose[0, 3] = -x
    return Camera(f"at {x}", 8, 6, 8.0, 8.0, 4.0, 3.0, pose)


def test_a_wall_is_seen_where_pictures_overlap_and_nothing_stands_before_it() -> None:
    wall = np.full((6, 8), 2.0)
    hidden = wall.copy()
    hidden[:, 4:] = 1.0  # something stands before the right half of the second camera's picture
    beside = camera_at(0.5)  # the wall moves by 8 * 0.5 / 2 = 2 pixels to the left
    assert np.array_equal(times_seen(camera_at(0.0), wall, [(beside, wall)])[0], [0, 0, 1, 1, 1, 1, 1, 1])
    assert np.array_equal(times_seen(camera_at(0.0), wall, [(beside, hidden)])[0], [0, 0, 1, 1, 1, 1, 0, 0])
    assert times_seen(camera_at(0.0), wall, [(beside, wall), (camera_at(0.0), wall)])[0, 7] == 2


def test_a_view_is_as_far_outside_as_the_nearest_camera_is() -> None:
    def towards(degrees: float) -> np.ndarray:
        return np.array([np.cos(np.deg2rad(degrees)), 0.0, np.sin(np.deg2rad(degrees))])

    others = [towards(degrees) for degrees in (-30, 0, 25)]
    for degrees, expected in ((-48, 18), (-30, 0), (10, 10), (14, 11), (205, 125)):
        assert abs(degrees_outside(towards(degrees), others) - expected) < 1e-3


def test_duplicates_are_alike_in_place_shape_and_colour() -> None:
    place = torch.tensor([[0.0, 0, 0], [0.01, 0, 0], [0, 5, 0], [0, 5, 0], [0, 0, 9], [0, 0, 9], [3, 0, 0]])
    scales = torch.full((7, 3), -2.0)
    scales[3, 0] = 0.0  # of another shape
    colour = torch.full((7, 3), 0.5)
    colour[5, 2] = 0.7  # of another colour
    splats = StaticSplats(place, scales, torch.tensor([[1.0, 0, 0, 0]] * 7), torch.zeros(7), colour)
    assert has_duplicate(splats).tolist() == [True, True, False, False, False, False, False]


def test_the_distance_is_bhattacharyyas_for_turned_splats() -> None:
    """A needle along x and one turned by 90 degrees about z at the same place, beside one turned by 180 degrees."""
    scales = torch.tensor([[0.0, -3, -3]] * 3)
    turned = torch.tensor([[1.0, 0, 0, 0], [0.5**0.5, 0, 0, 0.5**0.5], [0, 0, 0, 1.0]])
    splats = StaticSplats(torch.zeros(3, 3), scales, turned, torch.zeros(3), torch.zeros(3, 3))
    assert has_duplicate(splats).tolist() == [True, False, True]


def test_squares_of_probes_have_the_diagonal_of_weighted_squares_as_their_mean() -> None:
    """The reference is the whole Jacobian of a linear picture, with its camera's colours, of float64."""
    random = torch.Generator().manual_seed(3)
    basis = torch.randn((3 * 4 * 5, 6), generator=random, dtype=torch.float64)  # pixels by parameters
    weights = torch.rand((3, 4, 5), generator=random, dtype=torch.float64)
    affine = torch.tensor([[1.0, 2, 0, 0.1], [0, 1, 0, 0], [-1, 0, 3, 0]], dtype=torch.float64)
    camera = Camera("a", 5, 4, 4.0, 4.0, 2.5, 2.0, np.eye(4))
    falloff = torch.tensor([-0.3, 0.1], dtype=torch.float64)
    colours = CameraColours(affine, falloff)
    gain = falloff_gain(falloff, camera).view(20, 1)
    parameters = torch.zeros(6, dtype=torch.float64, requires_grad=True)
    mapped = torch.einsum("ij,jpk->ipk", affine[:, :3], basis.view(3, 20, 6) * gain).reshape(60, 6)
    expected = (weights.reshape(60, 1) * mapped.square()).sum(0)
    mean = torch.zeros_like(expected)
    for _ in range(3000):
        parameters.grad = None
        probed((basis @ parameters).view(3, 4, 5), weights, colours, camera, random)
        mean += parameters.grad.square() / 3000
    assert torch.allclose(mean, expected, rtol=0.1)  # a square of a sum of signs spreads by sqrt(2): 2.6 % here


def test_a_budget_takes_the_useful_evenly_and_nothing_dead() -> None:
    chunks = [np.full(100, 3.0), np.full(8, 5.0), np.array([9.0, -np.inf])]
    assert np.flatnonzero(taken(chunks, 9)).tolist()[-9:] == [*range(100, 109)]
    half = np.flatnonzero(taken(chunks, 59)[:100])
    assert len(half) == 50
    assert np.diff(half).max() <= 3
    assert taken(chunks, 200).sum() == 109


def test_a_picture_is_the_first_one_but_where_the_object_was_or_is() -> None:
    first, now = np.full((9, 12, 3), 10, np.uint8), np.full((9, 12, 3), 20, np.uint8)
    was, is_now = np.zeros((9, 12), bool), np.zeros((9, 12), bool)
    was[1, 1], is_now[7, 10] = True, True
    picture = thawed(first, now, was, is_now)
    expected = np.full((9, 12), 10)
    expected[:4, :4], expected[5:, 8:] = 20, 20  # and two pixels around
    assert np.array_equal(picture[..., 1], expected)


def test_the_best_hold_their_share_and_cells_at_the_border_count() -> None:
    assert held_by_the_best(np.array([1.0, 6.0, 2.0, 1.0]), 0.5) == 0.25
    assert held_by_the_best(np.array([1.0, 6.0, 2.0, 1.0]), 0.75) == 0.5
    assert np.array_equal(sums_of_cells(np.ones((17, 32))), [[256, 256], [16, 16]])
