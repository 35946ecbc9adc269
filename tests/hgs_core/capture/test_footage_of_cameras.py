"""Which footage goes to which camera, and the errors that list both sides."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.rig import CalibratedCamera, Rig
from hgs_core.capture.footage_of_cameras import Matched, match_footage
from hgs_core.capture.pictures.video import VideoReader
from tests.hgs_core.capture.layouts import picture, write_video


def rig(root: Path, *names: tuple[str, ...] | str, nameless: int = 0) -> Rig:
    listed = [(name,) if isinstance(name, str) else name for name in names] + [()] * nameless
    return Rig((root / "poses",), [CalibratedCamera("poses", own, np.eye(4), (50.0, 50.0)) for own in listed])


def touch(root: Path, *files: str) -> None:
    for file in files:
        (root / file).parent.mkdir(parents=True, exist_ok=True)
        (root / file).touch()


def files(root: Path, matched: Matched) -> dict[str, list[str]]:
    pairs = zip(matched.names, matched.footage, strict=True)
    return {name: [str(file.relative_to(root)) for file in one.files] for name, one in pairs}


def test_names_agree_in_any_case(tmp_path: Path) -> None:
    touch(tmp_path, "Left.MP4", "RIGHT.mov")
    found = match_footage(tmp_path, rig(tmp_path, "left", "right"))
    assert files(tmp_path, found) == {"left": ["Left.MP4"], "right": ["RIGHT.mov"]}


def test_last_numbers_agree_where_names_do_not(tmp_path: Path) -> None:
    touch(tmp_path, "camera_0001.mp4", "camera_0012.mp4", "camera_0002.mp4")
    found = match_footage(tmp_path, rig(tmp_path, "int_cam12_img", "int_cam1_img", "int_cam2_img"))
    assert files(tmp_path, found)["int_cam12_img"] == ["camera_0012.mp4"]
    assert files(tmp_path, found)["int_cam1_img"] == ["camera_0001.mp4"]


def test_numbers_of_pictures_are_frames_and_match_no_camera(tmp_path: Path) -> None:
    """Camera 3's folder is missing: the numbers of the frames 0 to 3 must not be taken for the cameras'."""
    touch(tmp_path, *(f"images/{camera:02d}/{frame:06d}.jpg" for camera in range(3) for frame in range(4)))
    with pytest.raises(InputError, match=r"images/ has pictures of 00, 01, 02: there are none of 03"):
        match_footage(tmp_path, rig(tmp_path, "00", "01", "02", "03"))


def test_folders_called_like_cameras_are_not_moments(tmp_path: Path) -> None:
    """The folder of camera 2 is missing: frames 0, 1 and 2 of the others must not be taken for pictures of 0, 1, 2."""
    touch(tmp_path, *(f"images/{camera}/{frame}.png" for camera in range(2) for frame in range(3)))
    with pytest.raises(InputError, match="there are none of 2"):
        match_footage(tmp_path, rig(tmp_path, "0", "1", "2"))


def test_nameless_cameras_take_footage_in_the_order_of_its_numbers(tmp_path: Path) -> None:
    touch(tmp_path, "cam10.mp4", "cam2.mp4", "cam1.mp4", "making_of.mp4")
    found = match_footage(tmp_path, rig(tmp_path, nameless=3))
    assert found.names == ("cam1", "cam2", "cam10")
    assert found.notes == ("making_of in the folder is of no camera and left out",)


def test_nameless_cameras_and_another_number_of_videos(tmp_path: Path) -> None:
    touch(tmp_path, "videos/a.mp4", "videos/b.mp4")
    with pytest.raises(InputError, match=r"poses: 3 poses for 2 videos \(a, b\); every camera needs one row"):
        match_footage(tmp_path, rig(tmp_path, nameless=3))


def test_as_many_folders_as_pictures_in_each_may_be_either(tmp_path: Path) -> None:
    touch(tmp_path, *(f"images/{a}/{b}.png" for a in range(3) for b in range(3)))
    with pytest.raises(InputError, match="its folders may be cameras or moments: give cameras with names"):
        match_footage(tmp_path, rig(tmp_path, nameless=3))


def test_missing_and_spare_videos_are_both_listed(tmp_path: Path) -> None:
    touch(tmp_path, "cam1.mp4", "cam2.mp4", "GOPR7.mp4")
    problem = r"poses has the cameras cam1, cam2, cam3, and the folder has pictures of cam1, cam2, GOPR7: "
    problem += r"there are none of cam3, and no camera for GOPR7; call each video"
    with pytest.raises(InputError, match=problem):
        match_footage(tmp_path, rig(tmp_path, "cam1", "cam2", "cam3"))


def test_footage_of_no_camera_is_left_out_and_said(tmp_path: Path) -> None:
    touch(tmp_path, "cam1.mp4", "cam2.mp4", "cam3.mp4")
    found = match_footage(tmp_path, rig(tmp_path, "cam1", "cam3"))
    assert list(files(tmp_path, found).values()) == [["cam1.mp4"], ["cam3.mp4"]]
    assert found.notes == ("cam2 in the folder is of no camera and left out",)


@pytest.mark.parametrize("better", ["videos/a.mp4 videos/b.mp4", "images/a/0.png images/a/1.png images/b/0.png"])
def test_videos_and_folders_come_before_photographs(tmp_path: Path, better: str) -> None:
    touch(tmp_path, "images/a.png", "images/b.png", *better.split())
    assert match_footage(tmp_path, rig(tmp_path, "a", "b")).kind != "photographs"


def test_videos_come_before_pictures_made_of_them(tmp_path: Path) -> None:
    touch(tmp_path, "images/a/0.png", "images/b/0.png", "videos/a.mp4", "videos/b.mp4")
    assert match_footage(tmp_path, rig(tmp_path, "a", "b")).kind == "videos"


def test_two_recordings_are_told_apart_by_the_user(tmp_path: Path) -> None:
    touch(tmp_path, *(f"recordings/{walk}/cam_{camera}.mp4" for walk in ("walk", "run") for camera in range(2)))
    with pytest.raises(InputError, match=r"recordings/(run|walk)/ and recordings/(run|walk)/ both hold"):
        match_footage(tmp_path, rig(tmp_path, "cam_0", "cam_1"))


def test_calibration_videos_are_no_footage(tmp_path: Path) -> None:
    touch(tmp_path, "calibration/extrinsic/a.mp4", "calibration/extrinsic/b.mp4", "videos/a.mp4", "videos/b.mp4")
    assert match_footage(tmp_path, rig(tmp_path, "a", "b")).folder == tmp_path / "videos"


def test_the_likeliest_names_that_tell_cameras_apart_are_taken(tmp_path: Path) -> None:
    """Of images a/0.png and b/0.png the folders tell the cameras apart, not the files."""
    touch(tmp_path, "b.mp4", "a.mp4")
    found = match_footage(tmp_path, rig(tmp_path, ("a/0", "a", "0"), ("b/0", "b", "0")))
    assert files(tmp_path, found) == {"a": ["a.mp4"], "b": ["b.mp4"]}


def test_cameras_without_any_footage(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"there are cameras \(poses\) but no videos and no folders of pictures"):
        match_footage(tmp_path, rig(tmp_path, "a"))


def test_two_videos_of_one_name_are_told(tmp_path: Path) -> None:
    touch(tmp_path, "a.mp4", "a.mov", "b.mp4")
    with pytest.raises(InputError, match="two of its videos are called a; keep one of them there"):
        match_footage(tmp_path, rig(tmp_path, "a", "b"))


@pytest.mark.parametrize("name", ["../cam1", "/cam1"])
def test_names_that_lead_out_of_a_folder_are_refused(tmp_path: Path, name: str) -> None:
    """Masks are written into folders called like their cameras."""
    touch(tmp_path, "1.mp4", "2.mp4")
    with pytest.raises(InputError, match="poses: a camera is called"):
        match_footage(tmp_path, rig(tmp_path, name, "cam2"))


def test_one_video_in_each_folder_is_its_camera_s(tmp_path: Path) -> None:
    touch(
        tmp_path, "cam00/GX010031.MP4", "Cam01/GX010007.MP4", "cam02/DCIM/100GOPRO/GX010031.MP4", "cam02/GX010031.THM"
    )
    found = match_footage(tmp_path, rig(tmp_path, "cam00", "cam01", "cam02"))
    assert [one[0].split("/")[-1] for one in files(tmp_path, found).values()] == [
        "GX010031.MP4",
        "GX010007.MP4",
        "GX010031.MP4",
    ]
    assert found.kind == "videos"


def test_a_folder_without_a_camera_among_folders_of_cameras_is_left_out(tmp_path: Path) -> None:
    touch(tmp_path, *(f"takes/cam{i}/GX01.MP4" for i in range(5)))
    found = match_footage(tmp_path, rig(tmp_path, "cam0", "cam1", "cam2", "cam3"))
    assert found.left_out == ("cam4",)


def test_chapters_in_a_camera_s_folder_are_refused_by_name(tmp_path: Path) -> None:
    touch(tmp_path, "cam00/GX010031.MP4", "cam00/GX020031.MP4", "cam01/GX010007.MP4", "cam02/GX010008.MP4")
    with pytest.raises(
        InputError, match=r"cam00: holds 2 videos .*: GX010031\.MP4, GX020031\.MP4; leave the one of"
    ) as caught:
        match_footage(tmp_path, rig(tmp_path, "cam00", "cam01", "cam02"))
    assert f"-c copy {tmp_path}/cam00.mp4" in str(caught.value)
    if shutil.which("ffmpeg"):
        for chapter in (tmp_path / "cam00").iterdir():
            chapter.unlink()
            write_video(chapter, [picture(0, frame) for frame in range(3)])
        command = str(caught.value).partition("join chapters of one: ")[2]
        subprocess.run(command, shell=True, check=True, stdin=subprocess.DEVNULL, capture_output=True)
        assert len(VideoReader(tmp_path / "cam00.mp4")) == 6
    touch(tmp_path, "cam00.mp4")  # the result of the refusal's command
    found = match_footage(tmp_path, rig(tmp_path, "cam00", "cam01", "cam02"))
    assert files(tmp_path, found)["cam00"] == ["cam00.mp4"]


def test_videos_beside_folders_of_cameras_count_first(tmp_path: Path) -> None:
    touch(tmp_path, *(f"cam{i}.mp4" for i in range(3)), *(f"cam{i}/raw.mp4" for i in range(3)))
    found = match_footage(tmp_path, rig(tmp_path, "cam0", "cam1", "cam2"))
    assert files(tmp_path, found)["cam2"] == ["cam2.mp4"]


@pytest.mark.parametrize("name", ["cam 1", "cam%201", "CAM 1", " cam 1", "x\\cam 1"])
def test_names_that_another_system_wrote_agree(tmp_path: Path, name: str) -> None:
    touch(tmp_path, "cam 1.mp4", "other.mp4")
    cameras = rig(tmp_path, (name, name.rpartition("\\")[2]), ("other", "other"))
    assert list(files(tmp_path, match_footage(tmp_path, cameras)).values()) == [["cam 1.mp4"], ["other.mp4"]]
