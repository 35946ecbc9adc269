"""The pull of given depth: its weights, its gradient, and pixels that it leaves alone."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.points.given_surfaces import GivenSurfaces
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.depth_pull import DepthPull, DepthTarget, depth_loss
from hgs_core.train.step import take_step
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingView

CPU = torch.device("cpu")
WIDTH, HEIGHT = 32, 16
WALL = 4.0


def view(name: str, x: float) -> Camera:
    pose = np.eye(4)
    pose[0, 3] = -x
    return Camera(name, WIDTH, HEIGHT, 32.0, 32.0, WIDTH / 2, HEIGHT / 2, pose)


class Wall(GivenSurfaces):
    """A wall at the same depth everywhere, known to the first camera but for two columns."""

    def __init__(self) -> None:
        pass

    def still(self, camera: int, size: Camera) -> np.ndarray | None:
        if camera != 3:
            return None
        depths = np.full((size.height, size.width), WALL, np.float32)
        depths[:, :2] = 0
        return depths


PULL = DepthPull(Wall(), {3: view("a", 0.0), 5: view("b", 2.0), 6: view("c", 3.0)})


def target(moving: np.ndarray | None = None, scale: float = 1.0) -> DepthTarget:
    found = PULL.target(0, view("a", 0.0).scaled(scale), moving, CPU)
    assert found is not None
    return found


def test_the_weight_is_one_over_the_cameras_that_look_at_a_place() -> None:
    """Two units to the side are sixteen pixels on the wall, three are twenty-four."""
    weight = target().weight
    assert weight.shape == (HEIGHT, WIDTH)
    assert weight[0].tolist() == [0.0] * 2 + [1.0] * 14 + [0.5] * 8 + [float(np.float32(1 / 3))] * 8
    assert target().inverse[0, 5] == 1 / WALL
    assert PULL.target(1, view("b", 2.0), None, CPU) is None


def test_noise_of_single_pixels_goes_and_edges_stay() -> None:
    depths = np.full((HEIGHT, WIDTH), WALL, np.float32)
    depths[:, 20:] = WALL / 2
    noise = np.random.default_rng(0).normal(1, 0.1, depths.shape).astype(np.float32)

    class Noisy(Wall):
        def still(self, camera: int, size: Camera) -> np.ndarray | None:
            return depths * noise

    found = DepthPull(Noisy(), {3: view("a", 0.0)}).target(0, view("a", 0.0), None, CPU)
    assert found is not None
    error = np.abs(depths * found.inverse.numpy() - 1)[:, 2:-2]
    assert np.median(error) < 0.03
    assert error.max() < 0.2


def test_movers_are_left_alone_at_any_size_of_the_view() -> None:
    moving = np.zeros((HEIGHT, WIDTH), bool)
    moving[:, 8:12] = True
    weight = target(moving, 0.5).weight
    assert weight.shape == (HEIGHT // 2, WIDTH // 2)
    assert not weight[:, 4:6].any()
    assert weight[:, 6:8].all()


def test_the_loss_is_the_share_by_which_what_is_drawn_lies_elsewhere() -> None:
    weight = torch.tensor([[1.0, 0.5, 0.0]])
    given = DepthTarget(torch.full((1, 3), 1 / WALL), weight)
    loss = depth_loss(torch.tensor([[4.4, 1.8, 9.0]]), torch.tensor([[1.0, 0.5, 1.0]]), given)
    assert float(loss) == pytest.approx((0.1 + 0.5 * 0.05) / 3)


def test_a_step_moves_splats_towards_the_given_depth() -> None:
    """Grey splats before a target of their own colour: the picture alone says nothing of where they lie."""
    side = np.array([[x, y, 3.0] for x in (0.2, 0.8) for y in (-0.4, 0.4)], np.float32)
    static = StaticSplats(
        *(torch.from_numpy(np.array(array, np.float32)) for array in (side, np.full((4, 3), -1.5), np.eye(4)[[0] * 4])),
        torch.full((4,), 3.0),
        torch.full((4, 3), 0.5),
    )
    none = (
        torch.zeros((0, 4, 3)),
        torch.zeros((0, 2, 4)),
        torch.zeros((0, 3)),
        *torch.zeros((3, 0)),
        torch.zeros((0, 3)),
    )
    dynamic = DynamicSplats(*none)
    camera = view("a", 0.0)
    picture = torch.zeros(3, HEIGHT, WIDTH)

    def slopes(weight: float) -> torch.Tensor:
        seen = TrainingView(0, camera, 0.0, picture, depth=target())
        take_step(static, dynamic, seen, TrainConfig(depth_weight=weight, colour_correction=False), gradients="static")
        assert static.means.grad is not None
        slopes, static.means.grad = static.means.grad[:, 2].clone(), None
        return slopes

    assert (slopes(1.0) < slopes(0.0)).all()  # a step against the slope takes them away from the camera
