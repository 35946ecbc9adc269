"""Footage without a camera: a look, or a stop where much of it has none."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.capture.open import open_capture
from hgs_core.check.capture_check import check_capture
from hgs_core.check.left_out import judge_left_out
from tests.hgs_core.capture import layouts
from tests.hgs_core.capture.layouts import CAMERAS, PICTURES


@pytest.mark.parametrize(("left_out", "stops"), [(["a"], False), (["a", "b"], False), (["a", "b", "c"], True)])
def test_a_third_of_the_footage_may_be_without_cameras(left_out: list[str], stops: bool) -> None:
    (finding,) = judge_left_out(4, left_out)
    assert finding.stops is stops
    assert finding.problem.endswith(f"none for {', '.join(left_out)}")


def test_all_footage_with_cameras_is_no_finding() -> None:
    assert judge_left_out(6, []) == []


@pytest.mark.parametrize("cameras", [name for name in CAMERAS if name != "poses_bounds.npy"])
def test_every_format_s_capture_knows_what_has_no_camera(tmp_path: Path, cameras: str) -> None:
    """poses_bounds.npy has no names: there another number of videos is refused."""
    CAMERAS[cameras](tmp_path)
    PICTURES["videos"](tmp_path)
    layouts.videos(names=("cam11", "spare"))(tmp_path)
    opened = open_capture(tmp_path)
    assert opened.left_out == ("cam11", "spare")
    finding = next(one for one in check_capture(opened).findings if "none for" in one.problem)
    assert finding.problem == "the calibration has 4 cameras for the footage of 6: none for cam11, spare"


@pytest.mark.parametrize("pattern", ["images/{camera}/{frame}.png", "images/{camera}.png"])
def test_pictures_that_transforms_json_does_not_list_are_without_camera(tmp_path: Path, pattern: str) -> None:
    layouts.folders(pattern)(tmp_path)
    layouts.folders(pattern, ("spare",))(tmp_path)
    entries = layouts.frames_of_pictures(pattern)
    layouts.transforms(list({entry["file_path"]: entry for entry in entries}.values()))(tmp_path)
    assert open_capture(tmp_path).left_out == ("spare",)


def test_videos_that_transforms_json_does_not_list_are_without_camera(tmp_path: Path) -> None:
    layouts.videos()(tmp_path)
    layouts.transforms(layouts.frames_of_videos()[:2])(tmp_path)
    opened = open_capture(tmp_path)
    assert opened.left_out == ("cam03", "cam10")
    assert [one.stops for one in check_capture(opened).findings if "none for" in one.problem] == [True]


def test_what_is_moved_to_another_folder_is_no_finding(tmp_path: Path) -> None:
    """The cure of the finding."""
    CAMERAS["COLMAP text"](tmp_path)
    PICTURES["videos"](tmp_path)
    layouts.videos("other", names=("making_of",))(tmp_path)
    assert open_capture(tmp_path).left_out == ()
