"""Where pictures are found, and in which order."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.capture.footage import find_places, is_picture, is_video, natural_order


def touch(root: Path, *files: str) -> None:
    for file in files:
        (root / file).parent.mkdir(parents=True, exist_ok=True)
        (root / file).touch()


def found(root: Path) -> dict[tuple[str, str], list[str]]:
    places = find_places(root)
    return {
        (place.kind, place.folder.relative_to(root).as_posix()): [f.name for f in place.footage] for place in places
    }


@pytest.mark.parametrize("name", ["a.mp4", "a.MP4", "GX01.Mov", "a.b.mkv", "a.insv", "a.hevc"])
def test_videos_by_their_endings(name: str) -> None:
    assert is_video(name)
    assert not is_picture(name)


@pytest.mark.parametrize("name", ["mp4", "poses_bounds.npy", "a.LRV", "a.txt", "a.jpg", "._a.mp4"])
def test_other_files_are_no_videos(name: str) -> None:
    assert not is_video(name)


def test_numbers_in_names_count_as_numbers() -> None:
    names = ["cam10", "cam2", "Cam1", "cam2b", "10", "9"]
    assert sorted(names, key=natural_order) == ["9", "10", "Cam1", "cam2", "cam2b", "cam10"]


def test_frames_come_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    touch(tmp_path, *(f"images/a/frame_{number}.jpg" for number in range(12)))
    place = next(place for place in find_places(tmp_path) if place.kind == "folders")
    assert [file.stem for file in place.footage[0].files] == [f"frame_{number}" for number in range(12)]


def test_a_folder_for_each_camera_or_each_moment(tmp_path: Path) -> None:
    touch(tmp_path, *(f"t{moment}/images/{camera}.png" for moment in range(2) for camera in "ab"))
    places = found(tmp_path)
    assert places["folders", "."] == ["t0", "t1"]
    assert places["moments", "."] == ["a", "b"]


def test_hidden_files_are_no_footage(tmp_path: Path) -> None:
    touch(tmp_path, "a.mp4", "b.mp4", "._a.mp4", "images/a/1.png", "images/a/._1.png", "images/b/1.png")
    places = found(tmp_path)
    assert places["videos", "."] == ["a", "b"]
    assert places["photographs", "images"] == ["a/1", "b/1"]


def test_what_only_some_moments_have_is_no_camera_of_them(tmp_path: Path) -> None:
    touch(tmp_path, "0/a.png", "0/b.png", "1/a.png")
    assert found(tmp_path)["moments", "."] == ["a"]


def test_masks_calibrations_and_hidden_folders_hold_no_footage(tmp_path: Path) -> None:
    for folder in ("masks", "seg", "sparse", "calibration", "intrinsic", ".trash", "depth"):
        touch(tmp_path, f"{folder}/a.mp4", f"{folder}/a/0.png")
    assert found(tmp_path) == {}


def test_footage_lies_at_most_three_folders_deep(tmp_path: Path) -> None:
    touch(tmp_path, "1/2/3/a.mp4", "1/2/3/4/b.mp4")
    assert found(tmp_path) == {("videos", "1/2/3"): ["a"]}


def test_pictures_that_are_not_read_are_found_where_there_are_no_others(tmp_path: Path) -> None:
    touch(tmp_path, "images/a/1.heic", "images/b/1.heic", "images/b/1.jpg", "images/b/2.jpg")
    place = next(place for place in find_places(tmp_path) if place.kind == "folders")
    assert [[file.name for file in one.files] for one in place.footage] == [["1.heic"], ["1.jpg", "2.jpg"]]
