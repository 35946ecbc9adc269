from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest

from hgs_core.capture.open import open_capture
from hgs_core.check.interlacing import judge_interlacing
from tests.hgs_core.capture import layouts


@pytest.mark.parametrize("fields", ["tff=1", "bff=1"])
def test_videos_of_two_fields_are_named_with_the_command_that_makes_them_whole(tmp_path: Path, fields: str) -> None:
    layouts.easymocap(tmp_path)
    for place, name in enumerate(layouts.NAMES):
        options = {"flags": "+ilme+ildct", "x264-params": fields} if place in (1, 3) else {}
        with av.open(str(tmp_path / f"{name}.mp4"), "w") as container:
            stream = container.add_stream("libx264", rate=25, options=options)
            stream.width, stream.height, stream.pix_fmt = layouts.WIDTH, layouts.HEIGHT, "yuv420p"
            picture = np.full((layouts.HEIGHT, layouts.WIDTH, 3), 90, np.uint8)
            for _ in range(4):
                container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
            container.mux(stream.encode())
    (finding,) = judge_interlacing(open_capture(tmp_path))
    assert finding.cameras == (layouts.NAMES[1], layouts.NAMES[3])
    assert not finding.stops
    assert f"ffmpeg -i {layouts.NAMES[1]}.mp4 -vf bwdif=mode=send_frame" in finding.cure


def test_whole_pictures_are_no_finding(tmp_path: Path) -> None:
    layouts.easymocap(tmp_path)
    layouts.videos()(tmp_path)
    assert judge_interlacing(open_capture(tmp_path)) == []
