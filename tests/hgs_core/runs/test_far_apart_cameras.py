"""A run of three cameras around a walking body, from its pictures to the scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.base.config_fields import with_fields
from hgs_core.base.progress import silent
from hgs_core.points.backdrop import load_backdrop
from hgs_core.points.hull_surface import soft_masks, views_of_movers
from hgs_core.points.kept_points import BACKDROP
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.stages import create_run, initialise, train
from hgs_core.scene.files import load_scene
from hgs_core.scene.temporal import evaluate
from hgs_core.train.control.backdrop_round import shown_once
from tests.walking_body import CAMERAS, body, mask_of, write_walk

FRAMES = 6
CONFIG = RunConfig.for_preset(
    "preview",
    capture={"trust_poses": True},
    points={"static": 800, "dynamic": 600},
    train={"iterations": 300, "density": {"max_static": 1500, "max_dynamic": 800}},
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    place = tmp_path_factory.mktemp("far_apart")
    write_walk(place / "capture", FRAMES)
    create_run(place / "run", place / "capture", CONFIG)
    initialise(place / "run", silent)
    train(place / "run", silent)
    return RunFolder(place / "run")


def test_statics_that_one_picture_shows_lie_on_the_backdrop(folder: RunFolder) -> None:
    backdrop = load_backdrop(folder.points / BACKDROP)
    assert backdrop is not None
    static = load_scene(folder.trained).static.map(torch.from_numpy)
    xyz = static.take(shown_once(static, CAMERAS)).means.numpy()
    places, _ = backdrop.nearest(xyz.astype(np.float64))
    assert 0 < len(xyz) < len(static)
    assert np.abs(xyz - places).max() < 0.02 * backdrop.radius


def test_movers_lie_in_the_body(folder: RunFolder) -> None:
    (segment,) = load_scene(folder.trained).segments
    xyz, _, opacity = evaluate(segment.dynamic, 0.4)
    masks = soft_masks([mask_of(camera, body(2 / (3 * FRAMES))) for camera in CAMERAS])
    inside = views_of_movers(CAMERAS, masks, xyz) > 0
    assert opacity[inside].sum() > 0.9 * opacity.sum()


def test_statics_that_one_picture_shows_stay_on_a_given_mesh(tmp_path: Path) -> None:
    """The mesh is a wall behind the other cameras, before the backdrop."""
    write_walk(tmp_path / "capture", FRAMES)
    pixels = np.array([[-99.0, -99.0], [400.0, -99.0], [400.0, 400.0], [-99.0, 400.0]])
    corners = CAMERAS[0].position + 5.2 * CAMERAS[0].rays(pixels)
    lines = [*(f"v {x} {y} {z}\n" for x, y, z in corners), "f 1 2 3 4\n"]
    (tmp_path / "capture" / "mesh.obj").write_text("".join(lines))
    short = with_fields(CONFIG, {"train": {"iterations": 20}}, "config")
    create_run(tmp_path / "run", tmp_path / "capture", short)
    initialise(tmp_path / "run", silent)
    train(tmp_path / "run", silent)
    static = load_scene(RunFolder(tmp_path / "run").trained).static.map(torch.from_numpy)
    xyz = static.take(shown_once(static, CAMERAS)).means.numpy()
    pixels, depths = CAMERAS[0].project(xyz)
    seen = CAMERAS[0].shows(pixels, depths)
    assert seen.sum() > 50
    assert np.quantile(np.abs(depths[seen] - 5.2), 0.9) < 0.01
