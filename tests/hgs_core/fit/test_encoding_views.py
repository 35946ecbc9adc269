from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from hgs_core.fit.encoding_views import EncodeViews, views_around
from hgs_core.fit.orbit_cameras import orbit_cameras
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from tests.hgs_core.render.scenes import static_splats


def scene(end: float) -> HybridScene[np.ndarray]:
    static = static_splats(60, dtype=torch.float32).map(torch.Tensor.numpy)
    return HybridScene(static, (Segment(1.0, end, DynamicSplats.empty()),))


@pytest.fixture(scope="module")
def still() -> EncodeViews:
    return views_around(scene(1.0), "figure")


def test_a_still_scene_has_one_frame_and_no_pictures(still: EncodeViews) -> None:
    assert (still.title, still.times.tolist(), still.truth, still.capture) == ("figure", [1.0], None, None)
    assert still.any_background


def test_a_moving_scene_is_looked_at_30_times_a_second() -> None:
    times = views_around(scene(1.5), "x").times
    np.testing.assert_allclose(times, 1.0 + np.arange(15) / 30)


def test_every_made_up_camera_may_be_looked_at_and_the_manifest_names_the_whole_ones(still: EncodeViews) -> None:
    found = orbit_cameras(scene(1.0))
    names = [camera.name for camera in (*found.whole, *found.closer, *found.detail)]
    assert [camera.name for camera in still.trained.values()] == names
    assert list(still.trained) == list(range(len(names)))
    assert [camera.name for camera in still.cameras] == [camera.name for camera in found.whole]
    assert [camera.name for camera in still.every_camera] == names


def test_pictures_of_a_capture_have_their_background(still: EncodeViews) -> None:
    assert not replace(still, truth=lambda camera, frame: torch.zeros(3, 1, 1)).any_background
