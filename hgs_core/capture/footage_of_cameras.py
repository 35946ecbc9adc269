"""The footage of each camera, matched by name.

A camera's pictures are called like it, in capital letters or small; or else the last numbers of their names agree:
cam_1 and camera_0001. Cameras without names (poses_bounds.npy) take footage in its order. Of several places the best
one is taken: videos before folders of pictures, these before photographs, equal names before equal numbers, the nearest
to the capture's folder first.
"""

from __future__ import annotations

import dataclasses
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted, shown
from hgs_core.capture.cameras.rig import CalibratedCamera, Rig
from hgs_core.capture.files.named_files import plain_name
from hgs_core.capture.footage import Footage, Kind, Place, find_places, is_video
from hgs_core.capture.sound.sound_only import is_sound_only

__all__ = ["Matched", "match_footage"]

_KINDS: tuple[Kind, ...] = ("videos", "folders", "moments", "photographs")
_LIKELY = ("images", "videos", "recordings", "ims", "frames", "rgb")  # folders, where two are otherwise alike
_NAME, _NUMBER, _ORDER = range(3)  # kinds of match, the surest first
_LAST_NUMBER = re.compile(r"(\d+)\D*$")
_LONGEST_NAME = 255  # characters
_MOST_DIGITS = 18  # digits of a number in a name
_MOST_NAMED = 12  # cameras or videos that a message lists


@dataclass(frozen=True)
class Matched:
    """The footage of each camera of a rig."""

    names: tuple[str, ...]  # camera names
    footage: tuple[Footage, ...]
    kind: Kind
    folder: Path | None = None  # place of discovery; None: named by the cameras' file
    notes: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()  # footage that lies beside it and is of no camera


def match_footage(capture: Path, rig: Rig) -> Matched:
    """Return the footage that the cameras' file names, or else the footage below the capture.

    Raises:
        InputError: there is no footage, or none that has a picture for every camera, or two places with equal right.
    """
    places = find_places(capture)
    if (own := _named(rig)) is not None:
        return _with_left_out(own, capture, _place_of(places, own))
    if not places:
        what = f"there are cameras ({_file(rig.files[0], capture)}) but no videos and no folders of pictures"
        raise InputError(capture, what, "put each camera's video beside them, called like the camera")
    found = [(rank, place, match) for place in places for rank, match in _matches(capture, rig.cameras, place)]
    if not found:
        raise _nothing_fits(capture, rig, places)
    best, place, match = min(found, key=lambda item: item[0])
    for name in match.names:
        parts = PurePosixPath(name)
        if not name or len(name) > _LONGEST_NAME or parts.is_absolute() or ".." in parts.parts:
            raise InputError(rig.files[0], f"a camera is called {shown(name)}", "give it a name that a file could have")
    for rank, other, equal in found:
        if rank == best and equal.footage != match.footage:
            if other.folder == place.folder:
                problem = f"{_shown(place.folder, capture)} has as many folders as cameras, each with as many pictures"
                cure = "its folders may be cameras or moments: give cameras with names, by COLMAP, say"
                raise InputError(capture, problem, cure)
            both = f"{_shown(place.folder, capture)} and {_shown(other.folder, capture)}"
            raise InputError(capture, f"{both} both hold the cameras' pictures", "keep one of them there")
    found_here = Matched(match.names, match.footage, place.kind, place.folder, match.notes)
    return _with_left_out(found_here, capture, place)


def _place_of(places: Sequence[Place], own: Matched) -> Place | None:
    """Return the place with most of the cameras' footage: of equals the deepest."""
    used = {file for one in own.footage for file in one.files}
    shares = [sum(not used.isdisjoint(one.files) for one in place.footage) for place in places]
    ranked = [(share, len(p.folder.parts), p) for share, p in zip(shares, places, strict=True) if p.kind == own.kind]
    share, _, place = max(ranked, key=lambda one: one[:2], default=(0, 0, None))
    return place if share else None


