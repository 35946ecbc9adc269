"""Folders of frames of one still format."""

from __future__ import annotations

import re
import shutil
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, StageStopped, silent
from hgs_core.interchange import import_scene
from hgs_core.interchange.file_format import NOTHING_KNOWN
from hgs_core.interchange.frame_sequence import write_sequence
from hgs_core.interchange.ply.ply_file import PLY
from hgs_core.interchange.sog_file import SOG
from hgs_core.interchange.still_moment import scene_at
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.temporal import evaluate
from tests.hgs_core.interchange.scenes import counted, dynamics, plain


def read(path: Path) -> StaticSplats[np.ndarray]:
    assert PLY.read is not None
    return PLY.read(path, NOTHING_KNOWN).static


def test_frames_are_the_scene_at_each_of_their_times(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    """From 2 to 4 s at 2 a second: five, of which the last one shows the end."""
    told: list[Progress] = []
    write_sequence(scene, tmp_path / "out" / "frames", PLY, 2.0, told.append)
    files = sorted((tmp_path / "out" / "frames").iterdir())
    assert [file.name for file in files] == [f"frame_{number:04d}.ply" for number in range(5)]
    for file, seconds in zip(files, (2.0, 2.5, 3.0, 3.5, 4.0), strict=True):
        expected = scene_at(scene, seconds)
        found = read(file)
        np.testing.assert_array_equal(found.means, expected.means)
        np.testing.assert_allclose(found.opacity_logits, expected.opacity_logits, atol=1e-6)
    assert [(one.stage, one.done, one.total) for one in told] == [("export", n, 5) for n in range(1, 6)]
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["frames"]  # nothing temporary


def brief(count: int) -> DynamicSplats[np.ndarray]:
    """Splats that live for a hundredth of the time around 0.25, where no frame is."""
    found = dynamics(count)
    return DynamicSplats(
        **dict(found.items())
        | {
            "time_centers": np.full(count, 0.25, np.float32),
            "time_log_precisions": np.full(count, 14.0, np.float32),
        }
    )


def test_splats_that_no_frame_shows_and_what_stands_still_are_counted(tmp_path: Path) -> None:
    given = HybridScene(plain(), (Segment(0.0, 1.0, brief(7)), Segment(1.0, 2.0, dynamics(30))))
    changes = write_sequence(given, tmp_path / "frames", PLY, 1.0, silent)
    unseen = evaluate(given.segments[1].dynamic, 0.0)[2] < 1 / 255
    unseen &= evaluate(given.segments[1].dynamic, 1.0)[2] < 1 / 255
    found = counted(changes)
    assert found["left out", "splats"] == 7 + unseen.sum()
    assert found["replaced", "motion and life"] == 37
    assert str(changes[2]) == "time replaced: 3 files show 0 to 2 s, and do not tell that they are 1 a second"


def test_of_what_frames_change_the_one_with_the_most_splats_is_told(tmp_path: Path) -> None:
    dark = DynamicSplats(**dict(dynamics(5).items()) | {"rgb": np.full((5, 3), -1, np.float32)})
    changes = write_sequence(HybridScene(plain(), (Segment(0.0, 1.0, dark),)), tmp_path / "frames", PLY, 4.0, silent)
    assert counted(changes)["limited", "colour"] == max(
        int((read(file).rgb < 0).any(axis=1).sum()) for file in (tmp_path / "frames").iterdir()
    )


def moving() -> HybridScene[np.ndarray]:
    return HybridScene(plain(), (Segment(0.0, 1.0, dynamics()),))


def test_a_scene_that_does_not_move_has_no_frames(still: HybridScene[np.ndarray], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"scene: does not move, and a folder is for frames; export x.ply"):
        write_sequence(still, tmp_path / "x", PLY, 30.0, silent)


def test_a_rate_that_is_none_and_a_folder_that_is_full_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--fps: 0 is not positive"):
        write_sequence(moving(), tmp_path / "x", PLY, 0.0, silent)
    (tmp_path / "a").write_bytes(b"")
    with pytest.raises(InputError, match="holds something; name a new folder"):
        write_sequence(moving(), tmp_path, PLY, 1.0, silent)


def test_frames_that_do_not_fit_on_the_disk_are_not_begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda path: namedtuple("Usage", "free")(9_000))
    with pytest.raises(InputError) as caught:
        write_sequence(moving(), tmp_path / "x", PLY, 4.0, silent)
    bytes_ = int(
        re.findall(r"needs ([\d,]+) bytes for 5 frames, and 9,000 are free", str(caught.value))[0].replace(",", "")
    )
    monkeypatch.undo()
    write_sequence(moving(), tmp_path / "x", PLY, 4.0, silent)
    bodies = [file.read_bytes().partition(b"end_header\n")[2] for file in (tmp_path / "x").iterdir()]
    assert bytes_ == sum(map(len, bodies))


def test_nothing_is_left_of_an_export_that_was_stopped(tmp_path: Path) -> None:
    def stop(progress: Progress) -> None:
        if progress.done == 2:
            raise StageStopped

    with pytest.raises(StageStopped):
        write_sequence(moving(), tmp_path / "x", PLY, 4.0, stop)
    assert not any(tmp_path.iterdir())


def test_frames_of_pictures_are_the_scene_at_each_of_their_times(
    scene: HybridScene[np.ndarray], tmp_path: Path
) -> None:
    changes = write_sequence(scene, tmp_path / "x", SOG, 1.0, silent)
    files = sorted((tmp_path / "x").iterdir())
    assert [file.name for file in files] == [f"frame_{number:04d}.sog" for number in range(3)]
    for file, seconds in zip(files, (2.0, 3.0, 4.0), strict=True):
        expected, found = scene_at(scene, seconds), import_scene(file).scene.static
        assert len(found) == len(expected)
        np.testing.assert_allclose(np.sort(found.means[:, 0]), np.sort(expected.means[:, 0]), atol=1e-3)
    assert counted(changes)["rounded", "position"] >= 50
