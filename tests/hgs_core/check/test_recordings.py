from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from hgs_core.check.evidence import CameraEvidence
from hgs_core.check.recordings import judge_pictures, judge_rates

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


def test_two_cameras_are_few() -> None:
    (finding,) = judge_pictures(NAMES[:2], [view()] * 2)
    assert "2 cameras" in finding.problem


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
