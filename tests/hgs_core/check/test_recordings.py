from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from hgs_core.check.evidence import CameraEvidence
from hgs_core.check.recordings import judge_number, judge_pictures, judge_rates
from tests.synthetic import ring_of_cameras

NAMES = ["a", "b", "c", "d"]


def view(level: tuple[int, float] = (90, 0.02)) -> CameraEvidence:
    return CameraEvidence((), (), {}, None, level)


def test_pictures_of_one_level_stop_where_no_camera_shows_more() -> None:
    (finding,) = judge_pictures(NAMES, [view((255, 1.0))] * 4)
    assert finding.stops
    assert "level 255" in finding.problem
    (finding,) = judge_pictures(NAMES, [view(), view((0, 0.99)), view(), view()])
    assert not finding.stops
    assert finding.cameras == ("b",)
    assert judge_pictures(NAMES, [view()] * 4) == []
    assert judge_pictures(NAMES, [view(), view((0, 0.99)), view(), view()], blank={"b"}) == []


def test_few_cameras_beside_each_other_and_few_all_around_are_told_apart() -> None:
    (finding,) = judge_number(ring_of_cameras(9, 64, 48)[:3])
    assert "3 cameras: a scene looks right only near" in finding.problem
    (finding,) = judge_number(ring_of_cameras(3, 64, 48))
    assert "3 cameras all around: what moves looks right from anywhere" in finding.problem
    assert judge_number(ring_of_cameras(4, 64, 48)) == []


def filmed(path: Path, stamps: Iterable[float], ticks: int = 90_000) -> None:
    """Write black pictures with time stamps, seconds, rounded to ticks."""
    with av.open(str(path), "w") as file:
        stream = file.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.time_base = stream.codec_context.time_base = Fraction(1, ticks)
        for stamp in stamps:
            frame = av.VideoFrame.from_ndarray(np.zeros((48, 64, 3), np.uint8), format="rgb24")
            frame.pts, frame.time_base = round(stamp * ticks), stream.time_base
            file.mux(stream.encode(frame))
        file.mux(stream.encode(None))


def test_a_video_at_another_rate_is_named_with_the_time_in_which_it_drifts_by_a_frame(tmp_path: Path) -> None:
    for name, rate in (("a", 30), ("b", 30 / 1.001), ("c", 30)):
        filmed(tmp_path / f"{name}.mp4", np.arange(4) / rate)
    (finding,) = judge_rates(tmp_path, ["a", "b", "c"])
    assert finding.cameras == ("b",)
    assert "29.97" in finding.problem
    assert "33 s" in finding.problem
    assert judge_rates(tmp_path, ["a", "c"]) == []


def test_rounded_stamps_of_a_short_video_are_no_other_rate(tmp_path: Path) -> None:
    filmed(tmp_path / "a.mp4", np.arange(20) / 25)
    filmed(tmp_path / "b.mp4", np.arange(20) / 25, ticks=15_360)
    assert judge_rates(tmp_path, ["a", "b"]) == []


def test_uneven_frames_are_another_rate_once_they_are_frames_apart(tmp_path: Path) -> None:
    steps = np.where(np.arange(1, 20) % 4 == 0, 2 / 30, 2 / 90)
    for name in ("a", "b", "d"):
        filmed(tmp_path / f"{name}.mp4", np.arange(20) / 30)
    filmed(tmp_path / "c.mp4", np.cumsum([0, *steps]))
    assert judge_rates(tmp_path, NAMES) == []
    filmed(tmp_path / "c.mp4", np.cumsum([0, *np.tile(steps[:3], 20)]))
    (finding,) = judge_rates(tmp_path, NAMES)
    assert finding.cameras == ("c",)
