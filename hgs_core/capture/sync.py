"""When each camera's frames were taken: sync.json, timestamps.csv, time codes, or the files' own time stamps.

The first of these that there is holds for all cameras. People and tools write `sync.json` into the capture's folder:

    {"seconds": {"cam04": 0.0167}}          when the camera's first frame was taken, on a clock that all share
    {"frames": {"cam04": 0.5}}              the same, in frames of that camera
    {"rate": 25}                            frames per second of pictures in folders, which have no time stamps

`by` and `confidence`, which `hgs sync` adds for people, change nothing. Cameras that are not named began at 0.
`timestamps.csv`, in the capture's folder or beside the footage, has a row
with camera and time for each frame, as caliscope writes it.
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted
from hgs_core.capture.clock import CameraTime
from hgs_core.capture.unreadable import unreadable

__all__ = [
    "SYNC_FILE",
    "TIMESTAMPS_FILE",
    "CameraTimes",
    "OwnTime",
    "Sync",
    "read_sync",
    "table_of_times",
    "timecode_seconds",
    "times_of_cameras",
]

SYNC_FILE, TIMESTAMPS_FILE = "sync.json", "timestamps.csv"
_KEYS = {"seconds", "frames", "rate", "by", "confidence"}
_CAMERA_COLUMNS = ("cam_id", "camera", "cam", "port", "camera_id")
_TIME_COLUMNS = ("frame_time", "time", "timestamp", "timestamp_s", "seconds")
_EDITED = 1e-3  # seconds, in which containers tell where a recording begins
_JITTER = 0.1  # of a period: the clock of the computer that noted a frame's arrival is no better
_TIMECODE = re.compile(r"(\d{1,2}):(\d\d):(\d\d)([:;.])(\d\d)")
_LAST_NUMBER = re.compile(r"(\d+)\D*$")


@dataclass(frozen=True)
class Sync:
    """What sync.json says."""

    file: Path | None = None
    starts: dict[str, float] | None = None  # of the first frames, by camera; None: not said
    in_frames: bool = False  # whether the starts are frames, not seconds
    rate: float | None = None  # frames per second of pictures in folders


def read_sync(capture: Path) -> Sync:
    """Return what sync.json says, if there is one.

    Raises:
        InputError: the file is unreadable, or says something else than the module's description.
    """
    file = capture / SYNC_FILE
    if not file.is_file():
        return Sync()
    cure = 'it is like {"seconds": {"cam04": 0.0167}}, {"frames": {"cam04": 0.5}} or {"rate": 25}'
    try:
        content: Any = json.loads(file.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise unreadable(file, error, cure) from error
    if not isinstance(content, dict) or not content or set(content) - _KEYS:
        raise InputError(file, f"has {list(content) if isinstance(content, dict) else content!r}", cure)
    if "seconds" in content and "frames" in content:
        raise InputError(file, "has both seconds and frames", "give one of them")
    rate = content.get("rate")
    if rate is not None and not (_is_number(rate) and rate > 0):
        raise InputError(file, f"rate is {rate!r}", "it is frames per second")
    unit = next((name for name in ("seconds", "frames") if name in content), None)
    starts = content[unit] if unit else None
    if starts is not None and not isinstance(starts, dict):
        raise InputError(file, f"{unit} is {starts!r}", cure)
    for name, value in (starts or {}).items():
        if not _is_number(value):
            raise InputError(file, f"{unit} of {name} is {value!r}", "it is a number")
    numbers = None if starts is None else {name: float(value) for name, value in starts.items()}
    return Sync(file, numbers, unit == "frames", None if rate is None else float(rate))


@dataclass(frozen=True)
class OwnTime:
    """What the files of one camera say of its frames."""

    name: str
    other_name: str  # of its footage
    stamps: np.ndarray[Any, np.dtype[np.float64]]  # [N] seconds
    rate: float
    resolution: float = 0.0  # seconds
    timecode: str | None = None  # of the first frame
    by: str = "time stamps"  # what says it


@dataclass(frozen=True)
class CameraTimes:
    """The cameras' times on one clock."""

    cameras: list[CameraTime]
    files: list[Path] = field(default_factory=list)  # beside the footage, that they came from
    notes: list[str] = field(default_factory=list)  # what to say
    told: bool = True  # whether anything says when the cameras began; else they are taken to have begun together


def table_of_times(capture: Path, folder: Path | None) -> Path | None:
    """Return timestamps.csv, beside the footage or in the capture's folder, if there is one."""
    return next((f / TIMESTAMPS_FILE for f in (folder, capture) if f and (f / TIMESTAMPS_FILE).is_file()), None)


