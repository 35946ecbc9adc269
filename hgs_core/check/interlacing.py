"""Findings about interlaced videos: pictures of two moments each."""

from __future__ import annotations

from collections.abc import Sequence

from hgs_core.base.cores import core_pool
from hgs_core.capture.capture import Capture
from hgs_core.capture.files.encoding_again import encode_again
from hgs_core.check.field_order import FieldOrder, busiest_frames, field_order
from hgs_core.check.findings import Finding
from hgs_core.check.picture_changes import PictureChanges

__all__ = ["judge_interlacing"]

_TORN = "every second line of a picture is of half a frame later, and what moves is torn"
_FILTER = "bwdif=mode=send_frame"


def judge_interlacing(capture: Capture, changes: Sequence[PictureChanges]) -> list[Finding]:
    """Find pictures of two moments, by motion in them; where too little moves, by the flag of the video."""
    cameras = range(len(capture.cameras))
    with core_pool() as pool:
        orders = list(pool.map(lambda i: _order(capture, i, changes[i]), cameras))
    found: dict[tuple[FieldOrder | None, bool, bool], list[int]] = {}
    for camera, order in zip(cameras, orders, strict=True):
        flagged = capture.interlaced(camera)
        if order in (FieldOrder.TOP_FIRST, FieldOrder.BOTTOM_FIRST) or (order is None and flagged):
            found.setdefault((order, flagged, capture.video(camera) is None), []).append(camera)
    return [_finding(capture, order, flagged, torn) for (order, flagged, _), torn in found.items()]


def _order(capture: Capture, camera: int, changes: PictureChanges) -> FieldOrder | None:
    return field_order(lambda frame: capture.lines(camera, frame), busiest_frames(changes))


def _finding(capture: Capture, order: FieldOrder | None, flagged: bool, cameras: Sequence[int]) -> Finding:
    names = tuple(capture.cameras[camera].name for camera in cameras)
    whole = _FILTER if order is None else f"{_FILTER}:parity={order.value}"
    video = capture.video(cameras[0])
    if video is None:
        cure = f"take them from the video again, whole: ffmpeg -i VIDEO -vf {whole} %06d.png"
        return Finding(False, names, f"the pictures are of interlaced video: {_TORN}", cure)
    cure = f"make whole pictures of its fields: {encode_again(video[0], writing=f'-vf {whole} -c:v libx264 -crf 12')}"
    unsaid = "" if flagged else ", though its file does not say so"
    return Finding(False, names, f"the video is interlaced{unsaid}: {_TORN}", cure)
