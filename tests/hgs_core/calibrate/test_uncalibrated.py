from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.calibrate.uncalibrated import find_videos, has_poses


def touch(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch()


def test_videos_come_in_the_order_of_their_numbers_whatever_they_are_called(tmp_path: Path) -> None:
    touch(tmp_path, "cam10.mp4", "cam2.MP4", "cam1.mov", "notes.txt", "poster.jpg")
    assert [file.name for file in find_videos(tmp_path).values()] == ["cam1.mov", "cam2.MP4", "cam10.mp4"]


def test_videos_in_a_folder_of_their_own_are_found(tmp_path: Path) -> None:
    touch(tmp_path, "videos/a.mkv", "videos/b.mkv")
    assert [file.stem for file in find_videos(tmp_path).values()] == ["a", "b"]


def test_every_ending_that_captures_may_have_is_a_video_here_too(tmp_path: Path) -> None:
    touch(tmp_path, "left.MTS", "right.3gp")
    assert [file.name for file in find_videos(tmp_path).values()] == ["left.MTS", "right.3gp"]


def test_two_videos_of_one_name_and_too_few_are_refused(tmp_path: Path) -> None:
    touch(tmp_path, "a.mp4")
    with pytest.raises(InputError, match="has no two videos"):
        find_videos(tmp_path)
    touch(tmp_path, "a.mov")
    with pytest.raises(InputError, match="two videos are called a"):
        find_videos(tmp_path)
    with pytest.raises(InputError, match="is a file, not a folder"):
        find_videos(tmp_path / "a.mp4")
    with pytest.raises(InputError, match="does not exist"):
        find_videos(tmp_path / "gone")


@pytest.mark.parametrize(
    "names", [["poses_bounds.npy"], ["sparse/0/cameras.bin", "sparse/0/images.bin"], ["intri.yml"]]
)
def test_poses_that_are_there_are_seen(tmp_path: Path, names: list[str]) -> None:
    assert not has_poses(tmp_path)
    touch(tmp_path, *names)
    assert has_poses(tmp_path)


def test_other_files_of_such_endings_are_no_poses(tmp_path: Path) -> None:
    touch(tmp_path, "pyproject.toml", "notes.yml", "shot_list.json")
    assert not has_poses(tmp_path)
