"""Runs made of other runs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.codec import decode_scene, encode_scene, load_manifest
from hgs_core.codec.format.audio import AudioEntry, AudioPiece, CodedAudio
from hgs_core.codec.format.scene_folder import chunk_id, read_audio
from hgs_core.edit.crop import crop
from hgs_core.edit.orient import Similarity, orient, turn_about
from hgs_core.edit.regions import ball_of
from hgs_core.edit.splat_list import SplatList
from hgs_core.edit.trim import trim
from hgs_core.edit.viewed_scene import Edit, ViewedScene
from hgs_core.runs.edited import edit_run, open_editable
from hgs_core.runs.encode_inputs import trained_scene
from hgs_core.runs.encoding import encode_again
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from hgs_core.scene.files import load_scene, save_scene
from hgs_core.scene.splats import HybridScene, Segment
from tests.synthetic import ring_of_cameras, synthetic_scene

CAMERAS = ring_of_cameras(3, 64, 48)
PIECES = [b"the first half", b"the second half"]
ENTRIES = tuple(AudioPiece(chunk_id(data), len(data), i / 2, (i + 1) / 2) for i, data in enumerate(PIECES))
SOUND = CodedAudio(AudioEntry("opus", 48_000, 1, ENTRIES), {chunk_id(data): data for data in PIECES})
SHIFT = Similarity(turn_about([0, 1, 0, 30]), 2.0, np.array([1.0, 2.0, 3.0]))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run of three cameras, of which 1 is held out; 30 frames of one second."""
    folder = RunFolder(tmp_path_factory.mktemp("runs") / "run")
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    scene = HybridScene(static, (Segment(0.0, 1.0, dynamic),), antialiased=True)
    config = RunConfig().changed({"train.antialiased": True, "capture.hold_out": ["1"]})
    folder.write_spec(RunSpec(folder.path / "capture", "", config))
    save_scene(folder.trained, scene)
    folder.train_summary.write_text("{}")
    trained = [CAMERAS[0], CAMERAS[2]]
    encode_scene(
        scene, folder.scene, cameras=CAMERAS, times=np.arange(30) / 30, title="Figure", trained=trained, audio=SOUND
    )
    return folder.path


@pytest.fixture(scope="module")
def edited(run: Path) -> Path:
    out = run.parent / "edited"
    edit_run(run, out, [lambda v: trim(v, 0.25, 0.75), lambda v: orient(v, SHIFT)], silent, "default")
    return out


def test_sound_is_trimmed_with_the_scene_and_stays_when_it_is_encoded_again(edited: Path) -> None:
    scene = edited / "scene"
    sound = read_audio(scene, load_manifest(scene))
    assert sound is not None
    assert [(piece.start, piece.end) for piece in sound.entry.pieces] == [(-0.25, 0.25), (0.25, 0.75)]
    assert list(sound.chunks.values()) == PIECES
    encode_again(edited, None, silent)
    assert read_audio(scene, load_manifest(scene)) == sound


def test_an_edited_run_has_what_its_manifest_needs_of_the_first(edited: Path) -> None:
    manifest = load_manifest(edited / "scene")
    assert (manifest.title, manifest.start, manifest.end) == ("Figure", 0.0, 0.5)
    assert manifest.frame_rate == pytest.approx(30)
    assert manifest.antialiased is True
    assert manifest.captured_space is not None
    assert [camera.name for camera in manifest.cameras] == ["0", "1", "2"]
    for camera, given in zip(manifest.cameras, CAMERAS, strict=True):
        np.testing.assert_allclose(camera.position, 2 * SHIFT.rotation @ given.position + SHIFT.shift, atol=1e-9)
    assert manifest.training["edited"]["of"] == "run"
    assert manifest.thumbnail


def test_the_first_run_stays_as_it_was(run: Path, edited: Path) -> None:
    assert load_manifest(run / "scene").end == 1.0
    assert trained_scene(RunFolder(run)).end == 1.0
    assert sorted(path.name for path in run.iterdir()) == ["run.json", "scene", "scene.npz", "train.json"]


def test_an_edited_run_can_be_edited_again(edited: Path) -> None:
    out = edited.parent / "again"
    edit_run(edited, out, [lambda v: trim(v, 0.1, 0.4)], silent, "low")
    assert load_manifest(out / "scene").end == pytest.approx(0.3)
    opened = open_editable(out)
    assert (opened.held_out, opened.title) == ({"1"}, "Figure")
    np.testing.assert_allclose(opened.viewed.cameras[2].position, load_manifest(edited / "scene").cameras[2].position)