def _with_left_out(own: Matched, capture: Path, place: Place | None) -> Matched:
    """Return it with the other footage in its place, and a note on that."""
    if place is None:
        return own
    used = {file for one in own.footage for file in one.files}
    spare = [one for one in place.footage if used.isdisjoint(one.files)]
    silent = [one.name for one in spare if one.video and is_sound_only(one.files[0])]
    left_out = [one.name for one in spare if one.name not in silent]
    notes, where = list(own.notes), _shown(place.folder, capture)
    if silent:
        notes.append(f"{_listed(silent)} in {where} is sound without pictures and left aside")
    if left_out:
        notes.append(f"{_listed(left_out)} in {where} is of no camera and left out")
    return dataclasses.replace(own, notes=tuple(notes), left_out=tuple(left_out))


def _named(rig: Rig) -> Matched | None:
    """Return the footage that the cameras' file names, unless it names none or none of it is there."""
    files = [file for camera in rig.cameras for file in camera.pictures]
    if not all(camera.pictures for camera in rig.cameras) or not any(file.is_file() for file in files):
        return None
    footage = tuple(
        Footage(camera.names[0], camera.pictures, is_video(camera.pictures[0].name)) for camera in rig.cameras
    )
    single = all(len(one.files) == 1 and not one.video for one in footage)
    kind: Kind = "videos" if footage[0].video else "photographs" if single else "folders"
    return Matched(tuple(camera.names[0] for camera in rig.cameras), footage, kind)


def _matches(capture: Path, cameras: Sequence[CalibratedCamera], place: Place) -> list[tuple[tuple[int, ...], Matched]]:
    """Return how the place's footage fits all cameras, with its rank: the lowest is the best."""
    found = _by_name(capture, cameras, place) or _by_number(cameras, place) or _by_order(cameras, place)
    if found is None:
        return []
    quality, names, footage = found
    depth = len(place.folder.relative_to(capture).parts)
    name = place.folder.name.lower() if depth else _LIKELY[0]
    likely = _LIKELY.index(name) if name in _LIKELY else len(_LIKELY)
    # Without names nothing tells a folder for each camera from one for each moment.
    kind = "folders" if quality == _ORDER and place.kind == "moments" else place.kind
    rank = (int(place.kind == "photographs"), quality, _KINDS.index(kind), depth, likely)
    return [(rank, Matched(names, footage, place.kind))]


_Found = tuple[int, tuple[str, ...], tuple[Footage, ...]]


def _by_name(capture: Path, cameras: Sequence[CalibratedCamera], place: Place) -> _Found | None:
    footage = {plain_name(one.name): one for one in place.footage}
    if len(footage) < len(place.footage):
        return None
    for names in _levels(cameras):
        if all(plain_name(name) in footage for name in names):
            if place.kind in ("moments", "photographs") and _are_cameras(capture, place, names):
                return None
            return _NAME, names, tuple(footage[plain_name(name)] for name in names)
    return None


def _by_number(cameras: Sequence[CalibratedCamera], place: Place) -> _Found | None:
    """Match the last numbers of the names; not those of single picture files, which may mean frames."""
    if place.kind in ("moments", "photographs"):
        return None
    footage = {_number(one.name): one for one in place.footage}
    if len(footage) < len(place.footage):
        return None
    for names in _levels(cameras):
        numbers = [_number(name) for name in names]
        if len(set(numbers)) == len(numbers) and all(n is not None and n in footage for n in numbers):
            return _NUMBER, names, tuple(footage[number] for number in numbers)
    return None


def _by_order(cameras: Sequence[CalibratedCamera], place: Place) -> _Found | None:
    """Give nameless cameras the footage in order: all of it, or all that is called alike but for numbers."""
    if any(camera.names for camera in cameras):
        return None
    alike: dict[str, list[Footage]] = {}
    for one in place.footage:
        alike.setdefault(re.sub(r"\d+", "#", one.name.casefold()), []).append(one)
    for group in (list(place.footage), *alike.values()):
        if len(group) == len(cameras):
            return _ORDER, tuple(one.name for one in group), tuple(group)
    return None


def _levels(cameras: Sequence[CalibratedCamera]) -> list[tuple[str, ...]]:
    """Return lists of names, one for each camera, that tell them apart: the likeliest list first."""
    if not all(camera.names for camera in cameras):
        return []
    most = max(len(camera.names) for camera in cameras)
    lists = (tuple(camera.names[min(level, len(camera.names) - 1)] for camera in cameras) for level in range(most))
    return [names for names in lists if len({plain_name(name) for name in names}) == len(names)]


