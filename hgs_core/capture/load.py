"""From a folder to a recording: any reader of cameras with any reader of pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.corrected_poses import with_corrections
from hgs_core.capture.cameras.rig import CameraFormat, Rig
from hgs_core.capture.cameras.rigid_poses import with_rigid_poses
from hgs_core.capture.footage import Footage
from hgs_core.capture.footage_of_cameras import Matched, match_footage
from hgs_core.capture.lenses.straighten import StraightView
from hgs_core.capture.pictures.announced_length import announced_length
from hgs_core.capture.pictures.as_calibrated import show_as_calibrated
from hgs_core.capture.pictures.depth_files import DepthFiles, find_depth
from hgs_core.capture.pictures.depth_scale import DEPTH_FILE
from hgs_core.capture.pictures.mask_files import find_masks
from hgs_core.capture.pictures.picture_numbers import PictureNumbers, picture_numbers
from hgs_core.capture.pictures.picture_sequence import PictureSequence
from hgs_core.capture.pictures.video import VideoReader
from hgs_core.capture.recording import Recording
from hgs_core.capture.time.clock import Clock, common_clock, mean_rate
from hgs_core.capture.time.sync import CameraTimes, OwnTime, Sync, read_sync, table_of_times, times_of_cameras

__all__ = ["Outline", "clock_of_videos", "load", "outline"]

_LARGE = 3.0  # times the pixels of most cameras, from which on a camera is worth a word
_ASSUMED_RATE = 30.0  # frames per second of pictures in folders, where nothing says it
_MASK_FOLDERS = ("masks", "mask", "seg")
_DEPTH_FOLDER = "depth"
_MESHES = ("mesh.ply", "mesh.obj", "mesh.glb")


@dataclass(frozen=True)
class Outline:
    """An outline of a capture, without decoded pictures and without the checks of `load`."""

    cameras: tuple[str, ...]  # their names, in the order of the capture
    firsts: tuple[Path, ...]  # each camera's video, or its first picture
    frames: int | None = None  # None: not told without reading more
    seconds: float | None = None  # duration of the frames, if known


def load(
    capture: Path,
    camera_format: CameraFormat,
    file: Path,
    masks: Path | None,
    found: Path | None = None,
    index: Path | None = None,
    *,
    depth: Path | None = None,
    mesh: Path | None = None,
) -> Recording:
    """Read a capture with cameras of one format; `masks`, `depth` and `mesh` replace its own.

    `found` is a folder with a sync.json that counts where the capture has none, `index` one that keeps the time stamps
    of videos.

    Raises:
        InputError: a file is missing, unreadable, damaged or inconsistent. Damage inside a video or in later pictures
            shows at first use.
    """
    rig = with_rigid_poses(camera_format.read(capture, file))
    matched = match_footage(capture, rig)
    rig = with_corrections(capture, rig, matched.names)
    readers = [_reader(name, one, index) for name, one in zip(matched.names, matched.footage, strict=True)]
    shapes = show_as_calibrated(rig.cameras, matched.names, readers)
    views = [
        StraightView.of(calibrated.camera(name, reader.width, reader.height), calibrated.lens)
        for calibrated, name, reader in zip(rig.cameras, matched.names, readers, strict=True)
    ]
    sync = read_sync(capture)
    if found is not None and sync.file is None:
        sync = read_sync(found)
    numbers, said = _numbers(capture, rig, matched, sync)
    clock, times = _clock(capture, rig, matched, readers, sync, numbers)
    pictures = [None if one.video else [path.stem for path in one.files] for one in matched.footage]
    given = find_masks(
        [masks] if masks else [capture / name for name in _MASK_FOLDERS],
        views,
        [one.name for one in matched.footage],
        pictures,
        clock.frames.tolist(),
        numbers=None if numbers is None else numbers.numbers,
        required=masks is not None,
    )
    maps: DepthFiles | None = None
    if depth is not None or (capture / _DEPTH_FOLDER / DEPTH_FILE).exists():
        footage = [one.name for one in matched.footage]
        own = None if numbers is None else numbers.numbers
        maps = find_depth(depth or capture / _DEPTH_FOLDER, views, footage, pictures, clock.frames.tolist(), own)
    return Recording(
        capture,
        views,
        readers,
        clock,
        given,
        [pair for reader in readers for pair in reader.files],
        [*rig.files, *times.files, *([sync.file] if sync.file else [])],
        (*rig.notes, *matched.notes, *shapes, *_of_pictures(matched.names, readers), *times.notes, *said, *clock.notes),
        () if times.told else tuple(one.files[0] for one in matched.footage if one.video),
        matched.left_out,
        rig.mirrored,
        maps,
        mesh or next((capture / name for name in _MESHES if (capture / name).is_file()), None),
    )


def clock_of_videos(
    folder: Path, names: Sequence[str], videos: Sequence[VideoReader], found: Path | None = None
) -> tuple[Clock, bool]:
    """Return the clock of videos without poses, and whether anything says when they began.

    Raises:
        InputError: what says it is damaged, or they have no moment in common.
    """
    sync = read_sync(folder)
    if found is not None and sync.file is None:
        sync = read_sync(found)
    own = [_own_time(name, video.path.stem, video) for name, video in zip(names, videos, strict=True)]
    times = times_of_cameras(folder, videos[0].path.parent, own, sync)
    return common_clock(folder, times.cameras), times.told


def outline(capture: Path, camera_format: CameraFormat, file: Path) -> Outline:
    """Return the cameras and the length of a capture, as far as its lists and its first video's header say.

    Raises:
        InputError: as `load`, as far as that is read.
    """
    rig = with_rigid_poses(camera_format.read(capture, file))
    matched = match_footage(capture, rig)
    first, firsts = matched.footage[0], tuple(one.files[0] for one in matched.footage)
    if matched.kind == "photographs":
        return Outline(matched.names, firsts, 1, 0.0)
    if first.video:
        length = announced_length(first.files[0])
        return Outline(matched.names, firsts, length.frames, length.seconds)
    rate = read_sync(capture).rate or rig.rate or _ASSUMED_RATE
    return Outline(matched.names, firsts, len(first.files), len(first.files) / rate)


def _reader(name: str, footage: Footage, index: Path | None) -> VideoReader | PictureSequence:
    return VideoReader(footage.files[0], index=index) if footage.video else PictureSequence(name, footage.files)


def _numbers(capture: Path, rig: Rig, matched: Matched, sync: Sync) -> tuple[PictureNumbers | None, list[str]]:
    """Return the moments of pictures in folders, from their numbers, with notes; None: other sources tell."""
    if matched.kind == "photographs" or any(one.video for one in matched.footage):
        return None, []
    files = [one.files for one in matched.footage]
    stamps = [camera.stamps for camera in rig.cameras]
    stamped = all(len(own) == len(there) for own, there in zip(stamps, files, strict=True))
    told = stamped or sync.starts is not None or table_of_times(capture, matched.folder) is not None
    numbers = picture_numbers(matched.folder or capture, matched.names, files, in_order=told)
    if stamped:
        return None, numbers.contradictions(rig.files[0].name, stamps)
    if not told:
        numbers.require_shared(matched.folder or capture)
    return numbers, numbers.notes()


def _clock(
    capture: Path,
    rig: Rig,
    matched: Matched,
    readers: Sequence[VideoReader | PictureSequence],
    sync: Sync,
    numbers: PictureNumbers | None,
) -> tuple[Clock, CameraTimes]:
    """Return the clock and its sources."""
    if matched.kind == "photographs":
        count = len(readers)
        one = Clock(np.zeros(1), np.zeros((count, 1), np.int64), np.zeros((count, 1)))
        return one, CameraTimes([])
    rate, assumed = sync.rate or rig.rate or _ASSUMED_RATE, False
    if numbers is not None:
        assumed = sync.rate is None and rig.rate is None and numbers.unit is None
        rate = numbers.rate(rate)
    seconds = None if numbers is None else numbers.seconds(rate)
    own = []
    for index, (calibrated, reader) in enumerate(zip(rig.cameras, readers, strict=True)):
        name, other = matched.names[index], matched.footage[index].name
        if isinstance(reader, VideoReader):
            own.append(_own_time(name, other, reader))
        elif numbers is not None and seconds is not None:
            by = "pictures' numbers"
            own.append(OwnTime(name, other, seconds[index], rate, numbers.unit or 0.0, by=by))
        elif rig.stamps_in_seconds and len(calibrated.stamps) == len(reader) > 1:
            stamps = np.array(calibrated.stamps)
            own.append(OwnTime(name, other, stamps, mean_rate(stamps)))
        else:
            places = calibrated.stamps if len(calibrated.stamps) == len(reader) else range(len(reader))
            own.append(OwnTime(name, other, np.array(places, np.float64) / rate, rate))
            assumed |= sync.rate is None and rig.rate is None
    found = times_of_cameras(capture, matched.folder, own, sync, assumed=assumed)
    if assumed and not found.files:
        found.notes.append(f'{rate:g} pictures per second are assumed; {{"rate": ...}} in sync.json says otherwise')
    clock = common_clock(capture, found.cameras)
    if len(clock.times) == 1 and matched.kind == "videos" and max(len(reader) for reader in readers) == 1:
        first = matched.footage[0].files[0].name
        cure = f"give pictures of a scene that stands still: ffmpeg -i {first} {matched.footage[0].name}.png"
        raise InputError(capture, "each video has one frame, and nothing moves", f"{cure}, and take the videos away")
    if len(clock.times) == 1 and max(len(reader) for reader in readers) > 1:
        raise InputError(capture, "only one moment is seen by all cameras", "check their time stamps, or sync.json")
    return clock, found


def _of_pictures(names: Sequence[str], readers: Sequence[VideoReader | PictureSequence]) -> list[str]:
    """Return notes on converted colours, and on pictures far larger than the others'."""
    notes, wide = [], dict[str, list[str]]()
    for name, reader in zip(names, readers, strict=True):
        if isinstance(reader, VideoReader) and reader.wide_colours is not None:
            wide.setdefault(reader.wide_colours.name, []).append(name)
    chosen = dict[str, list[str]]()
    for name, reader in zip(names, readers, strict=True):
        for note in reader.notes:
            chosen.setdefault(note, []).append(name)
    notes += [f"{', '.join(cameras)}: {note}" for note, cameras in chosen.items()]
    for what, cameras in wide.items():
        notes.append(f"{what} of {', '.join(cameras)} is shown as on an ordinary screen, in BT.709's colours")
    pixels = np.array([reader.width * reader.height for reader in readers])
    usual = float(np.median(pixels))
    for name, reader, own in zip(names, readers, pixels, strict=True):
        if own > _LARGE * usual:
            notes.append(
                f"pictures of {name} have {reader.width}x{reader.height} pixels, {own / usual:.0f} times as many as"
                f" most: its steps take as much longer; --downscale {name}={round(math.sqrt(own / usual))} makes them"
                " alike"
            )
    return notes


def _own_time(name: str, other_name: str, video: VideoReader) -> OwnTime:
    return OwnTime(name, other_name, video.seconds, video.frame_rate, video.resolution, video.timecode)
