from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.kept_views import KeptViews
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from tests.synthetic import ring_of_cameras, synthetic_scene

KEPT = KeptViews("A title", tuple(ring_of_cameras(3, 64, 48)), frozenset({"1"}), np.array([0.0, 0.5]), (0.0, -1.0, 0.0))


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    KEPT.save(tmp_path / "views.json")
    loaded = KeptViews.load(tmp_path / "views.json")
    assert (loaded.title, loaded.held_out, loaded.up) == (KEPT.title, KEPT.held_out, KEPT.up)
    np.testing.assert_array_equal(loaded.times, KEPT.times)
    for camera, kept in zip(loaded.cameras, KEPT.cameras, strict=True):
        assert camera.to_json() == kept.to_json()


def still() -> HybridScene[np.ndarray]:
    static, _ = synthetic_scene()
    return HybridScene(static.map(lambda array: array.numpy()), (Segment(0.0, 0.0, DynamicSplats.empty()),))


def test_a_scene_is_encoded_for_the_cameras_that_are_not_held_out() -> None:
    views = KEPT.of(still())
    assert [camera.name for camera in views.cameras] == ["0", "1", "2"]
    assert sorted(views.trained) == [0, 2]
    assert (views.up, views.photographed, views.any_background) == ((0.0, -1.0, 0.0), True, True)


def test_without_cameras_they_are_made_up() -> None:
    views = dataclasses.replace(KEPT, cameras=(), up=None).of(still())
    assert (views.title, views.cameras[0].name, views.photographed) == ("A title", "front", False)


@pytest.mark.parametrize("text", ["", "{}", '{"title": "x", "cameras": [{}], "held_out": [], "times": [], "up": null}'])
def test_a_damaged_file_is_named(tmp_path: Path, text: str) -> None:
    (tmp_path / "views.json").write_text(text)
    with pytest.raises(InputError, match=r"views\.json: unreadable"):
        KeptViews.load(tmp_path / "views.json")
