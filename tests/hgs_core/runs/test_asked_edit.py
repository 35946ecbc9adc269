"""Edits that jobs make."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.codec import decode_scene, encode_scene, load_manifest
from hgs_core.runs import stages
from hgs_core.runs.asked_edit import ask_edit, make_edit, source_of_edit
from hgs_core.runs.encode_inputs import trained_scene
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.splats import HybridScene, Segment
from tests.synthetic import ring_of_cameras, synthetic_scene


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """The run of a job that edits the scene "studio"."""
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    scene = HybridScene(static, (Segment(0.0, 1.0, dynamic),), antialiased=True)
    run = tmp_path / "job"
    cameras = ring_of_cameras(3, 64, 48)
    encode_scene(
        scene, source_of_edit(run, "studio"), cameras=cameras, times=np.arange(30) / 30, title="New", trained=cameras
    )
    return run


def listed(run: Path, ranges: list[list[int]]) -> bytes:
    chunk = load_manifest(source_of_edit(run, "studio")).slices[0].chunks[0]
    return json.dumps({"format": "hgs-splats", "version": 1, "chunks": {chunk.id: ranges}}).encode()


def test_the_stages_of_a_job_make_the_edited_scene(run: Path) -> None:
    before = decode_scene(source_of_edit(run, "studio"))
    ask_edit(run, "studio", listed(run, [[0, 0]]))
    for name in ("initialise", "train", "encode"):
        stages.STAGES[name](run, silent)
    after = trained_scene(RunFolder(run))
    np.testing.assert_array_equal(after.segments[0].dynamic.motion, before.segments[0].dynamic.motion[1:])
    np.testing.assert_array_equal(after.static.means, before.static.means)
    assert after.antialiased
    assert RunFolder(run).read_spec().config.encode.budget == "high"
    assert load_manifest(run / "scene").title == "New"
    assert sorted(path.name for path in source_of_edit(run, "studio").iterdir()) == ["manifest.json"]


def test_a_crop_keeps_what_is_inside_of_its_box(run: Path) -> None:
    before = decode_scene(source_of_edit(run, "studio"))
    middle = float(np.median(before.static.means[:, 0]))
    crop = {"format": "hgs-crop", "version": 1, "box": [middle - 50, 0, 0, 100, 100, 100]}
    ask_edit(run, "studio", json.dumps(crop).encode())
    stages.initialise(run, silent)
    after = trained_scene(RunFolder(run))
    np.testing.assert_array_equal(after.static.means, before.static.means[before.static.means[:, 0] <= middle])


def test_an_edit_that_was_made_is_kept(run: Path) -> None:
    ask_edit(run, "studio", listed(run, [[0, 0]]))
    make_edit(run, silent)
    make_edit(run, silent)  # its source is gone
    assert not (run / ".edited").exists()


def test_an_edit_that_was_interrupted_begins_again(run: Path) -> None:
    ask_edit(run, "studio", listed(run, [[0, 0]]))
    make_edit_once = run / ".edited"
    make_edit_once.mkdir()
    (make_edit_once / "rest").touch()
    (run / "scene").mkdir()
    make_edit(run, silent)
    assert load_manifest(run / "scene").totals.splats_dynamic > 0


def test_a_list_that_is_none_is_refused_by_the_stage(run: Path) -> None:
    ask_edit(run, "studio", b"[]")
    with pytest.raises(InputError, match=r"edit\.json: format: is null"):
        stages.initialise(run, silent)


def test_a_run_that_came_from_another_machine_finds_its_source(run: Path) -> None:
    ask_edit(run, "studio", listed(run, [[0, 0]]))
    moved = run.parent / "elsewhere" / "job"
    moved.parent.mkdir()
    run.rename(moved)
    make_edit(moved, silent)
    assert (moved / "scene" / "manifest.json").is_file()