def times_of_cameras(capture: Path, folder: Path | None, cameras: Sequence[OwnTime], sync: Sync) -> CameraTimes:
    """Return the cameras' times on one clock.

    `folder` is where the footage lies.

    Raises:
        InputError: a file names no camera there is, or does not fit the footage.
    """
    if sync.starts is not None:
        return CameraTimes(_by_sync(cameras, sync), notes=[f"{SYNC_FILE} says when each camera began"])
    table = table_of_times(capture, folder)
    if table is not None:
        notes = [f"{TIMESTAMPS_FILE} says when each frame was taken"]
        return CameraTimes(_by_table(cameras, table), [table], notes)
    if all(camera.timecode for camera in cameras):
        starts = [timecode_seconds(camera.timecode or "", camera.rate) for camera in cameras]
        if None not in starts and max(starts) - min(starts) > 1e-6:  # type: ignore[operator, type-var]
            notes = [f"the videos' time codes say when each camera began ({SYNC_FILE} can say otherwise)"]
            moved = zip(cameras, starts, strict=True)
            times = [_began(c, c.stamps - c.stamps[0] + (s or 0.0), c.resolution) for c, s in moved]
            return CameraTimes(times, notes=notes)
    first = min(float(camera.stamps[0]) for camera in cameras)
    late = [
        f"{camera.name} by {float(camera.stamps[0]) - first:.3f} s"
        for camera in cameras
        if float(camera.stamps[0]) - first > 0.02 / camera.rate + camera.resolution
    ]
    said = f"by their {cameras[0].by} these begin later: {', '.join(late)} ({SYNC_FILE} can say otherwise)"
    tolerance = max(_EDITED, *(camera.resolution for camera in cameras))
    times = [_began(camera, camera.stamps, tolerance) for camera in cameras]
    return CameraTimes(times, notes=[said] if late else [], told=bool(late))


def _by_sync(cameras: Sequence[OwnTime], sync: Sync) -> list[CameraTime]:
    assert sync.starts is not None
    names = {camera.name for camera in cameras} | {camera.other_name for camera in cameras}
    for name in sync.starts:
        if name not in names:
            known = ", ".join(camera.name for camera in cameras)
            raise InputError(sync.file, f"there is no camera {name!r}", f"the cameras are {known}")
    found = []
    for camera in cameras:
        start = sync.starts.get(camera.name, sync.starts.get(camera.other_name, 0.0))
        seconds = start / camera.rate if sync.in_frames else start
        found.append(_began(camera, camera.stamps - camera.stamps[0] + seconds, 0.0))
    return found


def _by_table(cameras: Sequence[OwnTime], table: Path) -> list[CameraTime]:
    times: dict[str, list[float]] = {}
    try:
        with table.open(encoding="utf-8", newline="") as opened:
            rows = csv.DictReader(opened)
            columns = [name.strip() for name in rows.fieldnames or ()]
            rows.fieldnames = columns
            of_camera = next((name for name in _CAMERA_COLUMNS if name in columns), None)
            of_time = next((name for name in _TIME_COLUMNS if name in columns), None)
            if of_camera is None or of_time is None:
                cure = f"it needs a column {_CAMERA_COLUMNS[0]} and a column {_TIME_COLUMNS[0]}, in seconds"
                raise InputError(table, f"the columns are {', '.join(columns) or 'none'}", cure)
            for number, row in enumerate(rows):
                seconds = float(row[of_time])
                if not math.isfinite(seconds):
                    raise InputError(f"{table}, row {number + 1}", f"{of_time} is {row[of_time]}", "give seconds")
                times.setdefault((row[of_camera] or "").strip(), []).append(seconds)
    except (OSError, UnicodeDecodeError, csv.Error, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise unreadable(table, error, "remove it to go by the videos' own time stamps") from error
    numbers = {_number(name): name for name in times}
    found = []
    for camera in cameras:
        names = camera.name, camera.other_name
        keys = (*names, *(numbers.get(_number(name)) for name in names))
        key = next((key for key in keys if key in times), None)
        rows_there = len(times[key]) if key is not None else 0
        if key is None or rows_there != len(camera.stamps):
            frames = counted(len(camera.stamps), "frame")
            problem = f"has {counted(rows_there, 'row')} of camera {camera.name}, whose footage has {frames}"
            raise InputError(table, problem, "restore it, or remove it to go by the videos' own time stamps")
        stamps = np.array(times[key])
        rate = camera.rate if len(stamps) < 2 else 1.0 / float(np.median(np.diff(stamps)))
        near = camera.rate if abs(rate / camera.rate - 1) < 0.05 else rate  # arrivals jitter, and videos may lie
        found.append(CameraTime(camera.name, stamps, near, _JITTER / near))
    return found


def timecode_seconds(code: str, rate: float) -> float | None:
    """Return the seconds of a SMPTE time code, drop-frame ones with a semicolon; None if it is none."""
    parts = _TIMECODE.fullmatch(code.strip())
    if parts is None:
        return None
    hours, minutes, seconds, frame = int(parts[1]), int(parts[2]), int(parts[3]), int(parts[5])
    nominal = max(1, round(rate))
    total = ((hours * 60 + minutes) * 60 + seconds) * nominal + frame
    if parts[4] in ";.":  # two numbers a minute (four at 60) are skipped, but not every tenth minute
        whole = hours * 60 + minutes
        total -= nominal // 15 * (whole - whole // 10)
    exact = Fraction(nominal * 1000, 1001) if abs(rate - nominal / 1.001) < abs(rate - nominal) else Fraction(nominal)
    return float(total / exact)


def _began(camera: OwnTime, stamps: np.ndarray[Any, np.dtype[np.float64]], tolerance: float) -> CameraTime:
    return CameraTime(camera.name, stamps, camera.rate, tolerance)


def _number(name: str) -> int | None:
    found = _LAST_NUMBER.search(name)
    return int(found[1]) if found else None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