def _are_cameras(capture: Path, place: Place, names: Sequence[str]) -> bool:
    """Whether the pictures lie in folders that are called like cameras: then each is a frame, not a camera."""
    wanted = {plain_name(name) for name in names}
    folders = {plain_name(part) for file in place.footage[0].files for part in file.relative_to(capture).parts[:-1]}
    return bool(folders & wanted)


def _number(name: str) -> int | None:
    found = _LAST_NUMBER.search(name)
    return int(found[1]) if found and len(found[1]) <= _MOST_DIGITS else None


def _nothing_fits(capture: Path, rig: Rig, places: Sequence[Place]) -> InputError:
    """Return the error that lists both sides: the cameras, and the footage that comes nearest."""
    file = _file(rig.files[0], capture)
    if not all(camera.names for camera in rig.cameras):
        nearest = min(places, key=lambda p: (p.kind == "photographs", abs(len(p.footage) - len(rig.cameras))))
        what = {"videos": "video", "folders": "folder of pictures"}.get(nearest.kind, "picture")
        there = counted(len(nearest.footage), what, "folders of pictures" if nearest.kind == "folders" else "")
        problem = f"{counted(len(rig.cameras), 'pose')} for {there} ({_listed([f.name for f in nearest.footage])})"
        return InputError(capture / file, problem, "every camera needs one row, in the order of the names")
    wanted = {name.casefold(): name for camera in rig.cameras for name in camera.names[-1:]}

    def shared(place: Place) -> int:
        return len({one.name.casefold() for one in place.footage} & set(wanted))

    if (chapters := _chapters(capture, places, set(wanted))) is not None:
        return chapters
    likely = [place for place in places if place.kind in ("videos", "folders")] or places
    nearest = max(likely, key=lambda place: (shared(place), -_KINDS.index(place.kind)))
    listed = {one.name.casefold(): one.name for one in nearest.footage}
    twice = [one.name for one in nearest.footage if listed[one.name.casefold()] != one.name] or [
        name for name in listed.values() if sum(one.name == name for one in nearest.footage) > 1
    ]
    if twice:
        return InputError(nearest.folder, f"two of its videos are called {twice[0]}", "keep one of them there")
    without = [name for key, name in wanted.items() if key not in listed]
    spare = [name for key, name in listed.items() if key not in wanted]
    there_are = f"{_shown(nearest.folder, capture)} has pictures of {_listed(list(listed.values()))}"
    problem = f"{file} has the cameras {_listed(list(wanted.values()))}, and {there_are}"
    if shared(nearest):
        problem += f": there are none of {_listed(without)}"
        if spare:
            problem += f", and no camera for {_listed(spare)}"
    return InputError(capture, problem, "call each video, or folder of pictures, like its camera")


def _chapters(capture: Path, places: Sequence[Place], cameras: set[str]) -> InputError | None:
    """Return the error for a folder that is called like a camera and holds several videos, if there is one."""
    for place in places:
        name = place.folder.name
        if place.kind == "videos" and len(place.footage) > 1 and name.casefold() in cameras:
            files = [one.files[0].name for one in place.footage]
            problem = f"holds {len(files)} videos for the one camera that it is called like: {_listed(files)}"
            paths = [str(one.files[0].absolute()).replace("'", "'\\''") for one in place.footage]
            listed = " ".join(shlex.quote(f"file 'file:{path}'") for path in paths)
            joined = place.folder.parent / f"{name}{Path(files[0]).suffix.lower()}"
            command = f"printf '%s\\n' {listed} | ffmpeg -f concat -safe 0 -protocol_whitelist file,pipe -i - -c copy"
            cure = f"leave the one of this take there, or join chapters of one: {command} {shlex.quote(str(joined))}"
            return InputError(place.folder, problem, cure)
    return None


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:_MOST_NAMED]) + (f", ... ({len(names)} in all)" if len(names) > _MOST_NAMED else "")


def _file(path: Path, capture: Path) -> Path:
    return path.relative_to(capture) if path.is_relative_to(capture) else path


def _shown(folder: Path, capture: Path) -> str:
    return f"{folder.relative_to(capture)}/" if folder != capture else "the folder"
