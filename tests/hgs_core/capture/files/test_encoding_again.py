from __future__ import annotations

from pathlib import Path

from hgs_core.capture.files.encoding_again import encode_again


def test_the_new_video_is_called_like_the_old_one() -> None:
    assert encode_again(Path("/a/cam 1.mp4")) == (
        "ffmpeg -i 'cam 1.mp4' -c:v libx264 -crf 12 new.mp4 && mv new.mp4 'cam 1.mp4'"
    )
    assert encode_again(Path("cam1.h264"), reading="-framerate 30", writing="-c copy") == (
        "ffmpeg -framerate 30 -i cam1.h264 -c copy new.mp4 && mv new.mp4 cam1.mp4 && rm cam1.h264"
    )
