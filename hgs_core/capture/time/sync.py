"""When each camera's frames were taken: sync.json, timestamps.csv, time codes, or the files' own time stamps.

The first of these that there is holds for all cameras. People and tools write `sync.json` into the capture's folder:

    {"seconds": {"cam04": 0.0167}}          when the camera's first frame was taken, on a clock that all share
    {"frames": {"cam04": 0.5}}              the same, in frames of that camera
    {"rate": 25}                            frames per second of pictures in folders, which have no time stamps

`by` and `confidence`, which `hgs sync` adds for people, change nothing. Cameras that are not named began at 0.
`timestamps.csv`, in the capture's folder or beside the footage, has a row with camera and time for each frame.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted, shown
from hgs_core.capture.files.named_files import plain_name
from hgs_core.capture.files.text_file import read_json
from hgs_core.capture.time.clock import CameraTime, mean_rate
from hgs_core.capture.time.timecodes import CodedStart, starts_by_timecode
from hgs_core.capture.time.times_table import CURE, read_times_table, unit_of_table

__all__ = [
    "SYNC_FILE",
    "TIMESTAMPS_FILE",
    "CameraTimes",
    "OwnTime",
    "Sync",
    "read_sync",
    "table_of_times",
    "times_of_cameras",
]

SYNC_FILE, TIMESTAMPS_FILE = "sync.json", "timestamps.csv"
_KEYS = {"seconds", "frames", "rate", "by", "confidence"}
_EDITED = 1e-3  # seconds, in which containers tell where a recording begins
_LARGEST = 1e12  # seconds or frames, 30,000 years
_JITTER = 0.1  # share of a period: the precision of a computer's arrival times
_SLOWEST, _FASTEST = 1e-3, 1e6  # frames per second
_MOST_DIGITS = 18  # digits of a number in a name
_LAST_NUMBER = re.compile(r"(\d+)\D*$")


@dataclass(frozen=True)
class Sync:
    """The contents of sync.json."""

    file: Path | None = None
    starts: dict[str, float] | None = None  # camera -> second of its first frame; None: not given
    in_frames: bool = False  # whether the starts are frames, not seconds
    rate: float | None = None  # frames per second of pictures in folders


def read_sync(capture: Path) -> Sync:
    """Return the contents of sync.json, if there is one.

    Raises:
        InputError: the file is unreadable, or says something else than the module's description.
    """
    file = capture / SYNC_FILE
    if not file.is_file():
        return Sync()
    cure = 'it is like {"seconds": {"cam04": 0.0167}}, {"frames": {"cam04": 0.5}} or {"rate": 25}'
    content: Any = read_json(file, cure)
    if not isinstance(content, dict) or not content or set(content) - _KEYS:
        raise InputError(file, f"has {shown(list(content) if isinstance(content, dict) else content)}", cure)
    if "seconds" in content and "frames" in content:
        raise InputError(file, "has both seconds and frames", "give one of them")
    rate = content.get("rate")
    if rate is not None and not (_is_number(rate) and _SLOWEST <= rate <= _FASTEST):
        raise InputError(file, f"rate is {shown(rate)}", f"it is frames per second, from {_SLOWEST:g} to {_FASTEST:g}")
    unit = next((name for name in ("seconds", "frames") if name in content), None)
    starts = content[unit] if unit else None
    if starts is not None and not isinstance(starts, dict):
        raise InputError(file, f"{unit} is {shown(starts)}", cure)
    for name, value in (starts or {}).items():
        if not _is_number(value):
            raise InputError(file, f"{unit} of {name} is {shown(value)}", "it is a number")
    numbers = None if starts is None else {name: float(value) for name, value in starts.items()}
    return Sync(file, numbers, unit == "frames", None if rate is None else float(rate))


@dataclass(frozen=True)
class OwnTime:
    """The times of one camera's frames, from its files."""

    name: str
    other_name: str  # name of its footage
    stamps: np.ndarray[Any, np.dtype[np.float64]]  # [N] seconds
    rate: float
    resolution: float = 0.0  # seconds
    timecode: str | None = None  # time code of the first frame
    by: str = "time stamps"  # source of the times


@dataclass(frozen=True)
class CameraTimes:
    """The cameras' times on one clock."""

    cameras: list[CameraTime]
    files: list[Path] = field(default_factory=list)  # sources beside the footage
    notes: list[str] = field(default_factory=list)  # notes for people
    told: bool = True  # whether anything says when the cameras began; else they are taken to have begun together


def table_of_times(capture: Path, folder: Path | None) -> Path | None:
    """Return timestamps.csv, beside the footage or in the capture's folder, if there is one."""
    return next((f / TIMESTAMPS_FILE for f in (folder, capture) if f and (f / TIMESTAMPS_FILE).is_file()), None)