def test_an_encoded_scene_can_be_edited(edited: Path, tmp_path: Path) -> None:
    edit_run(edited / "scene", tmp_path / "out", [lambda v: orient(v, SHIFT)], silent, "default")
    before, after = decode_scene(edited / "scene").static, load_scene(tmp_path / "out" / "scene.npz").static
    np.testing.assert_allclose(after.means[:, 1], 2 * before.means[:, 1] + 2, atol=1e-5)  # a turn about y, and a scale
    assert len(load_manifest(tmp_path / "out" / "scene").cameras) == 3


def test_an_encoded_scene_that_only_loses_splats_keeps_the_bits_of_the_others(run: Path, tmp_path: Path) -> None:
    found = edit_run(run / "scene", tmp_path / "out", [lambda v: crop(v, ball_of([0, 0, 0, 0.8]))], silent, "low")
    before, after = decode_scene(run / "scene"), decode_scene(tmp_path / "out" / "scene")
    kept = crop(ViewedScene(before, (), np.zeros(1)), ball_of([0, 0, 0, 0.8])).viewed.scene
    assert 0 < found.kept == len(after.static) + after.dynamic_splats < found.splats
    for left, right in [
        (after.static, kept.static),
        *((a.dynamic, b.dynamic) for a, b in zip(after.segments, kept.segments, strict=True)),
    ]:
        for (name, one), (_, other) in zip(left.items(), right.items(), strict=True):
            np.testing.assert_array_equal(one, other, name)
    sound = read_audio(tmp_path / "out" / "scene", load_manifest(tmp_path / "out" / "scene"))
    assert sound is not None
    assert (tmp_path / "out" / "scene" / "thumbnail.jpg").is_file()


def test_an_edited_run_has_no_pictures_to_be_scored_with(edited: Path) -> None:
    with pytest.raises(InputError, match="run: was edited, so that no pictures show the scene as it is now"):
        RunFolder(edited).read_spec().open_capture()


def test_an_edit_that_fails_leaves_nothing(run: Path, tmp_path: Path) -> None:
    def fail(viewed: ViewedScene) -> Edit:
        raise InputError("--box", "is refused")

    with pytest.raises(InputError, match="is refused"):
        edit_run(run, tmp_path / "out", [fail], silent, "default")
    assert not any(tmp_path.iterdir())


def test_an_encoding_that_fails_leaves_nothing(run: Path, tmp_path: Path) -> None:
    def stop(progress: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        edit_run(run, tmp_path / "out", [lambda v: trim(v, 0, 0.5)], stop, "default")
    assert not any(tmp_path.iterdir())


def test_a_folder_that_is_there_is_refused(run: Path, edited: Path) -> None:
    with pytest.raises(InputError, match="edited: exists; choose a new or empty folder for --out"):
        edit_run(run, edited, [lambda v: trim(v, 0, 0.5)], silent, "default")


def test_listed_splats_of_a_run_are_those_of_its_encoded_scene(run: Path, tmp_path: Path) -> None:
    before = decode_scene(run / "scene")
    chunk = load_manifest(run / "scene").static[-1]
    start = len(before.static) - chunk.splats
    (tmp_path / "list.json").write_text(
        json.dumps({"format": "hgs-splats", "version": 1, "chunks": {chunk.id: [[2, 3]]}})
    )
    listed = SplatList.load(tmp_path / "list.json")
    found = edit_run(run, tmp_path / "out", [lambda v: trim(v, 0, 0.5)], silent, "high", listed)
    assert found.changes[0].reason == "list.json lists them"
    after = load_scene(tmp_path / "out" / "scene.npz")
    np.testing.assert_array_equal(after.static.means, np.delete(before.static.means, [start + 2, start + 3], axis=0))
    assert (after.end, load_manifest(tmp_path / "out" / "scene").title) == (0.5, "Figure")


def test_what_is_left_out_is_counted(run: Path, tmp_path: Path) -> None:
    found = edit_run(run, tmp_path / "out", [lambda v: crop(v, ball_of([0, 0, 0, 1.0]))], silent, "default")
    assert (found.splats, found.to_json()["changes"][0]["of"]) == (153, 153)
    assert found.splats - sum(change.count or 0 for change in found.changes) == found.kept
