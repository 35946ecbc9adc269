"""Findings about interlaced videos: pictures of two moments each."""

from __future__ import annotations

from hgs_core.capture.capture import Capture
from hgs_core.capture.files.encoding_again import encode_again
from hgs_core.check.findings import Finding

__all__ = ["judge_interlacing"]


def judge_interlacing(capture: Capture) -> list[Finding]:
    """Find videos flagged as interlaced: moving edges have combs."""
    found = [(i, camera.name) for i, camera in enumerate(capture.cameras) if capture.interlaced(i)]
    if not found:
        return []
    video = capture.video(found[0][0])
    assert video is not None
    command = encode_again(video[0], writing="-vf bwdif=mode=send_frame -c:v libx264 -crf 12")
    problem = "the video is interlaced: every second line of a picture is of half a frame later, and what moves is torn"
    cure = f"make whole pictures of its fields: {command}"
    return [Finding(False, tuple(name for _, name in found), problem, cure)]
