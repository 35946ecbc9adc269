"""Findings about pictures, frame rates and the number of cameras."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from fractions import Fraction
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted
from hgs_core.capture.footage import find_places
from hgs_core.capture.pictures.announced_length import AnnouncedLength, announced_length
from hgs_core.check.evidence import CameraEvidence
from hgs_core.check.findings import Finding
from hgs_core.points.far_apart import stand_far_apart
from hgs_core.scene.camera import Camera

__all__ = ["judge_number", "judge_pictures", "judge_rates"]

_FLAT = 0.96  # share of pixels; an object before a plain background leaves more
_FEW_CAMERAS = 4
_UNEVEN_FRAMES = 2.0  # frames by which the ends of a video with uneven frames lie anywhere


def judge_pictures(names: Sequence[str], views: Sequence[CameraEvidence], blank: Collection[str] = ()) -> list[Finding]:
    """Find pictures that show nothing; the cameras that are `blank` are reported already."""
    findings = []
    flat = [i for i, view in enumerate(views) if view.level[1] > _FLAT and names[i] not in blank]
    for level in sorted({views[i].level[0] for i in flat}):
        cameras = [names[i] for i in flat if views[i].level[0] == level]
        share = min(views[i].level[1] for i in flat if views[i].level[0] == level)
        problem = f"{share:.0%} of the first picture is nothing but the level {level}"
        cure = "store 8 bits per channel" if level in (0, 255) else "look at the files"
        findings.append(Finding(len(flat) == len(views), tuple(cameras), problem, cure))
    return findings


def judge_number(cameras: Sequence[Camera]) -> list[Finding]:
    """Find that cameras are few; those all around a subject show it whole, which others do not."""
    if len(cameras) >= _FEW_CAMERAS:
        return []
    count = counted(len(cameras), "camera")
    if stand_far_apart(cameras):
        problem = f"{count} all around: what moves looks right from anywhere, the room only near where they stand"
        return [Finding(False, (), problem, "add cameras in between for the room")]
    problem = f"{count}: a scene looks right only near where they stand"
    return [Finding(False, (), problem, f"record with {_FEW_CAMERAS} or more")]


def judge_rates(path: Path, names: Sequence[str]) -> list[Finding]:
    """Find videos, called as their cameras, that run at another rate than the others.

    A mean rate of uneven frames is one only if the video ends frames apart: phones drop frames and wait for light.
    """
    rates: dict[str, Fraction] = {}
    lengths: dict[str, AnnouncedLength] = {}
    wanted = set(names)
    videos = [one for place in find_places(path) if place.kind == "videos" for one in place.footage]
    for video in videos:
        if video.name in wanted:
            try:
                length = announced_length(video.files[0])
            except InputError:
                continue  # opening the capture says so where it matters
            if length.rate is not None:
                rates.setdefault(video.name, Fraction(length.rate).limit_denominator(100_000))
                lengths.setdefault(video.name, length)
    if not rates:
        return []
    even = [rate for name, rate in rates.items() if lengths[name].even]
    usual = Counter(even or rates.values()).most_common(1)[0][0]
    odd = {name: rate for name, rate in rates.items() if rate != usual and _differs(lengths[name], float(usual))}
    findings = []
    for other in sorted(set(odd.values())):
        cameras = tuple(name for name, one in odd.items() if one == other)
        seconds = 1 / abs(float(other - usual))
        problem = (
            f"{float(other):.5g} frames per second, the others {float(usual):.5g}: a frame apart after {seconds:.0f} s"
        )
        findings.append(Finding(False, cameras, problem, "frames are matched by time stamps: are these right?"))
    return findings


def _differs(length: AnnouncedLength, usual: float) -> bool:
    """Return whether the rate of a video, which has another, is not the usual one with uneven frames."""
    if length.even or length.rate is None or length.frames is None:
        return True
    return length.frames * abs(1 - usual / length.rate) > _UNEVEN_FRAMES
