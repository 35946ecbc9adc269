from __future__ import annotations

import logging
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec import encode_scene, load_manifest
from hgs_core.codec.format.scene_folder import checked_chunks, read_audio
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from hgs_core.runs.sound import replace_sound, require_sound_file, require_sounding_video, scene_sound
from hgs_core.scene.splats import HybridScene, Segment
from tests.hgs_core.capture.sounding import write_sounding_video
from tests.hgs_core.check.test_starts_by_sound import heard, scene
from tests.synthetic import ring_of_cameras, synthetic_scene

SOUND = 0.2 * scene(5)


@pytest.fixture(scope="module")
def videos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A video without sound, two with the same, of which the second began half a second later."""
    folder = tmp_path_factory.mktemp("videos")
    write_sounding_video(folder / "a.mkv", 20, None)
    write_sounding_video(folder / "b.mkv", 20, heard(SOUND, 0.0))
    write_sounding_video(folder / "c.mkv", 20, heard(SOUND, 0.5), codec="libopus")
    return folder


@pytest.fixture
def run(tmp_path: Path) -> RunFolder:
    """A finished run of a second, without sound."""
    folder = RunFolder(tmp_path / "run")
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    folder.write_spec(RunSpec(tmp_path / "capture", "", RunConfig(), without_capture=True))
    encode_scene(
        HybridScene(static, (Segment(0.0, 1.0, dynamic),)),
        folder.scene,
        cameras=ring_of_cameras(2, 64, 48),
        times=np.arange(30) / 30,
        title="Figure",
    )
    return folder


def capture_of(*found: tuple[Path, float]) -> Any:
    cameras = [SimpleNamespace(name=path.stem) for path, _ in found]
    return SimpleNamespace(cameras=cameras, video=lambda camera: found[camera])


def spec_with(audio: str) -> RunSpec:
    return RunSpec(Path("capture"), "", RunConfig(), GivenFiles(audio=audio))


def test_the_first_camera_with_sound_is_heard_on_the_captures_clock(videos: Path, run: RunFolder) -> None:
    capture = capture_of((videos / "a.mkv", 0.0), (videos / "b.mkv", -2.0), (videos / "c.mkv", 0.0))
    sound = scene_sound(run, spec_with("auto"), capture, 0.0, 3.0)
    later = scene_sound(run, spec_with("auto"), capture_of((videos / "b.mkv", 8.0)), 10.0, 13.0)
    assert sound is not None
    assert later is not None
    assert [p.start for p in sound.entry.pieces] == pytest.approx([p.start - 10.0 for p in later.entry.pieces])
    assert sound.entry.pieces[0].start <= 0.0 < sound.entry.pieces[0].end
    assert set(sound.chunks) == set(sound.entry.sizes)


def test_a_camera_that_is_named_is_heard_by_its_own_clock(videos: Path, run: RunFolder) -> None:
    capture = capture_of((videos / "b.mkv", 0.0), (videos / "c.mkv", 0.5))
    named = scene_sound(run, spec_with("camera:c"), capture, 0.0, 2.0)
    alone = scene_sound(run, spec_with("auto"), capture_of((videos / "c.mkv", 0.5)), 0.0, 2.0)
    assert named == alone != scene_sound(run, spec_with("auto"), capture, 0.0, 2.0)
    with pytest.raises(InputError, match="camera:z: the run has no video of this camera"):
        scene_sound(run, spec_with("camera:z"), capture, 0.0, 2.0)


def test_a_camera_must_be_there_and_have_sound(videos: Path) -> None:
    named = {name: videos / f"{name}.mkv" for name in "abc"} | {"photographed": None}
    assert require_sound_file("camera:b") == "camera:b"
    require_sounding_video("camera:b", named)
    require_sounding_video("auto", {})
    with pytest.raises(
        InputError, match="camera:z: there is no such camera; its cameras are a, b, c, photographed"
    ) as refused:
        require_sounding_video("camera:z", named)
    assert refused.value.field == "audio"
    for silent in ("a", "photographed"):
        with pytest.raises(InputError, match="has no video with sound"):
            require_sounding_video(f"camera:{silent}", named)


def test_a_capture_without_sound_and_a_wish_for_none_have_none(videos: Path, run: RunFolder) -> None:
    assert scene_sound(run, spec_with("auto"), capture_of((videos / "a.mkv", 0.0)), 0.0, 1.0) is None
    assert scene_sound(run, spec_with("none"), capture_of((videos / "b.mkv", 0.0)), 0.0, 1.0) is None


def test_a_file_is_put_where_a_camera_heard_the_same_else_at_the_start(
    videos: Path, run: RunFolder, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    spec = spec_with(str(videos / "c.mkv"))
    placed = scene_sound(run, spec, capture_of((videos / "b.mkv", 0.0)), 0.0, 2.0)
    alone = scene_sound(run, spec, capture_of((videos / "a.mkv", 0.0)), -0.5, 1.5)
    assert placed is not None
    assert alone is not None
    moved = [piece.start for piece in placed.entry.pieces]
    assert moved == pytest.approx([piece.start + 0.5 for piece in alone.entry.pieces[-len(moved) :]], abs=2e-3)
    assert caplog.text == ""
    write_sounding_video(videos / "other.mkv", 20, 0.2 * scene(9), codec="libopus")
    scene_sound(run, spec_with(str(videos / "other.mkv")), capture_of((videos / "b.mkv", 0.0)), 0.0, 2.0)
    assert "it is taken to begin with the scene" in caplog.text


def test_what_browsers_do_not_play_is_encoded_and_said(
    videos: Path, run: RunFolder, caplog: pytest.LogCaptureFixture
) -> None:
    scene_sound(run, spec_with("auto"), capture_of((videos / "b.mkv", 0.0)), 0.0, 1.0)
    assert "b.mkv is pcm_s16le, which browsers do not play: encoded as Opus" in caplog.text


def test_a_finished_scene_gets_sound_and_loses_it_to_the_same_bytes(videos: Path, run: RunFolder) -> None:
    before, chunks = run.manifest.read_bytes(), sorted(path.name for path in (run.scene / "chunks").iterdir())
    replace_sound(run.path, str(videos / "c.mkv"))
    manifest = load_manifest(run.scene)
    assert manifest.audio is not None
    assert manifest.audio.pieces[-1].end >= 1.0
    assert {entry.id for entry, _ in checked_chunks(run.scene, manifest)} >= set(manifest.audio.sizes)
    assert read_audio(run.scene, manifest) == scene_sound(run, spec_with("auto"), None, 0.0, 1.0)  # the kept sound
    replace_sound(run.path, "none")
    assert run.manifest.read_bytes() == before
    assert sorted(path.name for path in (run.scene / "chunks").iterdir()) == chunks


def test_damaged_sound_of_a_capture_is_left_out_and_said(
    tmp_path: Path, videos: Path, run: RunFolder, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "d.mkv").write_bytes(b"no video")
    monkeypatch.setattr("hgs_core.runs.sound.has_sound", lambda path: True)
    assert scene_sound(run, spec_with("auto"), capture_of((tmp_path / "d.mkv", 0.0)), 0.0, 1.0) is None
    assert "d.mkv: the sound is unreadable" in caplog.text


def test_a_file_must_be_there_and_have_sound(videos: Path, tmp_path: Path) -> None:
    assert require_sound_file("auto") == "auto"
    assert require_sound_file(str(videos / "b.mkv")) == str((videos / "b.mkv").resolve())
    with pytest.raises(InputError, match="there is no such file"):
        require_sound_file(str(tmp_path / "gone.wav"))
    with pytest.raises(InputError, match=r"a\.mkv: the file has no sound"):
        require_sound_file(str(videos / "a.mkv"))