def times_of_cameras(
    capture: Path, folder: Path | None, cameras: Sequence[OwnTime], sync: Sync, *, assumed: bool = False
) -> CameraTimes:
    """Return the cameras' times on one clock.

    `folder` is where the footage lies; `assumed` says whether nothing states the rate of its pictures.

    Raises:
        InputError: a file names no camera there is, or does not fit the footage.
    """
    if sync.starts is not None:
        return CameraTimes(_by_sync(cameras, sync), notes=[f"{SYNC_FILE} says when each camera began"])
    table = table_of_times(capture, folder)
    if table is not None:
        times, notes = _by_table(cameras, table, assumed)
        return CameraTimes(times, [table], notes)
    coded = [CodedStart(c.name, c.timecode, c.rate, float(c.stamps[-1] - c.stamps[0])) for c in cameras if c.timecode]
    notes = []
    if len(coded) == len(cameras):
        starts = starts_by_timecode(coded)
        if starts.problem:
            zeros = ", ".join(f'"{camera.name}": 0' for camera in cameras[:2])
            cure = f'say in {SYNC_FILE} when each began, {{"seconds": {{{zeros}, ...}}}}; cameras not named began at 0'
            raise InputError(capture, starts.problem, cure)
        if starts.seconds:
            said = f"the videos' time codes say when each camera began ({SYNC_FILE} can say otherwise)"
            moved = zip(cameras, starts.seconds, strict=True)
            times = [_began(c, c.stamps - c.stamps[0] + start, c.resolution) for c, start in moved]
            return CameraTimes(times, notes=[said, *starts.notes])
    elif coded:
        without = ", ".join(camera.name for camera in cameras if not camera.timecode)
        notes = [f"the time codes of {coded[0].name} and others are not used: {without} has none"]
    first = min(float(camera.stamps[0]) for camera in cameras)
    late = [
        f"{camera.name} by {float(camera.stamps[0]) - first:.3f} s"
        for camera in cameras
        if float(camera.stamps[0]) - first > 0.02 / camera.rate + camera.resolution
    ]
    said = f"by their {cameras[0].by} these begin later: {', '.join(late)} ({SYNC_FILE} can say otherwise)"
    tolerance = max(_EDITED, *(camera.resolution for camera in cameras))
    times = [_began(camera, camera.stamps, tolerance) for camera in cameras]
    return CameraTimes(times, notes=[*notes, *([said] if late else [])], told=bool(late))


def _by_sync(cameras: Sequence[OwnTime], sync: Sync) -> list[CameraTime]:
    assert sync.starts is not None
    names = {plain_name(name) for camera in cameras for name in (camera.name, camera.other_name)}
    for name in sync.starts:
        if plain_name(name) not in names:
            known = ", ".join(camera.name for camera in cameras)
            raise InputError(sync.file, f"there is no camera {name!r}", f"the cameras are {known}")
    starts = {plain_name(name): start for name, start in sync.starts.items()} | sync.starts
    found = []
    for camera in cameras:
        called = (camera.name, camera.other_name, plain_name(camera.name), plain_name(camera.other_name))
        start = next((starts[name] for name in called if name in starts), 0.0)
        seconds = start / camera.rate if sync.in_frames else start
        found.append(_began(camera, camera.stamps - camera.stamps[0] + seconds, 0.0))
    _require_overlap(found, sync)
    return found


def _require_overlap(cameras: Sequence[CameraTime], sync: Sync) -> None:
    """Refuse starts that leave no moment to all cameras; says where milliseconds would."""
    last = max(cameras, key=lambda camera: float(camera.stamps[0]))
    first = min(cameras, key=lambda camera: float(camera.stamps[-1]))
    begins, ends = float(last.stamps[0]), float(first.stamps[-1])
    if begins <= ends:
        return
    problem = f"by it {last.name} begins at {begins:.6g} s, and {first.name} ends at {ends:.6g} s: no moment in common"
    cure = "correct the number, or remove the file to go by the footage alone"
    begun = min(float(camera.stamps[0]) for camera in cameras)
    shortest = min(float(camera.stamps[-1] - camera.stamps[0]) for camera in cameras)
    if not sync.in_frames and (begins - begun) / 1000 <= shortest:
        cure = f"where they are milliseconds, divide by 1000, as in {(begins - begun) / 1000:.6g}; or {cure}"
    raise InputError(sync.file, problem, cure)


def _by_table(cameras: Sequence[OwnTime], table: Path, assumed: bool) -> tuple[list[CameraTime], list[str]]:
    """Return the cameras' times, and notes on them."""
    read = read_times_table(table)
    times = read.times
    numbers = {_number(name): name for name in times}
    keys: dict[str, str] = {}
    for camera in cameras:
        names = camera.name, camera.other_name
        known = (*names, *(numbers.get(_number(name)) for name in names))
        key = next((key for key in known if key in times), None)
        rows_there = len(times[key]) if key is not None else 0
        if key is None or rows_there != len(camera.stamps):
            frames = counted(len(camera.stamps), "frame")
            problem = f"has {counted(rows_there, 'row')} of camera {camera.name}, whose footage has {frames}"
            raise InputError(table, problem, CURE)
        keys[camera.name] = key
    steps = {keys[camera.name]: 1.0 / camera.rate for camera in cameras}
    unit, note = unit_of_table(table, read, steps, assumed=assumed)
    first = min(float(times[key][0]) for key in keys.values())
    found = []
    for camera in cameras:
        stamps = (times[keys[camera.name]] - first) / unit.per_second
        rate = camera.rate if len(stamps) < 2 else mean_rate(stamps)
        near = camera.rate if abs(rate / camera.rate - 1) < 0.05 else rate  # arrivals jitter, and videos may lie
        found.append(CameraTime(camera.name, stamps, near, _JITTER / near))
    return found, [f"{TIMESTAMPS_FILE} says when each frame was taken", *([note] if note else [])]


def _began(camera: OwnTime, stamps: np.ndarray[Any, np.dtype[np.float64]], tolerance: float) -> CameraTime:
    return CameraTime(camera.name, stamps, camera.rate, tolerance)


def _number(name: str) -> int | None:
    found = _LAST_NUMBER.search(name)
    return int(found[1]) if found and len(found[1]) <= _MOST_DIGITS else None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _LARGEST
