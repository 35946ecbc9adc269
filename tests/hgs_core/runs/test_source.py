"""Sources of an export, against the scene that was put there."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress
from hgs_core.codec import encode_scene, load_manifest
from hgs_core.interchange import import_scene
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from hgs_core.runs.source import open_source
from hgs_core.scene.files import save_scene
from hgs_core.scene.splats import HybridScene, Segment
from tests.synthetic import ring_of_cameras, synthetic_scene


@pytest.fixture
def scene() -> HybridScene[np.ndarray]:
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    return HybridScene(static, (Segment(0.0, 1.0, dynamic),), antialiased=True)


@pytest.fixture
def run(tmp_path: Path, scene: HybridScene[np.ndarray]) -> Path:
    """A finished run."""
    folder = RunFolder(tmp_path / "run")
    config = RunConfig().changed({"train.antialiased": True})
    folder.write_spec(RunSpec(tmp_path / "figure.ply", "", config, without_capture=True))
    save_scene(folder.trained, scene)
    cameras = ring_of_cameras(3, 64, 48)
    encode_scene(scene, folder.scene, cameras=cameras, times=np.arange(30) / 30, title="Figure")
    return folder.path


def test_of_a_run_the_float32_scene_is_taken(run: Path, scene: HybridScene[np.ndarray]) -> None:
    source = open_source(run)
    np.testing.assert_array_equal(source.scene.static.rgb, scene.static.rgb)
    np.testing.assert_array_equal(source.scene.segments[0].dynamic.motion, scene.segments[0].dynamic.motion)
    assert source.scene.antialiased is True
    assert [camera.name for camera in source.cameras] == ["0", "1", "2"]


def test_an_encoded_scene_is_decoded_and_needs_no_run(run: Path, scene: HybridScene[np.ndarray]) -> None:
    folder = (run / "scene").rename(run.parent / "alone")
    source = open_source(folder)
    assert len(source.scene.static) == load_manifest(folder).totals.splats_static
    distances = np.abs(source.scene.static.means[:, None] - scene.static.means[None]).max(axis=2).min(axis=1)
    assert 0 < distances.max() < 0.01  # near those that were encoded, and not they
    assert [camera.name for camera in source.cameras] == ["0", "1", "2"]


@pytest.mark.parametrize("missing", ["scene.npz", "scene/manifest.json"])
def test_a_run_that_is_not_finished_is_refused(run: Path, missing: str) -> None:
    (run / missing).unlink()
    with pytest.raises(InputError, match="run: is neither a finished run nor a scene folder"):
        open_source(run)


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is neither a finished run nor a scene folder"):
        open_source(tmp_path)


def test_a_source_exports_the_moment_that_is_asked_for(run: Path, tmp_path: Path) -> None:
    """All splats of the file are where they are then: the moving ones by their polynomial."""
    source = open_source(run)
    source.export(tmp_path / "x.ply", time=0.75, segment=None)
    exported = import_scene(tmp_path / "x.ply", 1.0).scene.static
    moving = source.scene.segments[0].dynamic
    places = np.einsum("nkc,k->nc", moving.motion, (0.75 - 0.5) ** np.arange(4.0))  # all have their centre at 0.5
    assert len(exported) == len(source.scene.static) + len(moving)
    for place in places:
        assert np.abs(exported.means - place).max(axis=1).min() < 1e-5


def test_a_folder_gets_frames_at_the_captures_rate_or_at_the_one_asked_for(run: Path, tmp_path: Path) -> None:
    source = open_source(run)
    told: list[Progress] = []
    source.export(tmp_path / "all", progress=told.append)
    source.export(tmp_path / "few", frame_rate=4.0, frames="sog")
    assert {path.suffix for path in (tmp_path / "few").iterdir()} == {".sog"}
    assert [len(list((tmp_path / name).iterdir())) for name in ("all", "few")] == [31, 5]
    assert told[-1].total == 31


@pytest.mark.parametrize(
    ("name", "options", "problem"),
    [
        ("frames", {"time": 0.5}, "--time: is not for a folder of frames; leave it out, or export frames.ply"),
        ("frames", {"segment": 0}, "--segment: is not for a folder of frames"),
        ("frames", {"version": 3}, "--spz-version: is not for a folder of frames"),
        ("x.ply", {"frames": "sog"}, "--frames: is for a folder of frames, not for .ply; leave it out"),
        ("frames", {"frames": "spz"}, "--frames: 'spz' is no format of frames; give one of ply, sog"),
        ("x.ply", {"frame_rate": 3.0}, "--fps: is for frames and samples, and x.ply has none; leave it out"),
    ],
)
def test_options_of_something_else_are_refused(
    run: Path, tmp_path: Path, name: str, options: dict[str, Any], problem: str
) -> None:
    with pytest.raises(InputError) as caught:
        open_source(run).export(tmp_path / name, **options)
    assert str(caught.value).startswith(problem)


def test_an_export_of_photographs_states_what_larger_screens_will_show(run: Path, tmp_path: Path) -> None:
    made_up, taken = open_source(run), dataclasses.replace(open_source(run), photographed=True)
    plain = made_up.export(tmp_path / "a.ply", time=0.5)
    *others, last = taken.export(tmp_path / "b.ply", time=0.5)
    assert tuple(others) == plain
    assert "on screens finer than the training pictures' 64x48" in str(last)


def test_baking_needs_the_cameras_of_the_pictures(run: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--bake: needs the cameras of the pictures"):
        open_source(run).export(tmp_path / "a.ply", time=0.5, bake=True)
    taken = dataclasses.replace(open_source(run), photographed=True)
    changes = taken.export(tmp_path / "b.ply", time=0.5, bake=True)
    assert not any("larger screens" in str(change) for change in changes)
