from __future__ import annotations

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


def test_a_video_at_another_rate_is_named_with_the_time_in_which_it_drifts_by_a_frame(tmp_path: Path) -> None:
    for name, rate in (("a", Fraction(30)), ("b", Fraction(30000, 1001)), ("c", Fraction(30))):
        with av.open(str(tmp_path / f"{name}.mp4"), "w") as file:
            stream = file.add_stream("libx264", rate=rate)
            stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
            for _ in range(4):
                frame = av.VideoFrame.from_ndarray(np.zeros((48, 64, 3), np.uint8), format="rgb24")
                file.mux(stream.encode(frame))
            file.mux(stream.encode(None))
    (finding,) = judge_rates(tmp_path, ["a", "b", "c"])
    assert finding.cameras == ("b",)
    assert "29.97" in finding.problem
    assert "33 s" in finding.problem
    assert judge_rates(tmp_path, ["a", "c"]) == []
