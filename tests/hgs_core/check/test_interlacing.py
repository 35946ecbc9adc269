from __future__ import annotations

from functools import cache
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image

from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.check.interlacing import judge_interlacing
from hgs_core.check.picture_changes import picture_changes
from tests.hgs_core.capture import layouts
from tests.hgs_core.check.conftest import STUDIO

NAMES = ("cam00", "cam04", "cam06")
FLAGGED = {"flags": "+ilme+ildct", "x264-params": "tff=1"}


@cache
def moments(name: str) -> list[np.ndarray]:
    with av.open(str(STUDIO / f"{name}.mp4")) as video:
        frames = video.decode(video=0)
        return [next(frames).to_ndarray(format="rgb24") for _ in range(12)]


def whole(name: str) -> list[np.ndarray]:
    return moments(name)[::2]


def torn(name: str, top_first: bool = True) -> list[np.ndarray]:
    """Every two moments in one picture."""
    made = []
    for first, second in zip(moments(name)[::2], moments(name)[1::2], strict=True):
        top, bottom = (first, second) if top_first else (second, first)
        made.append(top.copy())
        made[-1][1::2] = bottom[1::2]
    return made


def write(path: Path, pictures: list[np.ndarray], options: dict[str, str]) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=15, options={"crf": "20"} | options)
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = "yuv420p"
        for picture in pictures:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())


def recorded(folder: Path, *films: list[np.ndarray], flagged: bool = False, downscale: int = 1) -> Capture:
    """A capture of three cameras: a video each."""
    for name, film in zip(NAMES, films, strict=True):
        write(folder / f"{name}.mp4", film, FLAGGED if flagged else {})
    np.save(folder / "poses_bounds.npy", np.load(STUDIO / "poses_bounds.npy")[[0, 4, 6]])
    return open_capture(folder, downscale=downscale)


def problems(capture: Capture) -> list[tuple[tuple[str, ...], str, str]]:
    frames = range(len(capture.times))
    changes = [picture_changes(lambda f, i=i: capture.frame(i, f), frames) for i in range(len(capture.cameras))]
    found = judge_interlacing(capture, changes)
    assert not any(finding.stops for finding in found)
    return [(finding.cameras, finding.problem, finding.cure) for finding in found]


@pytest.mark.parametrize("fields", ["tff=1", "bff=1"])
def test_videos_of_two_fields_are_named_though_nothing_moves(tmp_path: Path, fields: str) -> None:
    layouts.easymocap(tmp_path)
    for place, name in enumerate(layouts.NAMES):
        options = {"flags": "+ilme+ildct", "x264-params": fields} if place in (1, 3) else {}
        picture = np.full((layouts.HEIGHT, layouts.WIDTH, 3), 90, np.uint8)
        write(tmp_path / f"{name}.mp4", [picture] * 4, options)
    ((cameras, problem, cure),) = problems(open_capture(tmp_path))
    assert cameras == (layouts.NAMES[1], layouts.NAMES[3])
    assert problem.startswith("the video is interlaced: every second line")
    assert f"ffmpeg -i {layouts.NAMES[1]}.mp4 -vf bwdif=mode=send_frame -c:v libx264" in cure


@pytest.mark.parametrize("downscale", [1, 2])
def test_combs_are_named_where_no_flag_tells_of_them(tmp_path: Path, downscale: int) -> None:
    films = torn("cam00"), whole("cam04"), torn("cam06", top_first=False)
    found = problems(recorded(tmp_path, *films, downscale=downscale))
    assert [cameras for cameras, *_ in found] == [("cam00",), ("cam06",)]
    for (_, problem, cure), command in zip(
        found,
        ("cam00.mp4 -vf bwdif=mode=send_frame:parity=tff", "cam06.mp4 -vf bwdif=mode=send_frame:parity=bff"),
        strict=True,
    ):
        assert problem.startswith("the video is interlaced, though its file does not say so")
        assert f"ffmpeg -i {command} -c:v libx264" in cure


def test_pictures_of_two_moments_are_to_be_taken_from_the_video_again(tmp_path: Path) -> None:
    for name in NAMES:
        (tmp_path / name / "images").mkdir(parents=True)
        for number, picture in enumerate(torn(name)):
            Image.fromarray(picture).save(tmp_path / name / "images" / f"{number:04d}.jpg", quality=95)
    np.save(tmp_path / "poses_bounds.npy", np.load(STUDIO / "poses_bounds.npy")[[0, 4, 6]])
    ((cameras, problem, cure),) = problems(open_capture(tmp_path))
    assert cameras == NAMES
    assert problem.startswith("the pictures are of interlaced video")
    assert "ffmpeg -i VIDEO -vf bwdif=mode=send_frame:parity=tff %06d.png" in cure


def test_whole_pictures_are_no_finding_even_if_a_flag_says_otherwise(tmp_path: Path) -> None:
    assert problems(recorded(tmp_path, *(whole(name) for name in NAMES), flagged=True)) == []
