"""Encoding reads the same views and states from a run folder that were put there."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.decompose.masks import motion_masks
from hgs_core.points.near_plane import save_near_planes, with_near_planes
from hgs_core.runs.creation import create_run
from hgs_core.runs.encode_inputs import trained_scene, training_states, views_of_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from hgs_core.scene.files import save_scene
from hgs_core.scene.splats import HybridScene, Segment
from hgs_core.train.checkpoint import fresh_state, save_state
from hgs_core.train.train_config import TrainConfig
from tests.synthetic import synthetic_scene, write_capture

HELD_OUT = RunConfig.from_json({"capture": {"hold_out": ["2"]}})


@pytest.fixture
def scene() -> HybridScene[np.ndarray]:
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    return HybridScene(static, (Segment(0.0, 1.0, dynamic), Segment(1.0, 2.0, dynamic)))


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    """A run that was created with a capture and has its points, all at the origin."""
    write_capture(tmp_path / "capture")
    create_run(tmp_path / "run", tmp_path / "capture", HELD_OUT)
    folder = RunFolder(tmp_path / "run")
    cameras = folder.open_capture(folder.read_spec()).cameras
    save_near_planes(folder.near_planes, with_near_planes(cameras, np.zeros((50, 3), np.float32)))
    return folder


@pytest.mark.parametrize("antialiased", [False, True])
def test_a_trained_scene_is_drawn_as_the_config_says(
    tmp_path: Path, scene: HybridScene[np.ndarray], antialiased: bool
) -> None:
    folder = RunFolder(tmp_path / "run")
    config = RunConfig().changed({"train.antialiased": antialiased})
    folder.write_spec(RunSpec(tmp_path, "", config))
    save_scene(folder.trained, dataclasses.replace(scene, antialiased=not antialiased))
    found = trained_scene(folder)
    assert found.antialiased is antialiased
    np.testing.assert_array_equal(found.static.means, scene.static.means)
    np.testing.assert_array_equal(found.segments[1].dynamic.motion, scene.segments[1].dynamic.motion)


def test_a_run_that_is_not_trained_is_refused(folder: RunFolder) -> None:
    with pytest.raises(InputError, match=r"scene\.npz"):
        trained_scene(folder)


def test_the_views_are_the_capture_s_but_for_those_held_out(folder: RunFolder, scene: HybridScene[np.ndarray]) -> None:
    views = views_of_run(folder, folder.read_spec(), scene)
    assert [camera.name for camera in views.cameras] == ["0", "1", "2", "3", "4"]
    assert sorted(views.trained) == [0, 1, 3, 4]
    assert len(views.times) == 6
    assert views.truth is not None
    with Image.open(folder.read_spec().capture / "ims" / "3" / "000004.jpg") as picture:
        expected = np.asarray(picture, np.float32).transpose(2, 0, 1) / 255
    np.testing.assert_allclose(views.truth(3, 4).numpy(), expected, atol=1e-6)
    assert not views.any_background


def test_the_masks_of_the_training_tell_what_moves(folder: RunFolder, scene: HybridScene[np.ndarray]) -> None:
    capture = folder.read_spec().open_capture()
    masks = motion_masks(capture, [0, 1, 3, 4], progress=silent)
    masks.save(folder.masks, [0])
    moving = views_of_run(folder, folder.read_spec(), scene).moving
    assert moving is not None
    assert moving(3, 4).any()
    np.testing.assert_array_equal(moving(3, 4).numpy(), masks.mask(3, 4))


def test_nothing_tells_what_moves_in_a_run_without_masks(folder: RunFolder, scene: HybridScene[np.ndarray]) -> None:
    assert views_of_run(folder, folder.read_spec(), scene).moving is None


def test_the_cameras_see_nothing_before_the_scene(folder: RunFolder, scene: HybridScene[np.ndarray]) -> None:
    """Every camera stands three units from the points; 0.6 of the depth is cut off."""
    views = views_of_run(folder, folder.read_spec(), scene)
    assert [camera.near for camera in views.cameras] == pytest.approx([0.6 * 3.0] * 5, rel=1e-4)
    assert [camera.near for camera in views.trained.values()] == pytest.approx([0.6 * 3.0] * 4, rel=1e-4)


def test_without_a_capture_the_views_are_made_up(tmp_path: Path, scene: HybridScene[np.ndarray]) -> None:
    spec = RunSpec(tmp_path / "figure.ply", "", RunConfig(), without_capture=True)
    views = views_of_run(RunFolder(tmp_path), spec, scene)
    assert (views.title, views.truth, views.capture, views.any_background) == ("figure", None, None, True)
    assert [(i, c.name) for i, c in views.trained.items()] == [
        (i, c.name) for i, c in enumerate((*views.cameras, *views.closer))
    ]
    np.testing.assert_allclose(views.times, np.arange(60) / 30)


class TestStates:
    """The states in which the trainings of two segments ended."""

    @pytest.fixture(autouse=True)
    def _states(self, folder: RunFolder) -> None:
        for number in range(2):
            state = fresh_state(*synthetic_scene(), 4, TrainConfig())
            state.iteration = 10 + number
            save_state(folder.checkpoint(number), state)

    def test_they_come_in_the_order_of_the_segments(self, folder: RunFolder, scene: HybridScene[np.ndarray]) -> None:
        states = training_states(folder, scene)
        assert [state.iteration for state in states] == [10, 11]
        assert torch.equal(states[0].static.means, synthetic_scene()[0].means)

    def test_none_are_there_if_a_segment_has_none(self, folder: RunFolder, scene: HybridScene[np.ndarray]) -> None:
        folder.checkpoint(1).unlink()
        assert training_states(folder, scene) == ()

    def test_none_are_there_if_one_cannot_be_read(self, folder: RunFolder, scene: HybridScene[np.ndarray]) -> None:
        folder.checkpoint(1).write_bytes(b"no checkpoint")
        assert training_states(folder, scene) == ()

    @pytest.mark.parametrize("other", ["static", "dynamic"])
    def test_none_are_there_if_they_are_of_another_scene(
        self, folder: RunFolder, scene: HybridScene[np.ndarray], other: str
    ) -> None:
        if other == "static":
            scene = dataclasses.replace(scene, static=scene.static.map(lambda array: array[:-1]))
        else:
            fewer = scene.segments[1].dynamic.map(lambda array: array[:-1])
            scene = dataclasses.replace(scene, segments=(scene.segments[0], Segment(1.0, 2.0, fewer)))
        assert training_states(folder, scene) == ()
