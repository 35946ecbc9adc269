"""Frames of one camera as image files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.cache import Neighbour
from hgs_core.capture.picture import list_folder, picture_size, read_sized_picture

__all__ = ["PictureSequence"]


class PictureSequence:
    """The pictures of a camera by number, all of one size."""

    def __init__(self, camera: str, files: Sequence[Path]) -> None:
        """Check that the files are there, and read the headers of all.

        Raises:
            InputError: a file is missing, empty or unreadable, or of another size than most.
        """
        listings: dict[Path, dict[str, int]] = {}
        self.files: list[tuple[Path, int]] = []  # with their sizes in bytes
        for frame, path in enumerate(files):
            if path.parent not in listings:
                listings[path.parent] = list_folder(path.parent)
            size = listings[path.parent].get(path.name)
            if size is None:
                raise InputError(path, f"camera {camera} has no picture for frame {frame}", "restore the file")
            if size == 0:
                raise InputError(path, "the file is empty", "restore the file")
            self.files.append((path, size))
        self.notes: list[str] = []  # what was chosen, for people
        sizes = [picture_size(path) for path in files]
        self.width, self.height = usual = Counter(sizes).most_common(1)[0][0]
        for path, found in zip(files, sizes, strict=True):
            if found != usual:
                others = f"other pictures of camera {camera} have {usual[0]}x{usual[1]}"
                raise InputError(path, f"the picture is {found[0]}x{found[1]}", others)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.files)

    def read(self, index: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], tuple[Neighbour, ...]]:
        """Return frame `index` [H, W, 3]; no other is decoded on the way.

        Raises:
            InputError: the file is unreadable, or has changed.
        """
        return read_sized_picture(self.files[index][0], (self.width, self.height)), ()
