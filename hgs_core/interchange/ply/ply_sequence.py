"""PLY sequences: a folder of numbered 3DGS .ply files, one for each frame, as SuperSplat plays them."""

from __future__ import annotations

import dataclasses
import itertools
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Change, most_of_any
from hgs_core.interchange.file_format import NOTHING_KNOWN, Reading, ReadSplats
from hgs_core.interchange.ply.ply_file import PLY
from hgs_core.scene.at_rest import at_rest
from hgs_core.scene.rows import rows_of

__all__ = ["frame_files", "is_sequence", "read_sequence"]

_NUMBERED = re.compile(r"(.*?)(\d+)\.ply", re.IGNORECASE)


def is_sequence(path: Path) -> bool:
    """Return whether a path stands for a folder of frames: it is one, or has no suffix."""
    return path.is_dir() or not path.suffix


def frame_files(folder: Path) -> list[Path]:
    """Return the frames of a folder, in order of their numbers.

    Raises:
        InputError: there are fewer than two, their names differ in more than the number, or one is missing.
    """
    found = {path: match for path in folder.iterdir() if (match := _NUMBERED.fullmatch(path.name))}
    names = sorted({match[1] for match in found.values()})
    if len(found) < 2 or len(names) > 1:
        has = f"has numbered .ply files that begin with {' and '.join(names)}" if names[1:] else "holds no frames"
        raise InputError(folder, has, "give a folder with one set of files like frame_0000.ply, frame_0001.ply")
    numbers = {int(match[2]): path for path, match in found.items()}
    order = sorted(numbers)
    step = order[1] - order[0]
    for number, following in itertools.pairwise(order):
        if following - number != step:
            problem = f"has frames {number} and {following}, and others {step} apart"
            raise InputError(folder, problem, "export the missing ones, or renumber them")
    return [numbers[number] for number in order]


def read_sequence(folder: Path, reading: Reading = NOTHING_KNOWN) -> ReadSplats:
    """Read the frames of a folder: splats that are in all of them are static, the others stand still for one frame.

    All frames are moved as the first one is, if its places are far from the origin.

    Raises:
        InputError: see `frame_files`; or a file is damaged or no still 3DGS .ply, or frames are drawn differently.
    """
    files = frame_files(folder)
    start = _still(files[0], reading)
    reading = dataclasses.replace(reading, middle=start.middle, centred=False)
    common: NDArray[np.void] | None = None
    changes: list[Change] = [change for change in start.changes if start.middle is not None and change.count is None]
    for file in files:
        found = _still(file, reading)
        if found.antialiased != start.antialiased:
            said = ["antialiased" if one.antialiased else "not antialiased" for one in (found, start)]
            raise InputError(file, f"is drawn {said[0]}, and {files[0].name} {said[1]}", "export the frames again")
        changes += found.changes
        rows, counts = np.unique(rows_of(found.static), return_counts=True)
        once = rows[counts == 1]
        common = once if common is None else np.intersect1d(common, once, assume_unique=True)
    assert common is not None
    first = _still(files[0], reading).static
    static = first.take(np.isin(rows_of(first), common))
    frames = []
    for file in files:
        splats = _still(file, reading).static
        frames.append(at_rest(splats.take(~np.isin(rows_of(splats), common))))
    return ReadSplats(
        static,
        tuple(frames),
        lasts=True,
        antialiased=start.antialiased,
        middle=start.middle,
        changes=most_of_any(changes),
    )


def _still(file: Path, reading: Reading) -> ReadSplats:
    assert PLY.read is not None
    found = PLY.read(file, reading)
    if found.lasts:
        raise InputError(file, "holds all times of an STGS scene, and no frame", "import it alone")
    return found
