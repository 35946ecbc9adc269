"""Frames of one camera as image files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.picture import list_folder, read_sized_picture
from hgs_core.capture.pictures.picture_cache import Neighbour
from hgs_core.capture.pictures.picture_file import has_transparency, read_header

__all__ = ["PictureSequence"]


class PictureSequence:
    """The pictures of a camera by number, all of one size."""

    def __init__(self, camera: str, files: Sequence[Path]) -> None:
        """Check that the files are there, and read the headers of all.

        Raises:
            InputError: a file is missing, empty or unreadable, or of another size than most.
        """
        listings: dict[Path, dict[str, int]] = {}
        self.files: list[tuple[Path, int]] = []  # file, bytes
        for frame, path in enumerate(files):
            if path.parent not in listings:
                listings[path.parent] = list_folder(path.parent)
            size = listings[path.parent].get(path.name)
            if size is None:
                raise InputError(path, f"camera {camera} has no picture for frame {frame}", "restore the file")
            if size == 0:
                raise InputError(path, "the file is empty", "restore the file")
            self.files.append((path, size))
        self._headers = [read_header(path) for path in files]
        self._upright = False
        self.notes: list[str] = []  # choices, for people
        self.width, self.height = self._require_alike(camera, [header.size for header in self._headers])
        if any(header.transparent for header in self._headers) and self._is_transparent():
            self.notes.append("what is transparent in the pictures is black; `mogrify -alpha off` shows what is there")
        if profiles := sorted({header.profile for header in self._headers} - {""}):
            self.notes.append(f"colours of the profile {' and '.join(profiles)} are brought to sRGB")
        if (most := max(header.pictures for header in self._headers)) > 1:
            self.notes.append(f"a file holds {most} pictures, of which the first is read")

    @property
    def upright_size(self) -> tuple[int, int]:
        """Width and height as EXIF has most pictures shown, pixels."""
        return Counter(header.upright for header in self._headers).most_common(1)[0][0]

    @property
    def orientations(self) -> frozenset[int]:
        """The orientations that EXIF gives the pictures; 1 is upright as stored."""
        return frozenset(header.orientation for header in self._headers)

    def show_upright(self, camera: str) -> None:
        """Turn pictures from now on as EXIF says.

        Raises:
            InputError: a picture is then of another size than most.
        """
        self.width, self.height = self._require_alike(camera, [header.upright for header in self._headers])
        self._upright = True

    def _require_alike(self, camera: str, sizes: Sequence[tuple[int, int]]) -> tuple[int, int]:
        usual = Counter(sizes).most_common(1)[0][0]
        for (path, _), found in zip(self.files, sizes, strict=True):
            if found != usual:
                others = f"other pictures of camera {camera} have {usual[0]}x{usual[1]}"
                raise InputError(path, f"the picture is {found[0]}x{found[1]}", others)
        return usual

    def _is_transparent(self) -> bool:
        """Look at the first, the middle and the last picture: many have an alpha channel that is full everywhere."""
        looked_at = {0, len(self.files) // 2, len(self.files) - 1}
        return any(has_transparency(self.files[index][0]) for index in looked_at)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.files)

    def read(self, index: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], tuple[Neighbour, ...]]:
        """Return frame `index` [H, W, 3]; no other is decoded on the way.

        Raises:
            InputError: the file is unreadable, or has changed.
        """
        path, size = self.files[index][0], (self.width, self.height)
        return read_sized_picture(path, size, upright=self._upright), ()
