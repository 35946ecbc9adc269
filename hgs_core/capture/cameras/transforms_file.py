"""The frames that transforms.json and its like list, with the pictures that their names mean."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.cameras.transforms_frame import INTRINSICS, number_of
from hgs_core.capture.files.named_files import NamedFiles, find_named, otherwise_named, path_as_written
from hgs_core.capture.files.text_file import read_json
from hgs_core.capture.pictures.picture import list_folder

__all__ = ["TRANSFORMS_FILE", "Frame", "missing", "read_frames", "transforms_files"]

TRANSFORMS_FILE = "transforms.json"
_MOST_NAMED = 5  # pictures that a note names
_CURE = "restore the file from its source"


@dataclass(frozen=True)
class Frame:
    """One entry of `frames`."""

    where: str
    file: Path
    values: dict[str, Any]  # its own, and intrinsics of the whole file where it has none

    @property
    def time(self) -> float | None:
        """The moment of its picture, in the file's unit; None: not given."""
        return number_of(self.values, "time", self.where) if "time" in self.values else None

    @property
    def intrinsics(self) -> str:
        """The key shared by pictures of one lens."""
        return json.dumps([self.values.get(name) for name in ("fl_x", "fl_y", "cx", "cy", "w", "h", "k1")])


def transforms_files(capture: Path) -> list[Path]:
    """Return transforms.json, or else the splits transforms_train.json and its like."""
    names = sorted(list_folder(capture))
    if whole := next((name for name in names if name.lower() == TRANSFORMS_FILE), None):
        return [capture / whole]
    return [capture / n for n in names if n.lower().startswith("transforms_") and n.lower().endswith(".json")]


def read_frames(capture: Path, files: Sequence[Path]) -> tuple[list[Frame], list[str]]:
    """Return the frames of all files, and notes on the names of their pictures.

    Raises:
        InputError: a file is unreadable, lists no frames, or names a picture outside the capture.
    """
    frames, notes = [], []
    for file in files:
        found, said = _frames(capture, file)
        frames += found
        notes += said
    return frames, notes


def missing(files: Sequence[Path], frames: Sequence[Frame]) -> tuple[str, ...]:
    """Say which of the listed pictures are not there."""
    lost = [frame.file.name for frame in frames if not frame.file.is_file()]
    if not lost:
        return ()
    named = ", ".join(lost[:_MOST_NAMED]) + (", ..." if len(lost) > _MOST_NAMED else "")
    listed = f"{len(lost)} of the {len(frames)} pictures that {files[0].name} lists"
    return (f"{listed} are not there and left out: {named}",)


def _frames(capture: Path, file: Path) -> tuple[list[Frame], list[str]]:
    meta: Any = read_json(file, _CURE)
    frames = meta.get("frames") if isinstance(meta, dict) else None
    one_file = file.name.lower() == TRANSFORMS_FILE
    if not isinstance(frames, list) or (one_file and not frames) or not all(isinstance(f, dict) for f in frames):
        raise InputError(file, "frames is not a list of objects", _CURE)
    names = [frame.get("file_path") for frame in frames]
    for number, name in enumerate(names):
        if not isinstance(name, str) or not name.strip():
            raise InputError(f"{file}, frame {number}", f"file_path is {shown(name)}", "it is the name of a picture")
    named = find_named(capture, names)
    pictures = [_picture(capture, f"{file}, frame {n}", name, named, n) for n, name in enumerate(names)]
    shared = {name: meta[name] for name in INTRINSICS if name in meta}
    listed = [
        Frame(f"{file}, frame {number}", picture, {**shared, **frame})
        for number, (picture, frame) in enumerate(zip(pictures, frames, strict=True))
    ]
    return listed, otherwise_named(file.name, named)


def _picture(capture: Path, where: str, name: str, named: NamedFiles, number: int) -> Path:
    """Return the file that was found, or the one that is missing."""
    if (found := named.files[number]) is not None:
        return found
    there = path_as_written(capture, name)
    if there is None and not named.otherwise:
        cure = "put its picture below the capture, in folders as its path ends"
        raise InputError(where, f"file_path {shown(name)} is outside the capture, and no end of it is there", cure)
    there = there or capture / f"picture {number} of another folder"
    return there if there.suffix else there.with_name(f"{there.name}.png")  # Blender's files leave it out
